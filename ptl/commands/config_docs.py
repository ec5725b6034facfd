"""``ptl config-docs``: the description of every configuration key, from the schema."""

from __future__ import annotations

from pathlib import Path

import click

FILE = click.Path(dir_okay=False, path_type=Path)


@click.command()
@click.argument("schema", type=FILE)
@click.option("--output", required=True, type=FILE, help="Markdown file to write.")
def command(schema: Path, output: Path) -> None:
    """Describe every key of the configuration SCHEMA."""
    from ptl.configuration_docs import document_file
    from ptl.files import write_text

    write_text(output, document_file(schema))
