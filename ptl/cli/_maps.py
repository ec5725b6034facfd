"""Options of commands that read maps, and what the reader chose."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any, TypeVar, get_args

import click

from ptl.config import MapFormat, MapOptions

if TYPE_CHECKING:
    from pathlib import Path

    from ptl.world.gridworld import GridWorld

Function = TypeVar("Function", bound=Callable[..., Any])


class Cell(click.ParamType):
    """A cell as ROW,COLUMN, counted from 1."""

    name = "ROW,COLUMN"

    def convert(self, value: Any, parameter: click.Parameter | None, context: click.Context | None) -> list[int]:
        parts = value.split(",")
        if len(parts) == 2 and all(part.strip().isascii() and part.strip().isdigit() for part in parts):
            return [int(part) for part in parts]
        self.fail(f"{value!r:.60} is not allowed; give ROW,COLUMN, counted from 1", parameter, context)


OPTIONS = (
    click.option("--start", type=Cell(), help="Start of the map, counted from 1, instead of that in the file."),
    click.option("--goal", "goals", multiple=True, type=Cell(),
                 help="Goal A; repeat it for B, C, ... These replace the goals in the file."),
    click.option("--map-seed", type=click.IntRange(0, 2**63 - 1),
                 help="Seed with which a start and goals are drawn that nothing else gives (default 0)."),
    click.option("--cell", type=click.FloatRange(0, 1e6), default=0.0,
                 help="Metres of a cell of a ROS map; a cell is free if all of its pixels are."),
    click.option("--slip", type=click.FloatRange(0, 1), default=0.0,
                 help="Probability that a step goes in a random direction (default 0)."),
    click.option("--format", "map_format", type=click.Choice(get_args(MapFormat)),
                 help="Format of the map, if its content can be read in several ways."),
)  # fmt: skip


def map_options(function: Function) -> Function:
    """Add the options to a command, which gets them as ``options``, a `MapOptions` (a decorator)."""

    def command(
        *arguments: Any,
        start: Any,
        goals: Any,
        map_seed: int | None,
        cell: float,
        slip: float,
        map_format: Any,
        **rest: Any,
    ) -> Any:
        options = MapOptions(start=start, goals=list(goals), seed=map_seed, cell=cell, slip=slip, format=map_format)
        return function(*arguments, options=options, **rest)

    command.__doc__ = function.__doc__
    for option in reversed(OPTIONS):
        command = option(command)
    # options that were declared before
    command.__click_params__ += getattr(function, "__click_params__", [])  # type: ignore[attr-defined]
    return command  # type: ignore[return-value]


def read_maps(paths: Iterable[Path], options: MapOptions) -> list[GridWorld]:
    """Read maps and print what the reader chose; a start or goals are those of one map.

    Raises
    ------
    UserError
    """
    from ptl.errors import UserError
    from ptl.world.map_files import read_map

    paths, worlds = list(paths), []
    if len(paths) > 1 and (options.start or options.goals):
        raise UserError(f"--start and --goal are for one map, and {len(paths)} are named; name one")
    for path in paths:
        world, notes = read_map(path, options)
        for note in notes:
            click.echo(f"note: {note}", err=True)
        worlds.append(world)
    return worlds
