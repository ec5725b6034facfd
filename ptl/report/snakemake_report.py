"""The checksum of Snakemake's own report, which is kept as of other products."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NoReturn

from ptl.errors import UserError
from ptl.files.csv import seal
from ptl.files.regular import refuse_other


def keep_checksum(refuse: Callable[[UserError], NoReturn]) -> None:
    """Put the checksum of Snakemake's report beside it: it is made after the manifest, and differs each time.

    Parameters
    ----------
    refuse : function
        Called with the UserError of a path where something else than a file is; does not return.
    """
    from snakemake.report.html_reporter import Reporter

    render = Reporter.render

    def rendered(reporter: Reporter) -> None:
        path = Path(reporter.settings.path)
        try:
            refuse_other(path)
        except UserError as error:
            refuse(error)
        render(reporter)
        seal(path)

    Reporter.render = rendered
