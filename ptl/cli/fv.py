"""``ptl fv``: the experiment of Fernandez and Veloso, to check the implementation of policy reuse."""

from __future__ import annotations

from pathlib import Path

import click

from ptl.cli._arguments import SEED

FILE = click.Path(dir_okay=False, path_type=Path)


@click.command()
@click.option("--map", "map_path", required=True, type=FILE, help="Text file of their map (environment 3).")
@click.option("--library", required=True, help="library_234, library_1234, library_2345 or q_learning.")
@click.option("--seeds", required=True, type=click.IntRange(1, 10**5), help="Number of runs (seeds 0, 1, ...).")
@click.option("--root-seed", required=True, type=SEED, help="Seed from which all streams derive.")
@click.option(
    "--trials", default=2000, show_default=True, type=click.IntRange(1, 10**6), help="Trials on the new task."
)
@click.option("--library-trials", default=20_000, show_default=True, type=click.IntRange(1, 10**6),
              help="Trials in which each policy of the library is learned.")  # fmt: skip
@click.option("--output", required=True, type=FILE, help="HDF5 file to write.")
def command(
    map_path: Path, library: str, seeds: int, root_seed: int, trials: int, library_trials: int, output: Path
) -> None:
    """Learn the new task with one library and write the gain of every trial."""
    from ptl.study.policy_reuse_experiment import run_job
    from ptl.world.gridworld import load_map

    run_job(load_map(map_path), library, range(seeds), root_seed, trials, library_trials, output)
