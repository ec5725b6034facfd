"""``ptl tables``: the table of metrics and tables 1-6 from the per-seed measures."""

from __future__ import annotations

from pathlib import Path

import click

FILE = click.Path(dir_okay=False, path_type=Path)


@click.command("tables")
@click.argument("per_seed", type=FILE)
@click.option("--output-metrics", required=True, type=FILE, help="CSV of all estimates with their intervals.")
@click.option(
    "--output-folder",
    required=True,
    type=click.Path(file_okay=False, path_type=Path),
    help="Folder for table1, table2, ... as .html, .md, .tex and .csv.",
)
@click.option(
    "--environment",
    "environments",
    multiple=True,
    metavar="NAME[=TITLE]",
    help="Environment and its title, in the order of the tables; may be repeated. [default: all]",
)
@click.option("--window", required=True, type=click.IntRange(min=1), help="As given to `ptl measure`; named in notes.")
@click.option(
    "--threshold-factor",
    required=True,
    type=click.FloatRange(min=1),
    help="As given to `ptl measure`; named in notes.",
)
@click.option(
    "--confidence",
    required=True,
    type=click.FloatRange(0, 1, min_open=True, max_open=True),
    help="Level of the intervals.",
)
@click.option("--resamples", required=True, type=click.IntRange(min=1), help="Bootstrap resamples.")
def command(
    per_seed: Path,
    output_metrics: Path,
    output_folder: Path,
    environments: tuple[str, ...],
    window: int,
    threshold_factor: float,
    confidence: float,
    resamples: int,
) -> None:
    """Estimate every metric from PER_SEED, the table that `ptl measure` wrote, and lay tables 1-6 out."""
    from ptl import methods
    from ptl.files import write_csv
    from ptl.statistics import Resampling, read_per_seed, summarise
    from ptl.tables import Settings, build_tables, write_tables

    metrics = summarise(read_per_seed(per_seed), Resampling(confidence, resamples))
    kinds = {name: methods.load(name) for name in metrics["method"].unique()}
    tables = build_tables(
        metrics,
        Settings(window, threshold_factor, confidence, resamples),
        labels={name: (kind.label, kind.colour) for name, kind in kinds.items()},
        environments=dict(_name_and_title(text) for text in environments) or None,
        source=f"{output_metrics.name} (from {per_seed.name})",
    )
    write_csv(metrics, output_metrics, sealed=True)
    write_tables(tables, output_folder)


def _name_and_title(text: str) -> tuple[str, str]:
    name, _, title = text.partition("=")
    return name, title
