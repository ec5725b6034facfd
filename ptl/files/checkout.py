"""The checkout whose workflow runs: copied with its environment, it would be run by the code of the original."""

from __future__ import annotations

import os
from pathlib import Path

from ptl.errors import UserError

PACKAGE = Path(__file__).parent.parent


def check_checkout(workflow: str | os.PathLike[str]) -> None:
    """Refuse a workflow that lies beside another copy of this package than the one that runs.

    Parameters
    ----------
    workflow : path
        Folder of the workflow.

    Raises
    ------
    UserError
        Naming both, and the command that installs the right one.
    """
    beside = Path(workflow).parent / PACKAGE.name
    if (beside / "__init__.py").exists() and not beside.samefile(PACKAGE):
        raise UserError(f"{workflow}: runs with the code in {PACKAGE}, not with that beside it; run 'make build' there")
