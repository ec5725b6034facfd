"""Places on a map that claims mention: doorways, rooms and their doors, all derived from the map."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from scipy import ndimage

from ptl.claims.evidence import MissingEvidence
from ptl.world.gridworld import GridWorld

NORTH, SOUTH, WEST, EAST = range(4)


def doorways(world: GridWorld) -> np.ndarray:
    """Return the states between two opposite walls and two opposite free cells, int array (k,)."""
    own = np.arange(world.n_states)
    blocked = world.successors == own[:, np.newaxis]
    upright = blocked[:, WEST] & blocked[:, EAST] & ~blocked[:, NORTH] & ~blocked[:, SOUTH]
    across = blocked[:, NORTH] & blocked[:, SOUTH] & ~blocked[:, WEST] & ~blocked[:, EAST]
    states = np.flatnonzero(upright | across)
    if not states.size:
        raise MissingEvidence(f"{world.name}: there is no doorway on this map")
    return states


def newest_doorway(world: GridWorld, goal: int) -> int:
    """Return the last doorway on the shortest paths from the start to a goal."""
    from_start, to_goal = world.distances_to(world.start), world.distances_to(goal)
    doors = doorways(world)
    on_the_way = doors[(from_start + to_goal)[doors] == from_start[goal]]
    if not on_the_way.size:
        raise MissingEvidence(f"{world.name}: there is no doorway between the start and a goal")
    return int(on_the_way[to_goal[on_the_way].argmin()])


def rooms(world: GridWorld) -> np.ndarray:
    """Return the room of each state, int array (n_states,), -1 at doorways.

    A room is a set of states that stays connected when the doorways are walled up.
    """
    free = np.zeros(world.shape, dtype=bool)
    free[tuple(world.cells.T)] = True
    free[tuple(world.cells[doorways(world)].T)] = False
    numbers, _ = ndimage.label(free)
    return numbers[tuple(world.cells.T)] - 1


def doors_of(world: GridWorld, room: int) -> np.ndarray:
    """Return the doorways next to a room, int array (k,)."""
    numbers, doors = rooms(world), doorways(world)
    return doors[(numbers[world.successors[doors]] == room).any(axis=1)]


def near(world: GridWorld, places: Iterable[int], steps: int) -> np.ndarray:
    """Return whether each state is within some steps of one of the places, bool array (n_states,)."""
    return steps_to(world, places) <= steps


def steps_to(world: GridWorld, places: Iterable[int]) -> np.ndarray:
    """Return the steps from each state to the nearest of some places, int array (n_states,)."""
    return np.min([world.distances_to(int(place)) for place in places], axis=0)


def rectangle(world: GridWorld, rows: tuple[int, int], columns: tuple[int, int], shape: tuple[int, int]) -> np.ndarray:
    """Return whether each state is in a range of rows and columns (both ends included), bool array (n_states,).

    Raises
    ------
    MissingEvidence
        When the map is not of the ``shape`` for which the range was defined.
    """
    if world.shape != shape:
        raise MissingEvidence(
            f"{world.name}: is not the map of {shape[0]} by {shape[1]} cells that the claim speaks of"
        )
    row, column = world.cells.T
    return (rows[0] <= row) & (row <= rows[1]) & (columns[0] <= column) & (column <= columns[1])
