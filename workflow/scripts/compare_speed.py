"""Compare the kernel with other learners and figure 8 by two methods; take a learning job and a whole run apart."""

import json
import sys
from pathlib import Path

from ptl.benchmark import figure8, machine, pages, run, speed, startup
from ptl.benchmark.contestants import check_installed
from ptl.benchmark.task import Task
from ptl.files.atomic import write_text
from ptl.files.csv import write_csv
from ptl.report.script import running
from ptl.world.gridworld import load_map


def say(line: str) -> None:
    """Write a line of progress to the log."""
    print(line, file=sys.stderr, flush=True)


with running(snakemake) as script:
    check_installed()
    computer = machine.describe()
    path, letter, config = Path(script.input.map), snakemake.params.task, snakemake.params.config
    measured = speed.measure(Task(load_map(path), letter), rounds=11, say=say)
    maps = {name: Path(entry["map"]) for name, entry in config["environments"].items()}
    trajectories = config["subgoal_frequencies"]["trajectories"]
    surveys = figure8.measure(maps, trajectories, json.dumps({"learning": config["learning"]}), say=say)
    say("learning jobs")
    phases = startup.measure(path, config["methods"], repeats=5)
    say("a whole run")
    parts = {
        "speed": speed.summarise(measured),
        "limit": speed.summarise_limits(measured),
        "survey": figure8.summarise(surveys),
        "startup": startup.summarise(phases),
        "run": run.summarise(run.measure(Path.cwd(), config)),
    }
    write_text(Path(script.output.page), pages.benchmark_markdown(computer, **parts, place=path.stem, letter=letter))
    write_csv(pages.benchmark_csv(computer, **parts), Path(script.output.table))
