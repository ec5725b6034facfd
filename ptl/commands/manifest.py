"""``ptl manifest``: checksums of a run's products."""

from __future__ import annotations

import json
from pathlib import Path

import click

FILE = click.Path(dir_okay=False, path_type=Path)


@click.command()
@click.argument("products", nargs=-1, required=True, type=FILE)
@click.option("--folder", required=True, type=click.Path(file_okay=False, path_type=Path), help="Report folder.")
@click.option("--config", required=True, help="Configuration of the run as JSON.")
@click.option("--output", required=True, type=FILE, help="JSON file to write.")
def command(products: tuple[Path, ...], folder: Path, config: str, output: Path) -> None:
    """Write the manifest of PRODUCTS."""
    from ptl.files import write_text
    from ptl.manifest import build

    manifest = build(products, folder, json.loads(config))
    write_text(output, json.dumps(manifest, indent=1, sort_keys=True) + "\n")
