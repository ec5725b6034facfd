"""``ptl population``: the maps of the second study, as a table or as text files."""

from __future__ import annotations

from pathlib import Path

import click

from studies.beyond.population import BANDS, POPULATION


@click.command()
@click.argument("path", type=click.Path(dir_okay=False), default=POPULATION)
@click.option("--maps", "folder", type=click.Path(file_okay=False, path_type=Path),
              help="Read the table at PATH and write its maps to this folder, for other programs:"
                   " <family>_<size>_<seed>.txt, goals A to F in the order in which they are learned.")  # fmt: skip
@click.option("--band", type=click.Choice(list(BANDS)), default="test", help="With --maps: maps of this band.")
@click.option("--size", type=int, default=300, help="With --maps: maps of about this number of states.")
def command(path: str, folder: Path | None, band: str, size: int) -> None:
    """Write the table of maps to PATH (config/population.csv): size, shortest paths, winding and hash of each."""
    from ptl.files.atomic import write_text
    from studies.beyond.population import all_entries, load_entry, read_population, to_csv

    if folder is None:
        write_text(path, to_csv(all_entries()))
        return
    for entry in read_population(path):
        if (entry.band, entry.size) == (band, size):
            world = load_entry(entry)
            write_text(folder / f"{world.name}.txt", world.text)
