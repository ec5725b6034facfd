"""Variants of the reference maps in details that the article leaves open.

Changes are named ``<environment>.<kind>``, with the kinds

``start``       another start cell, [row, column] counted from 0,
``room_size``   a chain of seven square rooms with this many cells on a side,
``goal_depth``  a chain of seven rooms whose goals lie this far inside, as a share of the room's length.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from ptl.errors import UserError
from ptl.world.gridworld import GridWorld

ROOM_SIZE, GOAL_DEPTH = 10, 0.9
"""The values behind the reference map of environment 1."""

KINDS = ("start", "room_size", "goal_depth")


def changed_world(world: GridWorld, changes: Mapping[str, object]) -> GridWorld:
    """Return the world with changes, by kind; the world itself if there are none.

    Raises
    ------
    UserError
        For an unknown kind, a value that makes no map, or a chain of rooms asked for on another kind of map.
    """
    unknown = set(changes) - set(KINDS)
    if unknown:
        raise UserError(f"{world.name}: cannot change {unknown.pop()!r}; known are {', '.join(KINDS)}")
    if "room_size" in changes or "goal_depth" in changes:
        if world.text != chain_of_rooms(ROOM_SIZE, GOAL_DEPTH):
            raise UserError(
                f"{world.name}: is not the chain of seven rooms, so neither room_size nor goal_depth can be"
                " changed; vary them in environment 1 only"
            )
        text = chain_of_rooms(changes.get("room_size", ROOM_SIZE), changes.get("goal_depth", GOAL_DEPTH))
        world = GridWorld.from_text(text, name=world.name)
    if "start" in changes:
        world = with_start(world, changes["start"])  # type: ignore[arg-type]
    return world


def with_start(world: GridWorld, cell: Sequence[int]) -> GridWorld:
    """Return the same map with ``I`` in another free cell, (row, column) counted from 0."""
    row, column = (int(place) for place in cell)
    rows = [list(line.replace("I", ".")) for line in world.text.splitlines()]
    if not (0 <= row < len(rows) and 0 <= column < len(rows[0]) and rows[row][column] == "."):
        raise UserError(
            f"{world.name}: row {row}, column {column} (from 0) is not a free cell without a goal; choose another start"
        )
    rows[row][column] = "I"
    return GridWorld.from_text("\n".join(map("".join, rows)) + "\n", name=world.name)


def chain_of_rooms(size: object = ROOM_SIZE, depth: object = GOAL_DEPTH, rooms: int = 7) -> str:
    """Return the text of environment 1's map with another room size and goal depth (the drawing is our choice).

    Rooms of ``size`` x ``size`` cells form a row with doors in the same place of every wall; room k + 1
    holds the k-th goal.

    Parameters
    ----------
    size : int
        Cells on a side, at least 4.
    depth : float
        Place of the goals from the wall with the door, as a share of ``size``, in (0, 1].
    """
    if not (isinstance(size, int) and size >= 4):
        raise UserError(f"room_size: {size!r} is not allowed; give a whole number of at least 4")
    if not (isinstance(depth, int | float) and 0 < depth <= 1):
        raise UserError(f"goal_depth: {depth!r} is not allowed; give a number in (0, 1]")
    door_row, goal_row = size // 2 + 1, _share(size, GOAL_DEPTH)
    grid = [["#"] * (rooms * (size + 1) + 1) for _ in range(size + 2)]
    for room in range(rooms):
        left = room * (size + 1) + 1
        for row in range(1, size + 1):
            grid[row][left : left + size] = "." * size
        if room:
            grid[door_row][left - 1] = "."
            grid[goal_row][left + _share(size, depth) - 1] = chr(ord("A") + room - 1)
    grid[2][2] = "I"
    return "\n".join(map("".join, grid)) + "\n"


def _share(size: int, share: float) -> int:
    """Return the cell, counted from 1, at a share of the room's length."""
    return max(1, round(share * size))


def cells_that_must_pass(world: GridWorld, through: np.ndarray, goals: Iterable[int]) -> np.ndarray:
    """Return the states, goals excluded, from which every path to each of ``goals`` passes a region, bool (n_states,).

    Parameters
    ----------
    through : bool array (n_states,)
        The region; its own cells are not counted.
    goals : iterable of int
        States outside the region.
    """
    result = ~through
    result[list(world.goals.values())] = False
    for goal in goals:
        open_ = ~through
        reached = np.zeros(world.n_states, dtype=bool)
        reached[goal] = True
        frontier = [goal]
        while frontier:
            after = np.unique(world.successors[frontier])
            frontier = after[open_[after] & ~reached[after]].tolist()
            reached[frontier] = True
        result &= ~reached
    return result


def region(world: GridWorld, rows: Sequence[int], columns: Sequence[int]) -> np.ndarray:
    """Return the free cells between two rows and two columns (inclusive, from 0), bool (n_states,)."""
    row, column = world.cells.T
    return (rows[0] <= row) & (row <= rows[1]) & (columns[0] <= column) & (column <= columns[1])
