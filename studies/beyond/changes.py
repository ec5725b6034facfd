"""Maps that change between tasks: a door closes, or some cells change. Our choice throughout."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from itertools import pairwise

import numpy as np
from scipy.ndimage import label

from ptl.errors import UserError
from ptl.world.gridworld import GridWorld
from ptl.world.mazes import FREE, WALL, stream, to_text

SHARE = 0.05
"""Share of the cells that change at a time, of the number of free cells."""

SIDES = ((-1, 0), (1, 0), (0, -1), (0, 1))
"""North, south, west and east of a cell."""

Cell = tuple[int, int]

Rule = Callable[[np.ndarray, np.random.Generator], bool]
"""Changes a grid of letters in place; returns whether it could."""


def changed_map(text: str, rule: str, *names: str | int) -> str:
    """Return the text of a map after a change; start and goals stay, and each goal can still be reached.

    Parameters
    ----------
    rule : str
        A name in `RULES`.
    names : str or int
        What the random numbers derive from, say a seed; equal arguments give equal maps.

    Raises
    ------
    UserError
        If the map cannot change by this rule.
    """
    grid = np.array([list(row) for row in text.splitlines()])
    if not RULES[rule](grid, stream("change", rule, *names)):
        raise UserError(f"map: cannot change by the rule {rule!r}; take another rule or a larger map")
    return to_text(grid)


def changing_worlds(world: GridWorld, rule: str, number: int, *names: str | int) -> list[GridWorld]:
    """Return a map and what becomes of it in ``number - 1`` changes, one after another.

    All have the states of one map, in which a cell is free that is free in any of them: numbers of states keep their
    meaning, so a method that compares them need not be told of a change. Cells that are walls at a time are closed.
    Where a map cannot change by the rule, say because no door is left, it stays as it is.

    Parameters
    ----------
    names : str or int
        As in `changed_map`, followed by the number of the change.
    """
    texts = [world.text]
    for change in range(1, number):
        try:
            texts.append(changed_map(texts[-1], rule, *names, change))
        except UserError:
            texts.append(texts[-1])
    grids = np.array([[list(row) for row in text.splitlines()] for text in texts])
    letters = np.where((grids == WALL).all(axis=0) | (grids[0] != WALL), grids[0], FREE)
    union = GridWorld.from_text(to_text(letters), world.name, world.slip)
    return [union.with_closed(grid[tuple(union.cells.T)] == WALL) for grid in grids]


# -- rules --------------------------------------------------------------------------------------------------------


def _door(grid: np.ndarray, rng: np.random.Generator) -> bool:
    """Close a door, one of the narrowest that can be closed.

    A door is a straight gap between two walls, with free cells in front of and behind all of its own. If a goal cannot
    be reached without it, another door opens: a wall cell between the two parts.
    """
    doors = _doors(grid)
    for place in sorted(rng.permutation(len(doors)).tolist(), key=lambda place: len(doors[place])):
        door = doors[place]
        _set(grid, door, WALL)
        if _joined(grid):
            return True
        if between := _between(grid, door):
            grid[between[rng.integers(len(between))]] = FREE
            return True
        _set(grid, door, FREE)
    return False


def _doors(grid: np.ndarray) -> list[list[Cell]]:
    """Return the cells of each door."""
    return [*_gaps(grid), *([(row, column) for column, row in gap] for gap in _gaps(grid.T))]


def _gaps(grid: np.ndarray) -> Iterator[list[Cell]]:
    """Yield the doors whose cells are in one row."""
    for row in range(1, len(grid) - 1):
        walls = [-1, *np.flatnonzero(grid[row] == WALL).tolist(), grid.shape[1]]
        for first, last in pairwise(walls):
            cells = [(row, column) for column in range(first + 1, last)]
            passed = (grid[row - 1 : row + 2, first + 1 : last] != WALL).all()
            if cells and passed and (grid[row, first + 1 : last] == FREE).all():
                yield cells


def _between(grid: np.ndarray, door: Collection[Cell]) -> list[Cell]:
    """Return the wall cells, other than those of a closed door, that touch both of the parts that it joined."""
    parts = _parts(grid)
    sides = {part for cell in door for part in _around(parts, cell) if part}
    walls = [(int(row), int(column)) for row, column in np.argwhere(_inner_walls(grid))]
    return [cell for cell in walls if cell not in door and sides <= {*_around(parts, cell)}]


def _set(grid: np.ndarray, cells: Collection[Cell], letter: str) -> None:
    for cell in cells:
        grid[cell] = letter


def _cells(grid: np.ndarray, rng: np.random.Generator) -> bool:
    """Change `SHARE` of the cells: wall cells beside free ones open, then as many free cells close, or one less."""
    number = max(2, round(SHARE * np.count_nonzero(grid != WALL)))
    parts = _parts(grid)
    walls = [tuple(cell) for cell in np.argwhere(_inner_walls(grid)).tolist() if any(_around(parts, cell))]
    free = [tuple(cell) for cell in np.argwhere(grid == FREE)]
    if len(walls) < (number + 1) // 2:
        return False
    for place in rng.permutation(len(walls))[: (number + 1) // 2]:
        grid[walls[place]] = FREE
    closed = 0
    for place in rng.permutation(len(free)):
        if closed == number // 2:
            break
        grid[free[place]] = WALL
        if _joined(grid):
            closed += 1
        else:
            grid[free[place]] = FREE
    return closed == number // 2


RULES: dict[str, Rule] = {"door": _door, "cells": _cells}
"""Changes by name: a door closes, and opens elsewhere if it has to; or `SHARE` of the cells change."""


# -- grids --------------------------------------------------------------------------------------------------------


def _inner_walls(grid: np.ndarray) -> np.ndarray:
    """Return the walls that are not on the border, bool (rows, columns)."""
    inner = np.zeros(grid.shape, dtype=bool)
    inner[1:-1, 1:-1] = grid[1:-1, 1:-1] == WALL
    return inner


def _parts(grid: np.ndarray) -> np.ndarray:
    """Return the number of the connected part of each free cell, 0 on walls."""
    return label(grid != WALL)[0]


def _around(parts: np.ndarray, cell: Sequence[int]) -> list[int]:
    """Return the parts on the sides of a cell that are on the map."""
    rows, columns = parts.shape
    beside = [(cell[0] + row, cell[1] + column) for row, column in SIDES]
    return [int(parts[row, column]) for row, column in beside if 0 <= row < rows and 0 <= column < columns]


def _joined(grid: np.ndarray) -> bool:
    """Return whether start and goals are in one part."""
    return len(set(_parts(grid)[(grid != WALL) & (grid != FREE)].tolist())) == 1
