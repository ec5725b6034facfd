"""A population of maps that nobody chose: families, sizes, disjoint bands of seeds, and sequences of tasks.

Our choice throughout. ``config/population.csv`` lists every map with its hash, so that a generator that changes, here
or in numpy, is noticed instead of giving other maps under the same names.
"""

from __future__ import annotations

import csv
import hashlib
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ptl.errors import UserError
from ptl.world.gridworld import MAX_CELLS, GridWorld, map_digest, read_text
from ptl.world.mazes import FAMILIES, FREE, GOALS, START, WALL, largest_part, to_text

BANDS = {"tuning": 1000, "test": 4000}
"""First seed of each band. What is tuned is tuned on the first one; the second one is for reports only."""

MAPS = {("tuning", 300): 40, ("tuning", 1000): 10, ("test", 300): 100, ("test", 1000): 30, ("test", 3000): 10}
"""Maps of each family by band and size (states, about)."""

SIZE = 300
"""States of a map, about, where nothing else is said."""

POPULATION = Path("config/population.csv")
COLUMNS = ("band", "family", "size", "seed", "states", "shortest_paths", "winding", "hash")

HEADER = re.compile(r"type +\S.*\nheight +([0-9]+) *\nwidth +([0-9]+) *\nmap *\n")
"""Header of a map in the Moving AI text format."""


@dataclass(frozen=True)
class Entry:
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
    table : path
        Where the row was read.
    """

    band: str
    family: str
    size: int
    seed: int
    states: int
    shortest_paths: tuple[int, ...]
    winding: float
    hash: str
    table: str | Path = field(default=POPULATION, compare=False, repr=False)


# -- sequences of tasks --------------------------------------------------------------------------------------


def _drawn(world: GridWorld, rng: np.random.Generator, number: int) -> list[int]:
    others = np.delete(np.arange(world.n_states), world.start)
    return rng.choice(others, number, replace=False).tolist()


def _increasing(world: GridWorld, rng: np.random.Generator, number: int) -> list[int]:
    distance = world.distances_to(world.start)
    return sorted(_drawn(world, rng, number), key=lambda state: (distance[state], state))


def _reversed(world: GridWorld, rng: np.random.Generator, number: int) -> list[int]:
    return _increasing(world, rng, number)[::-1]


def _clustered(world: GridWorld, rng: np.random.Generator, number: int) -> list[int]:
    centre = _drawn(world, rng, 1)[0]
    nearest = np.argsort(world.distances_to(centre), kind="stable")
    near = nearest[nearest != world.start][: max(2 * number, world.n_states // 15)]
    return rng.choice(near, number, replace=False).tolist()


def _adversarial(world: GridWorld, rng: np.random.Generator, number: int) -> list[int]:
    places = [world.start, *_drawn(world, rng, 1)]
    while len(places) <= number:
        # from its nearest place, as the crow flies or as the agent walks, the next goal is farther than it looks
        least = np.min([_detour(world, place) for place in places], axis=0)
        places.append(int(least.argmax()))
    return places[1:]


def _detour(world: GridWorld, place: int) -> np.ndarray:
    """Return shortest path / straight line from a place to every state, 0 at the place."""
    offset = world.cells - world.cells[place]
    straight = np.sqrt((offset * offset).sum(axis=1))
    return np.divide(world.distances_to(place), straight, out=np.zeros(world.n_states), where=straight > 0)


SEQUENCES: dict[str, Callable[[GridWorld, np.random.Generator, int], list[int]]] = {
    "increasing": _increasing,
    "random": _drawn,
    "clustered": _clustered,
    "reversed": _reversed,
    "adversarial": _adversarial,
}
"""Orders in which goals come: by shortest path from the start (as in the article), as drawn, all in one corner, by
decreasing path, and each the state with the greatest detour from the start and all earlier goals."""


# -- maps ----------------------------------------------------------------------------------------------------


def make_map(family: str, size: int, seed: int, sequence: str = "increasing") -> GridWorld:
    """Return a map of a family; the walls and the start are the same for all sequences of a seed."""
    return place_tasks(FAMILIES[family](_stream(family, size, seed), size), f"{family}_{size}_{seed}", seed, sequence)


def place_tasks(grid: np.ndarray, name: str, seed: int, sequence: str = "increasing") -> GridWorld:
    """Put a start and six goals on a grid, whose free cells outside its largest part become walls.

    Increasing, random and reversed sequences of a seed have the same goals.
    """
    part = largest_part(grid)
    bounded = np.full(grid.shape, WALL)
    bounded[tuple(np.transpose(part))] = FREE
    if len(part) <= 2 * len(GOALS):
        raise UserError(f"{name}: has {len(part)} connected cells; a map with six tasks needs {2 * len(GOALS) + 1}")
    start, other = _stream(name, seed, "start").choice(len(part), 2, replace=False)
    bounded[part[start]], bounded[part[other]] = START, GOALS[0]
    world = GridWorld.from_text(to_text(bounded), name)
    kind = sequence if sequence in ("clustered", "adversarial") else "goals"
    goals = SEQUENCES[sequence](world, _stream(name, seed, kind), len(GOALS))
    bounded[part[other]] = FREE
    for letter, goal in zip(GOALS, goals, strict=True):
        bounded[tuple(world.cells[goal])] = letter
    return GridWorld.from_text(to_text(bounded), name)


def _stream(*names: str | int) -> np.random.Generator:
    digest = hashlib.sha256("/".join(map(str, names)).encode()).digest()
    return np.random.Generator(np.random.SFC64(int.from_bytes(digest, "big")))


def read_moving_ai(path: str | Path) -> np.ndarray:
    """Read the grid of a map in the Moving AI text format (Sturtevant, 2012, doi:10.1109/TCIAIG.2012.2197681).

    ``.``, ``G`` and ``S`` can be walked on; all else is a wall. Diagonal moves of that format are left out.

    Raises
    ------
    UserError
        When the file cannot be read, or its header and its rows do not agree.
    """
    text = read_text(path).replace("\r\n", "\n")
    header = HEADER.match(text)
    # Only line feeds end a row, as in the maps of this package.
    rows = [line for line in text[header.end() :].split("\n") if line] if header else []
    if header is None or not rows or header.groups() != (str(len(rows)), str(len(rows[0]))):
        raise UserError(
            f"{path}: a Moving AI map begins with the lines 'type', 'height', 'width' and 'map', and its rows must"
            " agree with them"
        )
    if len({len(row) for row in rows}) > 1:
        raise UserError(f"{path}: the rows of a Moving AI map must be equally long")
    if len(rows) * len(rows[0]) > MAX_CELLS:
        raise UserError(f"{path}: the map has more than {MAX_CELLS} cells; use a smaller one")
    return np.where(np.isin([list(row) for row in rows], list(".GS")), FREE, WALL)


# -- the table -----------------------------------------------------------------------------------------------


def describe(band: str, family: str, size: int, seed: int) -> Entry:
    """Make a map and return its row of the table."""
    world = make_map(family, size, seed)
    goals = list(world.goals.values())
    paths = world.distances_to(world.start)[goals]
    return Entry(
        band, family, size, seed, world.n_states, tuple(paths.tolist()), round(winding(world), 4), hash_of(world)
    )


def winding(world: GridWorld) -> float:
    """Return the mean over a map's goals of shortest path / straight line from the start."""
    return float(_detour(world, world.start)[list(world.goals.values())].mean())


