"""Check which checkout's code runs: a copied virtual environment would run the code of the original."""

from __future__ import annotations

import os
from pathlib import Path

from ptl.errors import UserError

PACKAGE = Path(__file__).parent.parent


def check_workflow(folder: object) -> None:
    """Refuse rules beside another copy of this package; Snakemake's ``folder`` of hosted rules is no path.

    Raises
    ------
    UserError
        As `check_checkout`.
    """
    if isinstance(folder, str | os.PathLike):
        check_checkout(Path(folder).parent)


def check_checkout(part: str | os.PathLike[str]) -> None:
    """Refuse a workflow or an environment that belongs to a copy of this package other than the running one.

    Parameters
    ----------
    part : path
        Folder of the workflow or of the environment.

    Raises
    ------
    UserError
        Naming both, and the command that installs the right one.
    """
    beside = Path(part).parent / PACKAGE.name
    if (beside / "__init__.py").exists() and not beside.samefile(PACKAGE):
        raise UserError(f"{part}: runs with the code in {PACKAGE}, not with that beside it; run 'make build' there")
