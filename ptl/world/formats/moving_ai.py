"""Maps and scenarios in the Moving AI text formats (Sturtevant, 2012, doi:10.1109/TCIAIG.2012.2197681).

A map begins with the lines ``type``, ``height`` and ``width`` in any order and the line ``map``. A walking agent moves
on ``.``, ``G`` (ground) and ``S`` (swamp); ``W`` (water), ``T`` (trees), ``@`` and ``O`` (out of bounds) are walls to
it. Diagonal moves are left out. A scenario (``arena.map.scen`` beside ``arena.map``) lists pairs of start and goal; a
life has one start, that of the first pair, and takes the goals of the first pairs.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from ptl.errors import UserError
from ptl.world.formats import Cell, Drawing, shown

HEADER = re.compile(r"^[ \t]*(type|height|width)[ \t]+\S", re.IGNORECASE | re.MULTILINE)
SCENARIO = re.compile(r"\s*version[ \t]+[0-9.]+\s*\n", re.IGNORECASE)
WALKED_ON, WALLS = ".GS", "WT@O"
PAIRS = 6
"""Number of goals that are taken from a scenario, as many as the article's tasks."""


def read(text: str, name: str, max_cells: int) -> Drawing:
    """Read a map; a header that does not agree with the rows raises UserError with both numbers."""
    lines = [line.rstrip() for line in text.split("\n")]
    header: dict[str, str] = {}
    for number, line in enumerate(lines, start=1):
        words = line.split()
        if words and (key := words[0].lower()) == "map":
            break
        if not words:
            continue
        if key not in ("type", "height", "width") or len(words) != 2 or key in header:
            raise UserError(
                f"{name}: line {number}: {line.strip()!r:.60} is not allowed there; a Moving AI map begins with the"
                " lines 'type octile', 'height 9', 'width 12', each once, and 'map'"
            )
        header[key] = words[1]
    else:
        raise UserError(f"{name}: has no line 'map' between the header of a Moving AI map and its rows; add it")
    size = {}
    for key in ("height", "width"):
        if not re.fullmatch("[0-9]{1,9}", header.get(key, "")) or int(header[key]) == 0:
            given = f"{header[key]!r:.60} is not allowed" if key in header else "is missing"
            raise UserError(f"{name}: {key} {given}; a Moving AI map has a line '{key} NUMBER'")
        size[key] = int(header[key])
    height, width = size["height"], size["width"]
    if height * width > max_cells:
        raise UserError(f"{name}: the map has {height * width} cells, more than {max_cells}; use a smaller one")
    rows = lines[number:]
    while rows and not rows[-1]:
        rows.pop()
    if len(rows) != height:
        raise UserError(f"{name}: height is {height} but there are {len(rows)} rows; correct one of them")
    for place, row in enumerate(rows, start=1):
        if len(row) != width:
            raise UserError(
                f"{name}: width is {width} but row {place} (line {number + place}) has {len(row)} cells; correct one"
                " of them"
            )
    letters = np.array([list(row) for row in rows])
    unknown = ~np.isin(letters, list(WALKED_ON + WALLS))
    if unknown.any():
        row, column = np.argwhere(unknown)[0].tolist()
        cell = (row, column)
        raise UserError(
            f"{name}: unknown letter {str(letters[cell])!r} in {shown(cell)} of the rows (line {number + cell[0] + 1});"
            f" a Moving AI map has the letters {' '.join(WALKED_ON + WALLS)}"
        )
    return Drawing(np.isin(letters, list(WALKED_ON)))


def scenario_of(path: Path) -> Path:
    """Return where the scenario of a map is, if there is one."""
    return path.with_name(f"{path.name}.scen")


def with_scenario(drawing: Drawing, text: str, name: str) -> Drawing:
    """Return a drawing with the start of a scenario's first pair and the goals of its first pairs.

    Pairs are left out whose goal is their start, the life's start or an earlier goal.

    Raises
    ------
    UserError
        Naming the line that is no pair on this map.
    """
    rows, columns = drawing.free.shape
    start: Cell | None = None
    goals: dict[Cell, int] = {}
    pairs = 0
    for number, line in enumerate(text.split("\n"), start=1):
        if not line.strip() or (number == 1 and SCENARIO.match(line + "\n")):
            continue
        pairs += 1
        if len(goals) == PAIRS:
            continue
        fields = line.split("\t") if "\t" in line else line.split()
        try:
            width, height, *places = map(int, fields[2:8])
            first, last = (places[1], places[0]), (places[3], places[2])  # x and y in the file
        except (ValueError, IndexError):
            raise UserError(
                f"{name}: line {number}: is no pair of a Moving AI scenario; give bucket, map, width, height, start x"
                " and y, goal x and y, and length, separated by tabs"
            ) from None
        if (width, height) != (columns, rows):
            raise UserError(
                f"{name}: line {number}: width {width} and height {height} are not those of the map, {columns} and"
                f" {rows}; use the scenario of this map"
            )
        for place, cell in (("start", first), ("goal", last)):
            if not (0 <= cell[0] < rows and 0 <= cell[1] < columns and drawing.free[cell]):
                raise UserError(
                    f"{name}: line {number}: the {place} x {cell[1]}, y {cell[0]} is not a free cell of the map"
                )
        start = start or first
        if last not in (first, start, *goals):
            goals[last] = pairs
    if not goals or start is None:
        raise UserError(f"{name}: has no pair of two places; correct it or rename it")
    used = ", ".join(map(str, goals.values()))
    note = f"{name}: start of the first of {pairs} pairs, goals of pairs {used}; every task begins at that start"
    return Drawing(drawing.free, start, tuple(goals), (*drawing.notes, note))
