"""``ptl learn``: one learning job, a life of tasks under one method with one seed."""

from __future__ import annotations

import click


@click.command()
@click.option("--map", "map_path", required=True, type=click.Path(), help="Text file of the map.")
@click.option("--environment", required=True, help="Name of the environment in files and tables.")
@click.option("--tasks", required=True, help="Goal letters in the order of the tasks, e.g. ABCDEF.")
@click.option("--method", required=True, help="Identifier of the method.")
@click.option("--seed", required=True, type=click.IntRange(0), help="Number of the run.")
@click.option("--root-seed", required=True, type=click.IntRange(0), help="Seed from which all streams derive.")
@click.option("--parameters", default="{}", help="Hyper-parameters as JSON; missing ones take their defaults.")
@click.option("--output", required=True, type=click.Path(), help="HDF5 file to write.")
def command(
    map_path: str, environment: str, tasks: str, method: str, seed: int, root_seed: int, parameters: str, output: str
) -> None:
    """Learn a sequence of tasks and write Q-tables, steps, subgoals and the skill library."""
    from ptl import methods
    from ptl.cli._progress import shown
    from ptl.config import Parameters, check_tasks
    from ptl.errors import UserError
    from ptl.files.provenance import code_digest
    from ptl.files.results import write_learning
    from ptl.learning.life import learn_life, tasks_of
    from ptl.world.gridworld import load_map

    if method not in methods.names():
        raise UserError(f"--method {method}: unknown; known are {', '.join(methods.names())}")
    chosen = Parameters.from_json(parameters)
    world = load_map(map_path)
    check_tasks(tasks, world.goals)
    learned = shown(tasks_of(world, tasks), "Learning tasks")
    life = learn_life(world, learned, method, chosen, root_seed, environment, seed)
    origin = {
        "environment": environment,
        "method": method,
        "seed": seed,
        "root_seed": root_seed,
        "parameters": chosen.to_dict(),
        "code": code_digest("ptl.learning.life", f"ptl.methods.{method}"),
    }
    write_learning(output, life, world, origin)
