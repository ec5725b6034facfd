"""Measure how the cost grows with states, skills and tasks."""

import sys
from pathlib import Path

from ptl.benchmark import machine, pages, scaling
from ptl.files.atomic import write_text
from ptl.report.figures import scaling as figure
from ptl.report.figures import style
from ptl.report.job import running


def say(line: str) -> None:
    """Write a line of progress to the log."""
    print(line, file=sys.stderr, flush=True)


with running(snakemake) as job:
    computer = machine.describe()
    growth = scaling.measure(Path(job.input.map), scaling.Plan(), say)
    style.save(figure.draw(growth), growth, job.output.png)
    write_text(Path(job.output.page), pages.scaling_markdown(computer, growth))
