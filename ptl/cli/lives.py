"""``ptl lives``: learn many lives of the second study in one job."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from ptl.cli._arguments import Json


@click.command()
@click.option(
    "--job",
    required=True,
    type=Json(cell=dict, maps=str, parameters=dict, population=str, root_seed=int),
    help="The cell of the study as JSON, as the workflow passes it.",
)
@click.option("--code", default="", help="Digest of the sources, to be kept in the file.")
@click.option("--output", required=True, type=click.Path(dir_okay=False, path_type=Path), help="HDF5 file to write.")
def command(job: dict[str, Any], code: str, output: Path) -> None:
    """Learn the lives of one method on some maps of a family."""
    import msgspec

    from ptl.errors import UserError
    from ptl.study.population.running import Cell, run_cell

    try:
        msgspec.convert(job["cell"], Cell)
    except msgspec.ValidationError as error:
        raise UserError(f"--job: cell: {error}; the workflow passes it") from error
    run_cell(job, output, code)
