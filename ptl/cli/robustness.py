"""``ptl robustness``: learn one setting of the robustness study."""

from __future__ import annotations

import json
from pathlib import Path

import click

FILE = click.Path(dir_okay=False, path_type=Path)


@click.command()
@click.option("--job", required=True, help="The setting as JSON, as the workflow passes it.")
@click.option("--output", required=True, type=FILE, help="HDF5 file to write.")
def command(job: str, output: Path) -> None:
    """Learn one setting: all environments, methods and seeds, and the growth of the library."""
    from ptl.study.robustness.running import run_setting

    run_setting(json.loads(job), output)
