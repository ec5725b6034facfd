"""``ptl benchmark``: what the package costs on this machine."""

from __future__ import annotations

import sys
from pathlib import Path

import click

FILE = click.Path(dir_okay=False, path_type=Path)
LOG_FOLDER = Path(".snakemake/log")


def say(text: str) -> None:
    """Progress goes to stderr, which is the log of a rule."""
    print(text, file=sys.stderr, flush=True)


@click.group()
def command() -> None:
    """Measure speed and growth of the cost; the numbers hold for this machine."""


@command.command()
@click.option("--map", "map_path", required=True, type=FILE, help="Map of the task that is learned.")
@click.option("--task", "letter", required=True, help="Goal letter of the task.")
@click.option("--rounds", default=15, show_default=True, type=click.IntRange(1), help="Rounds over all learners.")
@click.option("--jobs", default=5, show_default=True, type=click.IntRange(1), help="Learning jobs of each method.")
@click.option("--method", "methods", multiple=True, required=True, help="Method whose jobs are timed; repeat.")
@click.option(
    "--learning-jobs", required=True, type=click.IntRange(1), help="Learning jobs of a whole run, to find its log."
)
@click.option("--output", required=True, type=FILE, help="Markdown to write; a CSV gets the same name.")
def speed(
    map_path: Path,
    letter: str,
    rounds: int,
    jobs: int,
    methods: tuple[str, ...],
    learning_jobs: int,
    output: Path,
) -> None:
    """Compare the kernel with other learners, and take a learning job and a whole run apart."""
    from ptl.benchmark import machine, pages, run_log, startup
    from ptl.benchmark import speed as contest
    from ptl.benchmark.contestants import check_installed
    from ptl.benchmark.task import Task
    from ptl.files import write_csv, write_text
    from ptl.gridworld import load_map

    check_installed()
    computer = machine.describe()
    world = load_map(map_path)
    task = Task(world.successors, world.start, world.goal(letter))
    say("learners")
    rates = contest.summarise(contest.measure(task, rounds, say=say))
    say("learning jobs")
    phases = startup.summarise(startup.measure(map_path, methods, jobs))
    log = run_log.newest_whole_run(LOG_FOLDER, learning_jobs)
    rules = run_log.summarise(run_log.read_run(log)) if log else None
    name = f"The run of {log.name.partition('.')[0].replace('T', ', ')}" if log else ""
    page = pages.benchmark_markdown(computer, rates, phases, rules, place=map_path.stem, letter=letter, log=name)
    write_text(output, page)
    write_csv(pages.benchmark_csv(computer, rates, phases, rules), output.with_suffix(".csv"))


@command.command()
@click.option("--map", "map_path", required=True, type=FILE, help="Map of the life of many tasks.")
@click.option("--small", is_flag=True, help="A trial with small sizes.")
@click.option("--output", required=True, type=FILE, help="PNG to write; SVG, CSV and Markdown get the same name.")
def scaling(map_path: Path, small: bool, output: Path) -> None:
    """Measure how the cost grows with states, skills and tasks."""
    from ptl.benchmark import machine, pages
    from ptl.benchmark import scaling as growth
    from ptl.figures import scaling as figure
    from ptl.figures import style
    from ptl.files import write_text

    computer = machine.describe()
    frame = growth.measure(map_path, growth.SMALL if small else growth.Plan(), say)
    style.save(figure.draw(frame), frame, output)
    write_text(output.with_suffix(".md"), pages.scaling_markdown(computer, frame))
