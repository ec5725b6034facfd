"""``ptl fv``: the experiment of Fernandez and Veloso, to check the implementation of policy reuse."""

from __future__ import annotations

from pathlib import Path

import click

FILE = click.Path(dir_okay=False, path_type=Path)


@click.group()
def command() -> None:
    """Run Fernandez and Veloso's own experiment with our policy reuse, and show its gain beside theirs."""


@command.command("learn")
@click.option("--map", "map_path", required=True, type=FILE, help="Text file of their map (environment 3).")
@click.option("--library", required=True, help="library_234, library_1234, library_2345 or q_learning.")
@click.option("--seeds", required=True, type=click.IntRange(1), help="Number of runs (seeds 0, 1, ...).")
@click.option("--root-seed", required=True, type=click.IntRange(0), help="Seed from which all streams derive.")
@click.option("--trials", default=2000, show_default=True, type=click.IntRange(1), help="Trials on the new task.")
@click.option("--library-trials", default=20_000, show_default=True, type=click.IntRange(1),
              help="Trials in which each policy of the library is learned.")  # fmt: skip
@click.option("--output", required=True, type=FILE, help="HDF5 file to write.")
def learn(
    map_path: Path, library: str, seeds: int, root_seed: int, trials: int, library_trials: int, output: Path
) -> None:
    """Learn the new task with one library and write the gain of every trial."""
    from ptl.fv_experiment import run_job
    from ptl.gridworld import load_map

    run_job(load_map(map_path), library, range(seeds), root_seed, trials, library_trials, output)


@command.command("report")
@click.argument("files", nargs=-1, required=True, type=FILE)
@click.option("--output-figure", required=True, type=FILE, help="PNG to write, with an SVG and a CSV beside it.")
@click.option("--output-table", required=True, type=FILE, help="CSV to write, with a .md and a .html beside it.")
@click.option("--confidence", default=0.95, show_default=True, type=click.FloatRange(0, 1, True, True),
              help="Level of intervals.")  # fmt: skip
@click.option("--resamples", default=2000, show_default=True, type=click.IntRange(1), help="Bootstrap resamples.")
def report(files: tuple[Path, ...], output_figure: Path, output_table: Path, confidence: float, resamples: int) -> None:
    """Draw the mean gain against trials from the FILES of `ptl fv learn`, and write its table."""
    from ptl.figures import fv as figure
    from ptl.figures import style
    from ptl.files import write_csv, write_text
    from ptl.fv_experiment import read_gains
    from ptl.fv_table import gain_page, gain_table
    from ptl.statistics import Resampling

    gains = read_gains(files)
    frame = figure.gain_frame(gains, confidence)
    style.save(figure.draw(frame), frame, output_figure)
    table = gain_table(gains, Resampling(confidence, resamples))
    write_csv(table, output_table)
    page = gain_page(table, confidence)
    write_text(output_table.with_suffix(".md"), page.to_markdown())
    write_text(output_table.with_suffix(".html"), page.to_html())
