"""``ptl library-cost``: time of a skill selection and bytes of a library, against its size."""

from __future__ import annotations

from pathlib import Path

import click

FILE = click.Path(dir_okay=False, path_type=Path)


@click.command()
@click.argument("maps", nargs=-1, required=True, type=FILE)
@click.option("--output-selection", required=True, type=FILE, help="CSV of skills and seconds.")
@click.option("--output-storage", required=True, type=FILE, help="CSV of states, skills and bytes.")
def command(maps: tuple[Path, ...], output_selection: Path, output_storage: Path) -> None:
    """Measure skill selection for 1 to 5000 skills, and the bytes of libraries for the states of MAPS."""
    from ptl.complexity import library_bytes, selection_seconds
    from ptl.files import write_csv
    from ptl.gridworld import load_map

    sizes = [1, 2, 5, 10, 20, 50, 100, 200, 350, 500, 700, 1000, 2000, 5000]
    write_csv(selection_seconds(sizes), output_selection, sealed=True)
    states = sorted({load_map(path).n_states for path in maps})
    write_csv(library_bytes(states, [1, 3, 10, 30, 100]), output_storage, sealed=True)
