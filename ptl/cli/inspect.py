"""``ptl inspect``: print the contents of a result file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from ptl.files.hdf5 import Node
    from ptl.files.results import LearningFile, ResultFile
    from ptl.world.gridworld import GridWorld


@click.command()
@click.argument("files", nargs=-1, required=True, type=click.Path(path_type=Path))
def command(files: tuple[Path, ...]) -> None:
    """Print the origin of each of the FILES, a summary of its content, and its map with the subgoals as 1, 2, 3 ..."""
    from ptl.errors import printable
    from ptl.files.results import LearningFile, ResultFile, read_whole
    from ptl.files.schema import KINDS

    for path in files:
        result = read_whole(path)
        content = result.file if isinstance(result, ResultFile) else result
        kind = KINDS[content.attrs["format"]]
        click.echo(printable(f"{path}  ({kind.format})"))
        click.echo(f"  {kind.root.meaning}")
        _show_origin(content)
        click.echo("")
        if not isinstance(result, ResultFile):
            _show_arrays(content, "")
            continue
        if isinstance(result, LearningFile):
            _show_tasks(result)
        elif "library_size" in result.file:
            click.echo("  skills after each task: " + " ".join(map(str, result.file["library_size"][1:])))
        else:
            _show_counts(result)
        if result.library is not None:
            click.echo(_picture(result.world, [skill.subgoal for skill in result.library]))


def _show_origin(content: Node) -> None:
    from ptl.errors import printable

    for name, value in content.attrs.items():
        if name in ("environment", "method", "seed", "trajectories", "root_seed", "code", "arm", "setting", "status"):
            click.echo(printable(f"  {name:<12} {value}"))
    versions = content.attrs["versions"]
    click.echo(printable("  versions     " + ", ".join(f"{name} {version}" for name, version in versions.items())))
    for group, values in content.attrs.get("parameters", {}).items():
        listed = values if isinstance(values, dict) else {"": values}
        click.echo(printable(f"  {group:<12} " + ", ".join(f"{name} {value}" for name, value in listed.items())))


def _show_arrays(node: Node, where: str) -> None:
    from ptl.files.hdf5 import Node

    for name, item in node.items():
        if isinstance(item, Node):
            _show_arrays(item, f"{where}{name}/")
        else:
            click.echo(f"  {where + name:<40} {' x '.join(map(str, item.shape)):>16}  {item.dtype}")


def _show_tasks(result: LearningFile) -> None:
    from ptl.errors import printable

    click.echo("  task  shortest    first   last 10       total  truncated  subgoal (row, column)")
    world = result.world
    for name, task in result.tasks.items():
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


def _show_counts(result: ResultFile) -> None:
    from ptl.text import number, percent

    counts = result.file["counts"]
    pairs = int(result.file["pairs"])
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
