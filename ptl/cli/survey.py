"""``ptl survey``: subgoals over all pairs of start and goal, in batches that are added up."""

from __future__ import annotations

import click

from ptl.cli._arguments import LARGEST, SEED
from ptl.config import SubgoalFrequencies

DEFAULT = SubgoalFrequencies()
PRODUCT = click.option("--output", required=True, type=click.Path(), help="HDF5 file to write.")


@click.group()
def command() -> None:
    """Count how often each state is the subgoal over all pairs of start and goal."""


@command.command()
@click.option("--map", "map_path", required=True, type=click.Path(), help="Text file of the map.")
@click.option("--environment", required=True, help="Name of the environment.")
@click.option("--batch", required=True, type=click.IntRange(0), help="Number of this batch, from 0.")
@click.option("--batches", required=True, type=int, help="Batches in all.")
@click.option("--starts", default=DEFAULT.starts, help="'all' or the number of start states to sample.")
@click.option("--trajectories", default=DEFAULT.trajectories, type=int, help="Successful episodes of each task.")
@click.option("--root-seed", required=True, type=SEED, help="Seed from which all streams derive.")
@click.option("--parameters", default="{}", help="Hyper-parameters as JSON; missing ones take their defaults.")
@PRODUCT
def batch(
    map_path: str,
    environment: str,
    batch: int,
    batches: int,
    starts: str,
    trajectories: int,
    root_seed: int,
    parameters: str,
    output: str,
) -> None:
    """Learn all tasks to every BATCHES-th state."""
    from ptl.cli._progress import shown
    from ptl.config import Parameters
    from ptl.errors import UserError
    from ptl.files.provenance import code_digest
    from ptl.files.results import write_frequencies
    from ptl.learning.starts import chosen_starts
    from ptl.learning.survey import subgoal_frequencies
    from ptl.world.gridworld import load_map

    whole = starts.isdecimal() and len(starts) <= len(str(LARGEST))  # Python refuses to read very long numbers
    survey = SubgoalFrequencies.from_dict(
        {"starts": int(starts) if whole else starts, "trajectories": trajectories, "batches": batches}
    )
    if batch >= survey.batches:
        raise UserError(f"--batch: {batch} is not allowed; give a number below --batches ({batches})")
    chosen = Parameters.from_json(parameters)
    world = load_map(map_path)
    origins = chosen_starts(world, None if survey.starts == "all" else survey.starts, root_seed, environment)
    goals = shown(range(world.n_states)[batch::batches], "Goals")
    arrays = subgoal_frequencies(world, origins, goals, trajectories, chosen.learning, root_seed, environment)
    origin = {
        "environment": environment,
        "batch": batch,
        "batches": batches,
        "trajectories": trajectories,
        "starts": len(origins),
        "root_seed": root_seed,
        "parameters": chosen.to_dict(),
        "code": code_digest("ptl.learning.survey"),
    }
    write_frequencies(output, arrays, world, origin)


@command.command()
@click.argument("batches", nargs=-1, required=True, type=click.Path())
@PRODUCT
def merge(batches: tuple[str, ...], output: str) -> None:
    """Add up the counts of all BATCHES of one environment."""
    from ptl.errors import UserError
    from ptl.files.results import FREQUENCIES, open_result, write_frequencies
    from ptl.files.verification import OneRun
    from ptl.learning.survey import ARRAYS, add_up

    parts, run, numbers = [], OneRun(), []
    for path in batches:
        with open_result(path, FREQUENCIES) as result:
            run.admit(path, result)
            parts.append({name: result.file[name] for name in ARRAYS})
            if "batch" not in result.file.attrs:
                raise UserError(f"{path}: holds all starts, not a batch of them; give the batches")
            numbers.append(int(result.file.attrs["batch"]))
            origin = {
                "environment": result.environment,
                "trajectories": int(result.file.attrs["trajectories"]),
                "starts": int(result.file.attrs["starts"]),
                "root_seed": result.root_seed,
                "parameters": result.parameters,
                "code": result.code,
            }
            world, expected = result.world, int(result.file.attrs["batches"])
    if sorted(numbers) != list(range(expected)):
        raise UserError(
            f"batches {', '.join(map(str, numbers))} were given where 0 to {expected - 1} are needed, each once;"
            " remove them and run 'snakemake subgoal_frequencies'"
        )
    write_frequencies(output, add_up(parts), world, origin)
