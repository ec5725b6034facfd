"""Maps in the Moving AI text format (Sturtevant, 2012, doi:10.1109/TCIAIG.2012.2197681)."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from ptl.errors import UserError
from ptl.world.gridworld import MAX_CELLS, GridWorld, read_text
from ptl.world.mazes import FREE, WALL
from studies.beyond.maps import place_tasks

FAMILY = "moving_ai"
"""Family of these maps."""

HEADER = re.compile(r"type +\S.*\nheight +([0-9]+) *\nwidth +([0-9]+) *\nmap *\n")
"""First lines of a file."""


def load_moving_ai(path: str | Path) -> GridWorld:
    """Read a map and place a start and six goals in increasing order."""
    return place_tasks(read_moving_ai(path), Path(path).stem, 0)


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
