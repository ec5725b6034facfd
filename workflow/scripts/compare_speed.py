"""Compare the kernel with other learners, and measure a learning job and a whole run phase by phase."""

import sys
from pathlib import Path

from ptl.benchmark import machine, pages, run, speed, startup
from ptl.benchmark.contestants import check_installed
from ptl.benchmark.task import Task
from ptl.files.atomic import write_text
from ptl.files.csv import write_csv
from ptl.report.job import running
from ptl.world.gridworld import load_map


def say(line: str) -> None:
    """Write a line of progress to the log."""
    print(line, file=sys.stderr, flush=True)


with running(snakemake) as job:
    check_installed()
    computer = machine.describe()
    path, letter, config = Path(job.input.map), snakemake.params.task, snakemake.params.config
    rates = speed.summarise(speed.measure(Task(load_map(path), letter), rounds=15, say=say))
    say("learning jobs")
    phases = startup.summarise(startup.measure(path, config["methods"], repeats=5))
    say("a whole run")
    rules = run.summarise(run.measure(Path.cwd(), config))
    page = pages.benchmark_markdown(computer, rates, phases, rules, place=path.stem, letter=letter)
    write_text(Path(job.output.page), page)
    write_csv(pages.benchmark_csv(computer, rates, phases, rules), Path(job.output.table))
