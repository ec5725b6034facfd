"""Grid worlds from the text of a map: states, transitions, start, goals and distances.

A map is plain text: ``#`` is a wall, ``.`` a free cell, ``I`` the start and every other capital letter a goal;
letters are free cells. The border of the text acts as a wall. A move into a wall leaves the agent where it is (our
choice; the article states only the four actions). Moves are deterministic unless the world slips: then a step goes,
with a given probability, in a direction drawn uniformly from the four instead of that of the action.
"""

from __future__ import annotations

import copy
import hashlib
import string
import unicodedata
from functools import cached_property
from typing import Self

import numpy as np

from ptl.errors import UserError
from ptl.world.transitions import TransitionGraph, checked_states

ACTIONS = ("north", "south", "west", "east")
"""Names of the actions in the order of every action axis in this package."""

MOVES = np.array([(-1, 0), (1, 0), (0, -1), (0, 1)])
"""Change of (row, column) by each action, shape (4, 2)."""

WALL, FREE, START = "#", ".", "I"
LETTERS = frozenset(f"{WALL}{FREE}{string.ascii_uppercase}")
"""Letters of a map's text."""

MAX_CELLS = 2**20
"""Maximum size of a map in cells of text."""


class GridWorld:
    """A grid world read from the text of a map.

    Parameters
    ----------
    rows : list of str
    name : str
    slip : float
        Probability that a step goes in a random direction.

    Attributes
    ----------
    name : str
        Where the map came from; used in messages.
    text : str
        The map, one line a row, with a final line end.
    walls : bool array, shape (rows, columns)
    cells : int32 array, shape (n_states, 2)
        Row and column of each state; states are numbered row by row.
    successors : int32 array, shape (n_states, 4)
        State after a step in each direction, in the order of `ACTIONS`.
    slip : float
        Probability that the direction of a step is drawn uniformly from the four, whatever the action; 0 in a
        deterministic world.
    start : int
        State of ``I``.
    goals : dict of str to int
        State of every goal letter, in alphabetical order.
    """

    def __init__(self, rows: list[str], name: str, slip: float = 0.0) -> None:
        self.check_letters(rows, name)
        self.slip = checked_slip(slip)
        letters = np.array([list(row) for row in rows])
        self.name = name
        self.text = "\n".join(rows) + "\n"
        self.walls = letters == WALL
        self._number = np.full(letters.shape, -1, dtype=np.int32)
        self.cells = np.argwhere(~self.walls).astype(np.int32)
        self._number[tuple(self.cells.T)] = np.arange(len(self.cells))
        self.start, self.goals = self._read_letters(letters)
        self.successors = self._transitions()
        for array in (self.walls, self.cells, self.successors, self._number):
            array.flags.writeable = False  # lives share the map
        self._check_reachable()

    @classmethod
    def from_text(cls, text: str, name: str = "map", slip: float = 0.0) -> GridWorld:
        """Read a map from its text.

        Raises
        ------
        UserError
            Naming the map, the cell (row and column, counted from 1) and the remedy.
        """
        # Only line feeds end a row: other separators of str.splitlines are unknown letters of a map.
        rows = text.removeprefix("\ufeff").replace("\r\n", "\n").rstrip("\n").split("\n")
        return cls(rows, name, slip)

    @staticmethod
    def check_letters(rows: list[str], name: str) -> None:
        """Refuse rows that are no map: unknown letters, rows of different lengths, none at all, or too many cells."""
        if not any(row.strip() for row in rows):
            raise UserError(f"{name}: the map is empty; write one line of text for each row of cells")
        if len(rows) * max(map(len, rows)) > MAX_CELLS:
            raise UserError(f"{name}: the map has more than {MAX_CELLS} cells; use a smaller one")
        for number, row in enumerate(rows, start=1):
            if not row.strip():
                raise UserError(f"{name}: row {number} is blank; remove the line, or fill it with '#'")
            if unknown := set(row) - LETTERS:
                column = min(row.index(letter) for letter in unknown)
                raise UserError(
                    f"{name}: unknown letter {_called(row[column])} in row {number}, column {column + 1};"
                    " use '#' for a wall, '.' for a free cell, 'I' for the start and other capital letters for goals"
                )
        for number, row in enumerate(rows, start=1):
            if len(row) != len(rows[0]):
                raise UserError(
                    f"{name}: row {number} has {len(row)} cells but row 1 has {len(rows[0])};"
                    " make all rows equally long (fill up with '#')"
                )

    def with_slip(self, slip: float) -> Self:
        """Return the same map with another probability of slipping; a number outside [0, 1] raises ValueError."""
        if slip == self.slip:
            return self
        other = copy.copy(self)
        other.slip = checked_slip(slip)
        return other

    def with_closed(self, closed: np.ndarray) -> Self:
        """Return the map with some of its cells closed: no step leads into or out of them, and all states keep their
        numbers.

        Parameters
        ----------
        closed : bool array, shape (n_states,)

        Raises
        ------
        UserError
            If the start or a goal is closed, or a goal cannot be reached.
        """
        for letter, state in {START: self.start, **self.goals}.items():
            if closed[state]:
                raise UserError(f"{self.name}: the cell of {letter!r} cannot be closed; close another one")
        other = copy.copy(self)
        other.__dict__.pop("transitions", None)
        own = np.arange(self.n_states, dtype=np.int32)[:, np.newaxis]
        other.successors = np.where(closed[:, np.newaxis] | closed[self.successors], own, self.successors)
        other.successors.flags.writeable = False
        other._check_reachable()
        return other

    # -- reading ------------------------------------------------------------------------------------------------

    def _read_letters(self, letters: np.ndarray) -> tuple[int, dict[str, int]]:
        where: dict[str, list[tuple[int, int]]] = {}
        for row, column in np.argwhere((letters != WALL) & (letters != FREE)):
            where.setdefault(str(letters[row, column]), []).append((int(row), int(column)))
        for letter, places in where.items():
            if len(places) > 1:
                (r1, c1), (r2, c2) = places[:2]
                raise UserError(
                    f"{self.name}: letter {letter!r} appears twice, in row {r1 + 1}, column {c1 + 1} and in"
                    f" row {r2 + 1}, column {c2 + 1}; keep one of them"
                )
        if START not in where:
            raise UserError(f"{self.name}: no start; put the letter 'I' on a free cell")
        states = {letter: int(self._number[places[0]]) for letter, places in sorted(where.items())}
        start = states.pop(START)
        if not states:
            raise UserError(f"{self.name}: no goal; put a capital letter other than 'I' on a free cell")
        return start, states

    def _transitions(self) -> np.ndarray:
        rows, columns = self.shape
        own = np.arange(self.n_states, dtype=np.int32)
        successors = np.empty((self.n_states, len(MOVES)), dtype=np.int32)
        for action, move in enumerate(MOVES):
            row, column = (self.cells + move).T
            inside = (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
            target = np.full(self.n_states, -1, dtype=np.int32)
            target[inside] = self._number[row[inside], column[inside]]
            successors[:, action] = np.where(target < 0, own, target)
        return successors

    def _check_reachable(self) -> None:
        distance = self.distances_to(self.start)
        for letter, state in self.goals.items():
            if distance[state] < 0:
                row, column = self.cells[state]
                raise UserError(
                    f"{self.name}: goal {letter!r} in row {row + 1}, column {column + 1} cannot be reached from the"
                    " start; open a way through the walls or move the letter"
                )

    # -- asking -------------------------------------------------------------------------------------------------

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the map."""
        return self.walls.shape  # type: ignore[return-value]

    @property
    def n_states(self) -> int:
        """Number of free cells."""
        return len(self.cells)

    @cached_property
    def transitions(self) -> TransitionGraph:
        """All transitions of the map as a graph, each by the action in whose direction it leads."""
        return TransitionGraph(self.successors)

    @cached_property
    def diagonal(self) -> float:
        """Diagonal of the bounding box of the free cells, in cells (L of the prior)."""
        extent = self.cells.max(axis=0) - self.cells.min(axis=0) + 1
        return float(np.hypot(*extent))

    def goal(self, letter: str) -> int:
        """Return the state of a goal letter; a letter that is not on the map raises UserError."""
        if letter not in self.goals:
            raise UserError(
                f"{self.name}: no goal {letter!r} on the map; put the letter on a free cell or take the task out"
                f" (goals on the map: {''.join(self.goals)})"
            )
        return self.goals[letter]

    def state_at(self, row: int, column: int) -> int:
        """Return the state of the cell in this row and column (counted from 0); a wall raises ValueError."""
        rows, columns = self.shape
        if not (0 <= row < rows and 0 <= column < columns) or self._number[row, column] < 0:
            raise ValueError(f"{self.name}: row {row}, column {column} is not a free cell")
        return int(self._number[row, column])

    def distances_to(self, state: int) -> np.ndarray:
        """Return the shortest path in steps from every state to ``state``, int32 (n_states,), -1 if there is none.

        Moves of a grid can be taken back, so these are also the distances from ``state``. What is not a state raises
        ValueError.
        """
        return self.transitions.steps_to(state)

    def shortest_path_length(self, origin: int, target: int) -> int:
        """Return the steps of the shortest path between two states, -1 if there is none."""
        return int(self.distances_to(target)[checked_states(origin, self.n_states)])

    def to_grid(self, values: np.ndarray, fill: float = np.nan) -> np.ndarray:
        """Lay a value per state (n_states,) out as the map, float array (rows, columns), ``fill`` on walls."""
        grid = np.full(self.shape, fill, dtype=float)
        grid[tuple(self.cells.T)] = values
        return grid

    def __repr__(self) -> str:
        rows, columns = self.shape
        slip = f", slip {self.slip}" if self.slip else ""
        goals = "".join(self.goals)
        return f"<GridWorld {self.name!r}: {rows} x {columns}, {self.n_states} states, goals {goals}{slip}>"


def checked_slip(slip: float) -> float:
    """Return a probability of slipping as a float, or raise ValueError."""
    if not 0 <= slip <= 1:
        raise ValueError(f"slip must be a probability from 0 to 1, not {slip!r}")
    return float(slip)


def _called(letter: str) -> str:
    """Return a character in quotes; one that cannot be seen with its name."""
    names = {" ": "a blank", "\t": "a tab", "\r": "a carriage return", "\x1a": "Ctrl-Z", "\ufeff": "a byte order mark"}
    name = names.get(letter) or ("" if letter.isprintable() else unicodedata.name(letter, "a control character"))
    return f"{letter!r} ({name})" if name else repr(letter)


def map_digest(text: str) -> str:
    """Return the first 16 digits of the sha256 of a map's text, as `GridWorld.text` gives it."""
    return hashlib.sha256(text.encode()).hexdigest()[:16]
