"""``ptl population``: make the table of all maps of the second study."""

from __future__ import annotations

import click

from ptl.world.population import POPULATION


@click.command()
@click.argument("path", type=click.Path(dir_okay=False), default=POPULATION)
def command(path: str) -> None:
    """Write the table of maps to PATH (config/population.csv): size, shortest paths, winding and hash of each."""
    from ptl.files.atomic import write_text
    from ptl.world.population import all_entries, to_csv

    write_text(path, to_csv(all_entries()))
