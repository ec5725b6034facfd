"""``ptl lives``: learn many lives of the second study in one job."""

from __future__ import annotations

import json
from pathlib import Path

import click


@click.command()
@click.option("--job", required=True, help="The cell of the study as JSON, as the workflow passes it.")
@click.option("--code", default="", help="Digest of the sources, to be kept in the file.")
@click.option("--output", required=True, type=click.Path(dir_okay=False, path_type=Path), help="HDF5 file to write.")
def command(job: str, code: str, output: Path) -> None:
    """Learn the lives of one method on some maps of a family."""
    from ptl.study.population.running import run_cell

    run_cell(json.loads(job), output, code)
