"""Snakemake's own report: titles and labels stay text in it, and a checksum is kept of it, as of other products."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NoReturn

from ptl.errors import UserError
from ptl.files.csv import seal
from ptl.files.regular import refuse_other


def keep_texts() -> None:
    """Write ``<`` in the data of Snakemake's report as ``\\u003c``.

    Snakemake 9.27 puts labels and params as JSON into script elements, which a title with ``</script>`` would end.
    """
    from snakemake.report.html_reporter import data

    for name in [name for name in vars(data) if name.startswith("render_")]:
        setattr(data, name, _without_tags(getattr(data, name)))


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


def _without_tags(render: Callable[..., str]) -> Callable[..., str]:
    return lambda *arguments: render(*arguments).replace("<", "\\u003c")
