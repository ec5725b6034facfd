"""Mazes as texts of labmaze, FrozenLake, PointMaze and D4RL's maze2d, which their letters tell apart."""

from __future__ import annotations

import re
import string
from collections import Counter
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ptl.errors import UserError
from ptl.world.formats import GOALS, Cell, Drawing, shown

CAPITALS = frozenset(string.ascii_uppercase)


class Dialect(NamedTuple):
    """Letters of a kind of text.

    Attributes
    ----------
    walls, starts, goals : str
        Their letters; a letter that is both is a possible start and goal.
    free : set of str
        Other letters of free cells.
    signs : str
        Letters of which a text must have one.
    between : str
        Characters between cells, which are left out.
    note : str
    """

    walls: str
    starts: str
    goals: str
    free: frozenset[str]
    signs: str
    between: str = ""
    note: str = ""


DIALECTS = {
    "labmaze": Dialect("*", "P", "G", frozenset(" .") | CAPITALS, "*", note="other letters are objects on free cells"),
    "frozen_lake": Dialect("H", "S", "G", frozenset("F"), "FH", note="holes (H) are walls here"),
    "point_maze": Dialect("1", "rRcC", "gGcC", frozenset("0"), "01", " ,\t", note="1 is a wall, 0 is free"),
    "maze2d": Dialect("#", "", "G", frozenset("O"), "O", note="O is a free cell"),
}
"""Kinds of texts by name."""


def _fits(dialect: Dialect, letters: Counter[str]) -> bool:
    known = dialect.free.union(dialect.walls, dialect.starts, dialect.goals, dialect.between)
    return letters.keys() <= known and any(sign in letters for sign in dialect.signs)


def _fits_own(letters: Counter[str]) -> bool:
    """Return whether letters can be those of this package's texts, in which no letter appears twice."""
    return letters.keys() <= CAPITALS.union("#.") and all(letters[letter] < 2 for letter in CAPITALS)


def unlisted(text: str) -> str:
    """Return the rows of a text that lists them as programs do (``["SF", "FG"]``, ``[[1, "r"], [0, G]]``) as lines."""
    rows = re.findall(r"\[([^\[\]]*)\]", text)
    if len(rows) == 1:
        rows = re.findall(r"[\"']([^\"'\n]*)[\"']", rows[0])
    if not rows or not text.lstrip().startswith("[") or "{" in text:
        return text
    return "".join(re.sub(r"[\s,\"']", "", row) + "\n" for row in rows)


def candidates(text: str) -> list[str]:
    """Return the kinds of texts whose letters a text has; "text" is this package's."""
    letters = Counter(text.replace("\\", "\n"))
    letters.pop("\n", None)
    kinds: dict[str, Callable[[Counter[str]], bool]] = {
        "text": _fits_own,
        **{name: lambda letters, dialect=dialect: _fits(dialect, letters) for name, dialect in DIALECTS.items()},  # type: ignore[misc]
    }
    return [name for name, fits in kinds.items() if fits(letters)]


def read(text: str, kind: str, name: str, max_cells: int) -> Drawing:
    """Read a text; of several starts the first counts, and goals are numbered row by row.

    Raises
    ------
    UserError
        Naming the row that has another length, or the letter that is unknown.
    """
    dialect = DIALECTS[kind]
    lines = text.replace("\\", "\n") if kind == "maze2d" else text
    rows = [re.sub(f"[{dialect.between}]", "", row) if dialect.between else row for row in lines.split("\n")]
    while rows and not rows[-1].strip():
        rows.pop()
    width = max(map(len, rows), default=0)
    if len(rows) * width > max_cells:
        raise UserError(f"{name}: the map has more than {max_cells} cells; use a smaller one")
    for number, row in enumerate(rows, start=1):
        if len(row) != len(rows[0]):
            raise UserError(
                f"{name}: row {number} has {len(row)} cells but row 1 has {len(rows[0])}; a map of the format {kind}"
                " has rows of one length"
            )
    letters = np.array([list(row) for row in rows]).reshape(len(rows), width)
    unknown = ~np.isin(letters, [*dialect.free.union(dialect.walls, dialect.starts, dialect.goals)])
    if unknown.any():
        cell = _cells(unknown)[0]
        raise UserError(f"{name}: unknown letter {str(letters[cell])!r} in {shown(cell)} of a map of the format {kind}")
    starts, goals = (_cells(np.isin(letters, list(kinds))) for kinds in (dialect.starts, dialect.goals))
    start = starts[0] if starts else None
    notes = [f"read as {kind}" + f": {dialect.note}" * bool(dialect.note)]
    if len(starts) > 1:
        notes.append(f"the start is the first of {len(starts)}, in {shown(starts[0])}")
    goals = [cell for cell in goals if cell != start]
    if len(goals) > len(GOALS):
        notes.append(f"the goals are the first {len(GOALS)} of {len(goals)}")
    return Drawing(~np.isin(letters, list(dialect.walls)), start, tuple(goals[: len(GOALS)]), tuple(notes))


def _cells(chosen: np.ndarray) -> list[Cell]:
    return [(int(row), int(column)) for row, column in np.argwhere(chosen)]
