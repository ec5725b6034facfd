"""The population of generated, not hand-picked maps: disjoint bands of seeds, and the table of all maps.

Our choice throughout. The table lists every map with its hash, so that a changed generator, here or in numpy, is
detected instead of giving other maps under the same names. See ``python -m studies.beyond.population --help`` for the
commands that write the table and the maps.
"""

from __future__ import annotations

import csv
import re
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import click

from ptl.errors import UserError
from ptl.files.atomic import write_text
from ptl.world.gridworld import GridWorld, map_digest
from ptl.world.map_files import read_text
from ptl.world.mazes import FAMILIES, GOALS
from studies.beyond.maps import checked_map, make_map, winding

BANDS = {"tuning": 1000, "test": 4000}
"""First seed of each band. The first band is for tuning, the second for reports only."""

MAPS = {("tuning", 300): 40, ("tuning", 1000): 10, ("test", 300): 100, ("test", 1000): 30, ("test", 3000): 10}
"""Maps of each family by band and size (states, about)."""

SIZE = 300
"""Default number of states of a map (approximate)."""

TABLE = Path(__file__).parent / "config/population.csv"
"""The table of all maps."""

COLUMNS = ("band", "family", "size", "seed", "states", "shortest_paths", "winding", "hash")


@dataclass(frozen=True)
class MapEntry:
    """A map of the population, as a row of the table has it.

    Attributes
    ----------
    band, family : str
    size, seed : int
        Wanted number of states, and seed of the map.
    states : int
    shortest_paths : tuple of int
        Steps from the start to each goal.
    winding : float
        Mean over the goals of shortest path / straight line, both from the start.
    hash : str
        First 16 digits of the sha256 of the map's text.
    """

    band: str
    family: str
    size: int
    seed: int
    states: int
    shortest_paths: tuple[int, ...]
    winding: float
    hash: str

    @property
    def name(self) -> str:
        """Name of the map: family, size and seed."""
        return f"{self.family}_{self.size}_{self.seed}"

    def world(self) -> GridWorld:
        """Make the map; errors as in `studies.beyond.maps.checked_map`."""
        return checked_map(self.family, self.size, self.seed, self.hash)


# -- the table -----------------------------------------------------------------------------------------------


def describe(band: str, family: str, size: int, seed: int) -> MapEntry:
    """Make a map and return its row of the table."""
    world = make_map(family, size, seed)
    goals = list(world.goals.values())
    paths = world.distances_to(world.start)[goals]
    return MapEntry(
        band,
        family,
        size,
        seed,
        world.n_states,
        tuple(paths.tolist()),
        round(winding(world), 4),
        map_digest(world.text),
    )


def all_entries() -> Iterator[MapEntry]:
    """Make all maps of the population and yield their rows."""
    for (band, size), number in MAPS.items():
        for family in FAMILIES:
            for seed in range(BANDS[band], BANDS[band] + number):
                yield describe(band, family, size, seed)


def read_population(path: str | Path = TABLE) -> list[MapEntry]:
    """Read the table of maps.

    Raises
    ------
    UserError
        When it cannot be read, has other columns, or a row cannot be that of a map of the population.
    """
    rows = csv.DictReader(read_text(path).split("\n"))
    try:
        return [_entry(row) for row in rows]
    except (AttributeError, csv.Error, KeyError, ValueError, TypeError) as error:
        raise UserError(
            f"{path}: line {rows.line_num}: is no row of a table of maps ({error!r:.100}); make the table again with"
            " 'python -m studies.beyond.population'"
        ) from None


def _entry(row: Mapping[str, str]) -> MapEntry:
    """Return the map that a row of the table describes.

    Raises
    ------
    ValueError
        Naming the first column with an impossible value; other errors if there is no such column or number.
    """
    entry = MapEntry(
        row["band"], row["family"], int(row["size"]), int(row["seed"]), int(row["states"]),
        tuple(map(int, row["shortest_paths"].split())), float(row["winding"]), row["hash"],
    )  # fmt: skip
    first, maps = BANDS.get(entry.band, 0), MAPS.get((entry.band, entry.size), 0)
    paths = entry.shortest_paths
    holds = {
        "band": entry.band in BANDS,
        "family": entry.family in FAMILIES,
        "size": maps > 0,
        "seed": first <= entry.seed < first + maps,
        "states": entry.size <= 2 * entry.states <= 4 * entry.size,
        "shortest_paths": len(paths) == len(GOALS) and all(1 <= path < entry.states for path in paths),
        "winding": 1 <= entry.winding < entry.states,
        "hash": re.fullmatch("[0-9a-f]{16}", entry.hash) is not None,
    }
    for column, right in holds.items():
        if not right:
            raise ValueError(f"{column} {row[column]}")
    return entry


def to_csv(entries: Iterator[MapEntry]) -> str:
    """Return the text of the table."""
    lines = [",".join(COLUMNS)]
    for entry in entries:
        paths = " ".join(map(str, entry.shortest_paths))
        lines.append(
            f"{entry.band},{entry.family},{entry.size},{entry.seed},{entry.states},{paths},{entry.winding},{entry.hash}"
        )
    return "\n".join(lines) + "\n"


# -- the command ---------------------------------------------------------------------------------------------


@click.command()
@click.argument("path", type=click.Path(dir_okay=False, path_type=Path), default=TABLE)
@click.option("--maps", "folder", type=click.Path(file_okay=False, path_type=Path),
              help="Read the table at PATH and write its maps to this folder, for other programs:"
                   " <family>_<size>_<seed>.txt, goals A to F in the order in which they are learned.")  # fmt: skip
@click.option("--band", type=click.Choice(list(BANDS)), default="test", help="With --maps: maps of this band.")
@click.option("--size", type=int, default=SIZE, help="With --maps: maps of about this number of states.")
def command(path: Path, folder: Path | None, band: str, size: int) -> None:
    """Write the table of maps to PATH, by default the one in this folder."""
    if folder is None:
        write_text(path, to_csv(all_entries()))
        return
    for entry in read_population(path):
        if (entry.band, entry.size) == (band, size):
            write_text(folder / f"{entry.name}.txt", entry.world().text)


if __name__ == "__main__":
    try:
        command(prog_name="python -m studies.beyond.population")
    except UserError as error:
        sys.exit(f"error: {error}")
