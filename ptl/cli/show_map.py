"""``ptl show-map``: check a map and print its states, tasks and distances."""

from __future__ import annotations

from pathlib import Path

import click


@click.command()
@click.argument("maps", nargs=-1, required=True, type=click.Path(path_type=Path))
def command(maps: tuple[Path, ...]) -> None:
    """Check MAPS and print each with its states, tasks and shortest paths."""
    from ptl.world.gridworld import load_map

    for path in maps:
        world = load_map(path)
        rows, columns = world.shape
        click.echo(f"{path}: {rows} x {columns} cells, {world.n_states} states, diagonal {world.diagonal:.1f}")
        click.echo(world.text)
        row, column = world.cells[world.start]
        click.echo("places as row and column, counted from 0:")
        click.echo(f"start I  at row {row}, column {column}")
        for letter, goal in world.goals.items():
            row, column = world.cells[goal]
            steps = world.shortest_path_length(world.start, goal)
            click.echo(f"goal  {letter}  at row {row}, column {column}, {steps} steps from the start")
