"""Measure how the cost grows with states, skills and tasks."""

import sys
from pathlib import Path

from ptl.benchmark import machine, pages, scaling
from ptl.files.atomic import write_text
from ptl.report.figures import saving
from ptl.report.figures import scaling as figure
from ptl.report.script import running


def say(line: str) -> None:
    """Write a line of progress to the log."""
    print(line, file=sys.stderr, flush=True)


with running(snakemake) as script:
    computer = machine.describe()
    growth = scaling.measure(Path(script.input.map), scaling.Plan(), say)
    saving.save(figure.draw(growth), growth, script.output.png)
    write_text(Path(script.output.page), pages.scaling_markdown(computer, growth))
