"""``ptl measure``: per-seed measures, steps per episode and subgoals of the learning files of a run."""

from __future__ import annotations

from pathlib import Path

import click

FILE = click.Path(dir_okay=False, path_type=Path)


@click.command("measure")
@click.argument("files", nargs=-1, type=FILE)
@click.option("--output-per-seed", required=True, type=FILE, help="CSV of the measures of every seed.")
@click.option("--output-steps", type=FILE, help="HDF5 of the steps per episode.")
@click.option("--output-subgoals", type=FILE, help="CSV of the subgoals found.")
@click.option("--window", required=True, type=click.IntRange(min=1), help="Episodes of a moving mean.")
@click.option(
    "--threshold-factor",
    required=True,
    type=click.FloatRange(min=1),
    help="The threshold is this many times the shortest path.",
)
def command(
    files: tuple[Path, ...],
    output_per_seed: Path,
    output_steps: Path | None,
    output_subgoals: Path | None,
    window: int,
    threshold_factor: float,
) -> None:
    """Measure the learning FILES of a run.

    A range of seeds may be written as seed_[0-29].h5.
    Environments and methods keep the order in which they first appear among FILES.
    """
    from ptl.files import expand_numbers, write_csv
    from ptl.measures import measure_files, write_steps
    from ptl.progress import shown
    from ptl.verification import OneRun

    paths = expand_numbers(files)
    measurements = measure_files(shown(paths, "Reading"), window, threshold_factor, admit=OneRun().admit)
    write_csv(measurements.per_seed, output_per_seed, sealed=True)
    if output_subgoals:
        write_csv(measurements.subgoals, output_subgoals, sealed=True)
    if output_steps:
        write_steps(output_steps, measurements)
