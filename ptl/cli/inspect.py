"""``ptl inspect``: print the contents of a result file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from ptl.files.results import LearningFile, ResultFile
    from ptl.world.gridworld import GridWorld


@click.command()
@click.argument("files", nargs=-1, required=True, type=click.Path(path_type=Path))
def command(files: tuple[Path, ...]) -> None:
    """Print the origin of each of the FILES, a summary of its tasks, and its map with the subgoals as 1, 2, 3 ..."""
    from ptl.files.results import LearningFile, open_result

    for path in files:
        with open_result(path) as result:
            click.echo(f"{path}  ({result.format})")
            for name in ("environment", "method", "seed", "trajectories", "root_seed", "code"):
                if name in result.file.attrs:
                    click.echo(f"  {name:<12} {result.file.attrs[name]}")
            click.echo("  versions     " + ", ".join(f"{k} {v}" for k, v in result.versions.items()))
            for group, values in result.parameters.items():
                click.echo(f"  {group:<12} " + ", ".join(f"{key} {value}" for key, value in values.items()))
            click.echo("")
            if isinstance(result, LearningFile):
                _show_tasks(result)
            elif "library_size" in result.file:
                sizes = result.file["library_size"][()].tolist()
                click.echo("  skills after each task: " + " ".join(map(str, sizes[1:])))
            else:
                _show_counts(result)
            if result.library is not None:
                click.echo(_picture(result.world, [skill.subgoal for skill in result.library]))


def _show_tasks(result: LearningFile) -> None:
    click.echo("  task  shortest    first   last 10       total  truncated  subgoal (row, column)")
    world = result.world
    for name, task in result.tasks.items():
        steps = task.steps
        subgoal = task.reason
        if task.subgoal >= 0:
            row, column = world.cells[task.subgoal]
            subgoal = f"({row}, {column})"
        shortest = world.shortest_path_length(task.start, task.goal)
        click.echo(
            f"  {name:<4} {shortest:>9} {steps[0]:>8} {steps[-10:].mean():>9.1f} {steps.sum():>11}"
            f" {int(task.truncated.sum()):>10}  {subgoal}"
        )
    click.echo("")


def _show_counts(result: ResultFile) -> None:
    from ptl.text import number, percent

    counts = result.file["counts"][()]
    pairs = int(result.file["pairs"][()])
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
