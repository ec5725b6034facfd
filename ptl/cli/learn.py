"""``ptl learn``: one learning job, a life of tasks under one method with one seed."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from ptl.cli._maps import map_options, read_maps

if TYPE_CHECKING:
    from ptl.config import MapOptions

SEED = click.IntRange(0, 2**63 - 1)


@click.command()
@click.option("--map", "map_path", required=True, type=click.Path(path_type=Path), help="File of the map.")
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
@map_options
def command(
    map_path: Path,
    environment: str | None,
    tasks: str | None,
    method: str,
    method_parameters: str,
    seed: int,
    root_seed: int,
    parameters: str,
    output: str | None,
    options: MapOptions,
) -> None:
    """Learn a sequence of tasks and write Q-tables, steps, subgoals and the skill library."""
    import msgspec

    from ptl import methods
    from ptl.cli._progress import shown
    from ptl.config import Name, Parameters, check_tasks
    from ptl.errors import UserError
    from ptl.files import store
    from ptl.files.outside import configured, learning_code, values_of
    from ptl.jobs.learn import Learn
    from ptl.keys import allowed
    from ptl.world.gridworld import map_digest

    own = values_of(method_parameters)
    configured(method, own)
    chosen = Parameters.from_json(parameters).to_dict()
    (world,) = read_maps([map_path], options)
    tasks = "".join(world.goals) if tasks is None else tasks
    check_tasks(tasks, world.goals)
    environment = environment or map_path.stem
    try:
        msgspec.convert(environment, Name)
    except msgspec.ValidationError:
        raise UserError(f"--environment: {environment!r} is not allowed; give {allowed(Name)}") from None
    job = Learn(
        root_seed=root_seed,
        parameters={group: chosen[group] for group in Learn.READS},
        maps={environment: map_digest(world.text)},
        code=learning_code(method),
        slip=world.slip,
        environment=environment,
        tasks=tasks,
        method=methods.identifier(method),
        reference=method,
        own=own,
        seed=seed,
    )
    path = f"{environment}_{job.method}_{seed}.h5" if output is None else output
    worlds = {environment: world}
    store.write(path, job, job.run(worlds, lambda tasks: shown(tasks, "Learning tasks")), worlds)
    if output is None:
        click.echo(f"{path}: written; 'ptl inspect {path}' shows it")
