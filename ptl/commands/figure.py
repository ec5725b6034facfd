"""``ptl figure``: the figures of the report, one subcommand for each kind."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import click

_Value = TypeVar("_Value")

FILE = click.Path(dir_okay=False, path_type=Path)

OUTPUT = click.option(
    "--output",
    required=True,
    type=FILE,
    help="PNG to write; an SVG and a CSV of the numbers get the same name.",
)
CONFIDENCE = click.option(
    "--confidence",
    default=0.95,
    show_default=True,
    type=click.FloatRange(0, 1, True, True),
    help="Level of intervals.",
)
TITLE = click.option("--title", help="Name of the environment to print.")
TITLES = click.option("--title", "titles", multiple=True, metavar="NAME=TEXT", help="Title of an environment; repeat.")


@click.group()
def command() -> None:
    """Draw one figure; each is a PNG with an SVG twin and the plotted numbers as CSV."""


@command.command("map")
@click.argument("map_path", metavar="MAP", type=FILE)
@TITLE
@OUTPUT
def map_(map_path: Path, title: str | None, output: Path) -> None:
    """Draw a map with its start and goals (figures 5 to 7)."""
    from ptl.figures import maps, style
    from ptl.gridworld import load_map

    world = load_map(map_path)
    style.save(maps.draw(world, title or map_path.stem), maps.places(world), output)


@command.command("prior")
@click.argument("map_path", metavar="MAP", type=FILE)
@click.option("--goal", required=True, help="Goal letter.")
@click.option("--form", default="exponential", show_default=True, help="Form of the prior.")
@click.option("--width", default=0.1, show_default=True, help="Width of the prior as a share of the map's diagonal.")
@TITLE
@OUTPUT
def prior(map_path: Path, goal: str, form: str, width: float, title: str | None, output: Path) -> None:
    """Draw the prior of a skill by where it ends, for one goal (figure 3)."""
    from ptl.figures import prior as figure
    from ptl.figures import style
    from ptl.gridworld import load_map
    from ptl.parameters import Skills

    checked = Skills(prior_form=form, prior_width=width)
    world = load_map(map_path)
    frame = figure.relative_prior(world, goal, checked.prior_form, checked.prior_width)
    style.save(figure.draw(world, frame, title or map_path.stem), frame, output)


@command.command("misleading-prior")
@click.argument("files", nargs=-1, type=FILE)
@click.option("--task", help="Task whose selection is drawn; the last one if left out.")
@click.option("--episodes", default=60, show_default=True, type=click.IntRange(2), help="Episodes to show.")
@CONFIDENCE
@OUTPUT
def misleading_prior(
    files: tuple[Path, ...],
    task: str | None,
    episodes: int,
    confidence: float,
    output: Path,
) -> None:
    """Draw how the likelihood overrules the prior, from learning FILES of ptl on a small map (figure 4)."""
    from ptl.figures import misleading_prior as figure
    from ptl.figures import style
    from ptl.files import expand_numbers

    selections = figure.collect(expand_numbers(files), task, confidence)
    style.save(figure.draw(selections, episodes), selections.frame, output)


@command.command("frequencies")
@click.argument("files", nargs=-1, type=FILE)
@TITLES
@OUTPUT
def frequencies(files: tuple[Path, ...], titles: tuple[str, ...], output: Path) -> None:
    """Draw subgoal selection frequencies, one panel for each of the FILES (figure 8)."""
    from ptl.figures import frequencies as figure
    from ptl.figures import style
    from ptl.files import expand_numbers

    items = figure.read(expand_numbers(files))
    frame = figure.frequency_frame(items)
    style.save(figure.draw(items, frame, _named(titles, str)), frame, output)


@command.command("discovery")
@click.argument("files", nargs=-1, type=FILE)
@click.option("--tasks", required=True, help="Tasks to show, e.g. DEF.")
@TITLE
@OUTPUT
def discovery(files: tuple[Path, ...], tasks: str, title: str | None, output: Path) -> None:
    """Draw both metrics of subgoal discovery, mean over the learning FILES of all seeds (figures 9 to 11)."""
    from ptl.figures import discovery as figure
    from ptl.figures import style
    from ptl.files import expand_numbers

    discoveries = figure.collect(expand_numbers(files), tasks)
    style.save(figure.draw(discoveries, title or discoveries.environment), discoveries.frame, output)


@command.command("curves")
@click.argument("steps_path", metavar="STEPS", type=FILE)
@click.option("--map", "maps", multiple=True, required=True, metavar="NAME=MAP",
              help="Environment to show and its map; repeat for more panels.")  # fmt: skip
@click.option("--task", "tasks", multiple=True, metavar="NAME=LETTER",
              help="Task of an environment; the last goal of its map if left out; repeat.")  # fmt: skip
@click.option("--method", "methods", multiple=True, help="Method to show; repeat. The article's four if left out.")
@TITLES
@CONFIDENCE
@OUTPUT
def curves(
    steps_path: Path,
    maps: tuple[str, ...],
    tasks: tuple[str, ...],
    methods: tuple[str, ...],
    titles: tuple[str, ...],
    confidence: float,
    output: Path,
) -> None:
    """Draw steps per episode of methods from the file STEPS, one panel per environment (figure 12)."""
    from ptl.figures import curves as figure
    from ptl.figures import style
    from ptl.figures.steps import open_steps
    from ptl.gridworld import load_map

    worlds = _named(maps, load_map)
    letters = {name: figure.last_task(world) for name, world in worlds.items()} | _named(tasks, str)
    with open_steps(steps_path) as steps:
        frame = figure.curves(steps, worlds, letters, methods or figure.METHODS, confidence)
    style.save(figure.draw(frame, _named(titles, str)), frame, output)


@command.command("measures")
@click.argument("steps_path", metavar="STEPS", type=FILE)
@click.option("--map", "named_map", required=True, metavar="NAME=MAP", help="Environment to show and its map.")
@click.option("--task", help="Task to show; the last goal of the map if left out.")
@click.option("--method", default="ptl", show_default=True, help="Method to show beside the base.")
@click.option("--base", default="no_transfer", show_default=True, help="Method it is compared with.")
@click.option("--window", default=10, show_default=True, type=click.IntRange(1), help="Episodes of a mean.")
@click.option("--threshold-factor", default=1.5, show_default=True, type=click.FloatRange(1),
              help="Threshold as a multiple of the shortest path.")  # fmt: skip
@TITLE
@OUTPUT
def measures(
    steps_path: Path,
    named_map: str,
    task: str | None,
    method: str,
    base: str,
    window: int,
    threshold_factor: float,
    title: str | None,
    output: Path,
) -> None:
    """Draw what the measures of transfer are, on curves of the file STEPS (figure 13)."""
    from ptl.figures import measures as figure
    from ptl.figures import style
    from ptl.figures.steps import open_steps
    from ptl.gridworld import load_map

    [(environment, world)] = _named((named_map,), load_map).items()
    letter = task or list(world.goals)[-1]
    shortest = world.shortest_path_length(world.start, world.goal(letter))
    with open_steps(steps_path) as steps:
        frame = figure.measures(steps, environment, letter, (base, method), shortest, window, threshold_factor)
    style.save(figure.draw(frame, f"{title or environment}, task {letter}"), frame, output)


@command.command("growth")
@click.argument("growth_path", metavar="GROWTH", type=FILE)
@click.option("--breakpoint", "bend", default=7.0, show_default=True, help="Tasks at which the slope may change.")
@CONFIDENCE
@OUTPUT
def growth(growth_path: Path, bend: float, confidence: float, output: Path) -> None:
    """Draw the library size against the number of tasks from the table GROWTH (figure 14)."""
    from ptl.figures import growth as figure
    from ptl.figures import style

    tasks, sizes = figure.read_growth(growth_path)
    frame = figure.growth_frame(tasks, sizes, bend, confidence)
    style.save(figure.draw(frame), frame, output)


@command.command("library-cost")
@click.argument("selection_path", metavar="SELECTION", type=FILE)
@click.argument("storage_path", metavar="STORAGE", type=FILE)
@OUTPUT
def library_cost(selection_path: Path, storage_path: Path, output: Path) -> None:
    """Draw time and room of a library from two tables (columns skills, seconds and states, skills, bytes)."""
    from ptl.figures import library_cost as figure
    from ptl.figures import style

    selection = figure.read(selection_path, figure.SELECTION_COLUMNS)
    storage = figure.read(storage_path, figure.STORAGE_COLUMNS)
    frame = figure.cost_frame(selection, storage)
    style.save(figure.draw(frame), frame, output)


def _named(pairs: tuple[str, ...], convert: Callable[[str], _Value]) -> dict[str, _Value]:
    """Values of options of the form NAME=VALUE, by name."""
    from ptl.errors import UserError

    values = {}
    for pair in pairs:
        name, separator, value = pair.partition("=")
        if not (name and separator and value):
            raise UserError(f"option value {pair!r}: give a name, an equals sign and a value, e.g. env1=env1.txt")
        values[name] = convert(value)
    return values
