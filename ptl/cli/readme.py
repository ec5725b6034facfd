"""``ptl readme``: the parts of the README that follow from the published run."""

from __future__ import annotations

from pathlib import Path

import click


@click.command()
def command() -> None:
    """Bring the results in README.md up to date with reports/published."""
    from ptl.errors import UserError
    from ptl.files.atomic import write_text
    from ptl.report.readme import filled

    page = Path("README.md")
    if not page.is_file():
        raise UserError(f"{page}: is not in this folder; run the command in the checkout")
    write_text(page, filled(page.read_text(encoding="utf-8"), Path("reports/published")))
