"""``ptl new-study``: a folder in which the workflow runs on a user's maps."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ptl.cli._maps import map_options, read_maps

if TYPE_CHECKING:
    from ptl.config import MapOptions


@click.command()
@click.argument("folder", type=click.Path(path_type=Path))
@click.option("--map", "maps", multiple=True, type=click.Path(path_type=Path),
              help="File of a map; repeat it for several. Its environment is called after the file.")  # fmt: skip
@click.option("--tasks", multiple=True,
              help="Goal letters in the order of learning, for every map (BAC) or for one (maze=BAC);"
                   " by default all goals in alphabetical order.")  # fmt: skip
@click.option("--seeds", type=click.IntRange(1), help="Learning runs per environment and method (default 30).")
@click.option("--episodes", type=click.IntRange(1), help="Episodes of each task (default 200).")
@click.option("--method", "methods", multiple=True,
              help="Method to compare: a built-in name, a file that ends in .py (it is copied), or"
                   " package.module:Class; repeat it for several. By default all built-in methods.")  # fmt: skip
@click.option("--survey", is_flag=True,
              help="Count subgoals over all pairs of start and goal, too; slow on large maps.")  # fmt: skip
@click.option("--growth", is_flag=True,
              help="Grow a library over random tasks, too; slow on large maps.")  # fmt: skip
@map_options
@click.option("--population", metavar="BAND",
              help="Instead of maps of your own, those of the second study: tuning or test.")  # fmt: skip
@click.option("--maps-per-family", type=click.IntRange(1), help="With --population: the first maps of each family.")
@click.option("--lives", multiple=True, type=click.Path(path_type=Path),
              help="With --population: CSV file like reports/beyond/per_life.csv: methods that need not be run;"
                   " repeat it for several.")  # fmt: skip
def command(
    folder: Path,
    maps: tuple[Path, ...],
    tasks: tuple[str, ...],
    seeds: int | None,
    episodes: int | None,
    methods: tuple[str, ...],
    population: str | None,
    maps_per_family: int | None,
    lives: tuple[Path, ...],
    survey: bool,
    growth: bool,
    options: MapOptions,
) -> None:
    """Make FOLDER, in which `snakemake -j2` compares methods on your own maps or on those of the second study.

    Maps, tasks and methods are checked before anything is written.
    """
    from ptl.config import MapOptions
    from ptl.deployment import new_study
    from ptl.errors import UserError
    from ptl.learning.trial import colour_notes
    from ptl.measures.measures import BASE
    from ptl.report.config_page import tables

    place = shlex.quote(str(folder))
    for option, given, needed in (
        ("--population", population, not maps), ("--map", maps, not population),
        ("--tasks", tasks, not population), ("--maps-per-family", maps_per_family, population),
        ("--lives", lives, population), ("--survey", survey, not population), ("--growth", growth, not population),
        ("--start, --goal, --map-seed, --cell, --slip, --format", options != MapOptions(), not population),
    ):  # fmt: skip
        if given and not needed:
            raise UserError(f"{option}: give either --map, or --population with --maps-per-family and --lives")
    if population:
        from ptl.jobs.kinds import modules_of_studies

        makers = modules_of_studies("new_study")
        if not makers:
            raise UserError("--population: there is no study of a population of maps here; give --map")
        config = makers[0].new_population_study(
            folder, population, maps=maps_per_family, seeds=seeds, episodes=episodes, chosen=methods, lives=lives
        )
        click.echo(f"methods to run: {', '.join(config['methods']) or 'none'}")
        click.echo(f"run it: cd {place} && snakemake -j2; then open reports/{config['run']}/index.html")
        return
    if not maps:
        raise UserError("--map: name the file of a map, or --population for the maps of the second study")
    worlds = read_maps(maps, options)
    config = new_study(
        folder, worlds, tasks=tasks, seeds=seeds, episodes=episodes, chosen=methods, survey=survey, growth=growth
    )
    with (folder / "config/README.md").open("a", encoding="utf-8") as file:
        file.write(tables())
    for name, entry in config["environments"].items():
        click.echo(f"environment {name}: tasks {', '.join(entry['tasks'])}")
    click.echo(f"methods: {', '.join(config['methods'])}")
    if BASE not in config["methods"]:
        click.echo(f"note: without {BASE} there is no jump start and no transfer ratio; add it for comparisons")
    for note in colour_notes(methods):
        click.echo(f"note: {note}")
    if episodes is not None and "measures" in config:
        click.echo(f"note: measures.window is {config['measures']['window']}, because a task has no more episodes")
    click.echo(f"run it: cd {place} && snakemake -j2; then open reports/{config['run']}/index.html")
