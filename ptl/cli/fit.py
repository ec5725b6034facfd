"""``ptl fit``: search for the drawings and settings that fit the article's claims."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from ptl.cli._arguments import Json

FILE = click.Path(dir_okay=False, path_type=Path)
FOLDER = click.Path(file_okay=False, path_type=Path)


@click.command()
@click.option("--search", required=True, type=FILE, help="File with the values, the rule and the effort.")
@click.option(
    "--config", required=True, type=Json(), help="Configuration of the run as JSON, as the workflow passes it."
)
@click.option("--lives", required=True, type=FOLDER, help="Folder in which what was learned is kept.")
@click.option("--output", required=True, type=FOLDER, help="Folder for tried.csv, parts.csv and halves.csv.")
def command(search: Path, config: dict[str, Any], lives: Path, output: Path) -> None:
    """Search in one process; an interrupted search goes on where it stopped."""
    from ptl.config import Configuration
    from ptl.files.csv import write_csv
    from ptl.study.fit import Searcher, halves_frame, parts_frame, read_search, tried_frame

    values = read_search(search)
    searcher = Searcher(values, Configuration.from_dict(config), lives, lambda line: click.echo(line, err=True))
    outcomes = searcher.run()
    write_csv(tried_frame(outcomes), output / "tried.csv")
    write_csv(parts_frame(outcomes), output / "parts.csv")
    write_csv(halves_frame(outcomes, values.halves), output / "halves.csv")
