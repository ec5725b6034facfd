"""``ptl inspect``: print the contents of a result file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from ptl.files.store import Result
    from ptl.world.gridworld import GridWorld


@click.command()
@click.argument("files", nargs=-1, required=True, type=click.Path(path_type=Path))
def command(files: tuple[Path, ...]) -> None:
    """Print the job of each of the FILES, a summary of its content, and its map with the subgoals as 1, 2, 3 ..."""
    from ptl.errors import printable
    from ptl.files.store import read
    from ptl.jobs import Learn, Survey
    from ptl.jobs.kinds import register_studies
    from ptl.jobs.learn import skills_of

    register_studies()
    for path in files:
        result = read(path)
        click.echo(printable(f"{path}  ({result.job.kind})"))
        _show_job(result)
        if isinstance(result.job, Learn):
            _show_tasks(result)
        elif isinstance(result.job, Survey):
            _show_counts(result)
        else:
            for name, values in result.arrays.items():
                click.echo(f"  {name:<40} {' x '.join(map(str, values.shape)):>16}  {values.dtype}")
        if (skills := skills_of(result.arrays)) is not None:
            click.echo(_picture(result.world, [skill.subgoal for skill in skills]))


def _show_job(result: Result) -> None:
    import msgspec

    from ptl.errors import printable

    values = msgspec.to_builtins(result.job)
    parameters = values.pop("parameters")
    values["versions"] = ", ".join(f"{name} {version}" for name, version in result.versions.items())
    for group in parameters:
        values[group] = ", ".join(f"{name} {value}" for name, value in parameters[group].items())
    for name, value in values.items():
        if name != "kind":
            click.echo(printable(f"  {name:<12} {value}"))
    click.echo("")


def _show_tasks(result: Result) -> None:
    from ptl.errors import printable
    from ptl.jobs.learn import tasks_in

    click.echo("  task  shortest    first   last 10       total  truncated  subgoal (row, column)")
    world = result.world
    for name, task in tasks_in(result).items():
        steps = task.steps
        subgoal = printable(task.reason)
        if task.subgoal >= 0:
            row, column = world.cells[task.subgoal]
            subgoal = f"({row}, {column})"
        shortest = world.shortest_path_length(task.start, task.goal)
        click.echo(
            f"  {name:<4} {shortest:>9} {steps[0]:>8} {steps[-10:].mean():>9.1f} {steps.sum():>11}"
            f" {int(task.truncated.sum()):>10}  {subgoal}"
        )
    click.echo("")


def _show_counts(result: Result) -> None:
    from ptl.text import number, percent

    counts, pairs = result.arrays["counts"], int(result.arrays["pairs"])
    click.echo(f"  {number(pairs)} pairs of start and goal; most frequent subgoals (row, column):")
    for state in counts.argsort()[::-1][:10]:
        row, column = result.world.cells[state]
        click.echo(f"  ({row}, {column})  {number(counts[state])}  {percent(counts[state] / pairs)}")
    click.echo("")


def _picture(world: GridWorld, subgoals: list[int]) -> str:
    rows = [list(line) for line in world.text.splitlines()]
    for number, subgoal in enumerate(subgoals, start=1):
        row, column = world.cells[subgoal]
        rows[row][column] = str(number) if number < 10 else "*"
    return "\n".join("  " + "".join(row).replace("#", "█").replace(".", "·") for row in rows) + "\n"