def hash_of(world: GridWorld) -> str:
    """Return the digest of a map's text."""
    return map_digest(world.text)


def all_entries() -> Iterator[Entry]:
    """Make all maps of the population and yield their rows."""
    for (band, size), number in MAPS.items():
        for family in FAMILIES:
            for seed in range(BANDS[band], BANDS[band] + number):
                yield describe(band, family, size, seed)


def read_population(path: str | Path = POPULATION) -> list[Entry]:
    """Read the table of maps.

    Raises
    ------
    UserError
        When it cannot be read, has other columns, or a row cannot be that of a map of the population.
    """
    rows = csv.DictReader(read_text(path).split("\n"))
    try:
        return [_entry(row, path) for row in rows]
    except (AttributeError, csv.Error, KeyError, ValueError, TypeError) as error:
        raise UserError(
            f"{path}: line {rows.line_num}: is no row of a table of maps ({error!r:.100}); run 'ptl population' to make"
            " the table"
        ) from None


def _entry(row: Mapping[str, str], table: str | Path) -> Entry:
    """Return what a row of the table says.

    Raises
    ------
    ValueError
        Naming the first column that holds what it never holds; other errors if there is no such column or number.
    """
    entry = Entry(
        row["band"], row["family"], int(row["size"]), int(row["seed"]), int(row["states"]),
        tuple(map(int, row["shortest_paths"].split())), float(row["winding"]), row["hash"], table,
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


def to_csv(entries: Iterator[Entry]) -> str:
    """Return the text of the table."""
    lines = [",".join(COLUMNS)]
    for entry in entries:
        paths = " ".join(map(str, entry.shortest_paths))
        lines.append(
            f"{entry.band},{entry.family},{entry.size},{entry.seed},{entry.states},{paths},{entry.winding},{entry.hash}"
        )
    return "\n".join(lines) + "\n"


def load_entry(entry: Entry, sequence: str = "increasing") -> GridWorld:
    """Make the map of a row, and refuse one that differs from what the row says.

    Raises
    ------
    UserError
        When the map has another hash.
    """
    made = make_map(entry.family, entry.size, entry.seed)
    if hash_of(made) != entry.hash:
        raise UserError(
            f"map {made.name}: is not the one in {entry.table} (hash {hash_of(made)}, not {entry.hash}); use the"
            " version of numpy in requirements.lock"
        )
    return made if sequence == "increasing" else make_map(entry.family, entry.size, entry.seed, sequence)
