"""Formats of maps that other programs write, one file each; `ptl.world.map_files` chooses among them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

Cell = tuple[int, int]
"""Row and column, counted from 0."""

GOALS = "ABCDEFGHJKLMNOPQRSTUVWXYZ"
"""Letters of goals in the order in which they are given."""


class Drawing(NamedTuple):
    """What a file says about a map.

    Attributes
    ----------
    free : bool array, shape (rows, columns)
    start : (row, column) or None
        None if the file has no start.
    goals : tuple of (row, column)
        Empty if the file has no goals.
    notes : tuple of str
        Sentences on what was read in another sense than in the program that wrote the file.
    """

    free: np.ndarray
    start: Cell | None = None
    goals: tuple[Cell, ...] = ()
    notes: tuple[str, ...] = ()


def shown(cell: Cell) -> str:
    """Return a cell as users count it: row and column from 1."""
    return f"row {cell[0] + 1}, column {cell[1] + 1}"
