"""``ptl differences``: the article's numbers beside ours."""

from __future__ import annotations

from pathlib import Path

import click

FILE = click.Path(dir_okay=False, path_type=Path)


@click.command()
@click.argument("claims", type=FILE)
@click.argument("parts", type=FILE)
@click.option("--output-md", required=True, type=FILE, help="Markdown table to write.")
@click.option("--output-html", required=True, type=FILE, help="Page to write.")
def command(claims: Path, parts: Path, output_md: Path, output_html: Path) -> None:
    """Lay out where this run differs from the article, from the ledger of CLAIMS and its PARTS."""
    import pandas as pd

    from ptl.differences import differences_page
    from ptl.files import write_text

    page = differences_page(pd.read_csv(claims, keep_default_na=False), pd.read_csv(parts))
    write_text(output_md, page.to_markdown())
    write_text(output_html, page.to_html())
