"""``ptl learn``: one learning job, a life of tasks under one method with one seed."""

from __future__ import annotations

import click

from ptl.cli._arguments import SEED


@click.command()
@click.option("--map", "map_path", required=True, type=click.Path(), help="Text file of the map.")
@click.option("--environment", help="Name of the environment in files and tables; by default that of the map's file.")
@click.option("--tasks", help="Goal letters in the order of the tasks, e.g. ABCDEF; by default all goals.")
@click.option("--method", default="ptl", show_default=True,
              help="A built-in method, a file that ends in .py, or package.module:Class.")  # fmt: skip
@click.option("--method-parameters", default="{}", help="Parameters of the method's own as JSON.")
@click.option("--seed", default=0, show_default=True, type=SEED, help="Number of the run.")
@click.option("--root-seed", default=2019, show_default=True, type=SEED,
              help="Seed from which all streams derive.")  # fmt: skip
@click.option("--parameters", default="{}", help="Hyper-parameters as JSON; missing ones take their defaults.")
@click.option("--output", type=click.Path(), help="HDF5 file to write; by default ENVIRONMENT_METHOD_SEED.h5.")
def command(
    map_path: str,
    environment: str | None,
    tasks: str | None,
    method: str,
    method_parameters: str,
    seed: int,
    root_seed: int,
    parameters: str,
    output: str | None,
) -> None:
    """Learn a sequence of tasks and write Q-tables, steps, subgoals and the skill library."""
    from pathlib import Path

    from ptl import methods
    from ptl.cli._progress import shown
    from ptl.config import Parameters, check_tasks
    from ptl.files.outside import configured, learning_code, record, values_of
    from ptl.files.results import write_learning
    from ptl.learning.life import learn_life, tasks_of
    from ptl.world.gridworld import load_map

    kind = configured(method, values_of(method_parameters))
    chosen = Parameters.from_json(parameters)
    world = load_map(map_path)
    tasks = "".join(world.goals) if tasks is None else tasks
    check_tasks(tasks, world.goals)
    name, environment = methods.identifier(method), environment or Path(map_path).stem
    learned = shown(tasks_of(world, tasks), "Learning tasks")
    with methods.blamed(method):
        life = learn_life(world, learned, kind, chosen, root_seed, environment, seed)
    origin = {
        "environment": environment,
        "method": name,
        "seed": seed,
        "root_seed": root_seed,
        "parameters": chosen.to_dict() | record(method, kind),
        "code": learning_code(method),
    }
    path = f"{environment}_{name}_{seed}.h5" if output is None else output
    write_learning(path, life, world, origin)
    if output is None:
        click.echo(f"{path}: written; 'ptl inspect {path}' shows it")
