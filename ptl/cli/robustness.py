"""``ptl robustness``: learn one setting of the robustness study."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from ptl.cli._arguments import Json

FILE = click.Path(dir_okay=False, path_type=Path)
JOB = Json(
    setting=str,
    environments=dict,
    methods=list,
    seeds=int,
    root_seed=int,
    parameters=dict,
    step_budget=int,
    growth=dict,
)


@click.command()
@click.option("--job", required=True, type=JOB, help="The setting as JSON, as the workflow passes it.")
@click.option("--output", required=True, type=FILE, help="HDF5 file to write.")
def command(job: dict[str, Any], output: Path) -> None:
    """Learn one setting: all environments, methods and seeds, and the growth of the library."""
    from ptl import methods
    from ptl.study.robustness.running import run_setting

    for method in job["methods"]:
        methods.load(str(method))
    run_setting(job, output)
