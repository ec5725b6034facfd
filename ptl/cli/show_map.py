"""``ptl show-map``: check a map and print its states, tasks and distances."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from ptl.cli._maps import map_options, read_maps

if TYPE_CHECKING:
    from ptl.config import MapOptions

MAX_SHOWN = 200
"""Maximum number of rows and columns of a map that is printed."""


@click.command()
@click.argument("maps", nargs=-1, required=True, type=click.Path(path_type=Path))
@map_options
def command(maps: tuple[Path, ...], options: MapOptions) -> None:
    """Check MAPS and print each with its states, tasks and shortest paths.

    Maps are texts of this package, Moving AI .map (with its .scen), ROS map_server (.yaml or .pgm), labmaze,
    FrozenLake, PointMaze and maze2d.
    """
    from ptl.world.optimum import optimal_steps

    for path, world in zip(maps, read_maps(maps, options), strict=True):
        rows, columns = world.shape
        click.echo(f"{path}: {rows} x {columns} cells, {world.n_states} states, diagonal {world.diagonal:.1f}")
        click.echo(world.text if max(rows, columns) <= MAX_SHOWN else "the map is too large to be printed")
        row, column = world.cells[world.start] + 1
        click.echo("places as row and column, counted from 1:")
        click.echo(f"start I  at row {row}, column {column}")
        distance = world.distances_to(world.start)
        for letter, goal in world.goals.items():
            row, column = world.cells[goal] + 1
            steps = f"{distance[goal]} step{'s' if distance[goal] > 1 else ''} from the start"
            if world.slip:
                steps += f", {optimal_steps(world, goal)[world.start]:.1f} on average with slip {world.slip}"
            click.echo(f"goal  {letter}  at row {row}, column {column}, {steps}")
