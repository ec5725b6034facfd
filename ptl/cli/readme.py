"""``ptl readme``: the parts of the README that follow from the published run."""

from __future__ import annotations

from pathlib import Path

import click


@click.command()
def command() -> None:
    """Bring the results in README.md up to date with reports/published."""
    from ptl.files.atomic import write_text
    from ptl.report.readme import filled

    page = Path("README.md")
    write_text(page, filled(page.read_text(encoding="utf-8"), Path("reports/published")))
