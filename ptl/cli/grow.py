"""``ptl grow``: one growth job, a life of many tasks with random starts and goals."""

from __future__ import annotations

import click

from ptl.cli._arguments import SEED


@click.command()
@click.option("--map", "map_path", required=True, type=click.Path(), help="Text file of the map.")
@click.option("--environment", required=True, help="Name of the environment.")
@click.option("--tasks", required=True, type=click.IntRange(1, 10**5), help="Tasks in the life.")
@click.option("--run", required=True, type=SEED, help="Number of the life.")
@click.option("--root-seed", required=True, type=SEED, help="Seed from which all streams derive.")
@click.option("--parameters", default="{}", help="Hyper-parameters as JSON; missing ones take their defaults.")
@click.option("--output", required=True, type=click.Path(), help="HDF5 file to write.")
def command(
    map_path: str, environment: str, tasks: int, run: int, root_seed: int, parameters: str, output: str
) -> None:
    """Let a skill library grow over random tasks, starting empty, under the method ptl."""
    from ptl.cli._progress import shown
    from ptl.config import Parameters
    from ptl.files.provenance import code_digest
    from ptl.files.results import write_growth
    from ptl.learning.growth import METHOD, grow_library
    from ptl.world.gridworld import load_map

    chosen = Parameters.from_json(parameters)
    world = load_map(map_path)
    life = grow_library(
        world, tasks, chosen, root_seed, environment, run, watch=lambda drawn: shown(drawn, "Learning tasks")
    )
    origin = {
        "environment": environment,
        "method": METHOD,
        "seed": run,
        "root_seed": root_seed,
        "parameters": chosen.to_dict(),
        "code": code_digest("ptl.learning.growth", f"ptl.methods.{METHOD}"),
    }
    write_growth(output, life, world, origin)
