"""Places on a map that claims speak of: doorways, rooms and their doors, all found from the map itself."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ptl.evidence import Lacking
from ptl.gridworld import GridWorld

NORTH, SOUTH, WEST, EAST = range(4)


def doorways(world: GridWorld) -> np.ndarray:
    """States between two opposite walls and two opposite free cells, int array (k,)."""
    own = np.arange(world.n_states)
    blocked = world.successors == own[:, np.newaxis]
    upright = blocked[:, WEST] & blocked[:, EAST] & ~blocked[:, NORTH] & ~blocked[:, SOUTH]
    across = blocked[:, NORTH] & blocked[:, SOUTH] & ~blocked[:, WEST] & ~blocked[:, EAST]
    found = np.flatnonzero(upright | across)
    if not found.size:
        raise Lacking(f"{world.name}: there is no doorway on this map")
    return found


def newest_doorway(world: GridWorld, goal: int) -> int:
    """The last doorway on the shortest paths from the start to a goal."""
    from_start, to_goal = world.distances_to(world.start), world.distances_to(goal)
    doors = doorways(world)
    on_the_way = doors[(from_start + to_goal)[doors] == from_start[goal]]
    if not on_the_way.size:
        raise Lacking(f"{world.name}: no doorway lies between the start and a goal")
    return int(on_the_way[to_goal[on_the_way].argmin()])


def rooms(world: GridWorld) -> np.ndarray:
    """Room of each state, int array (n_states,): what stays connected without the doorways, which have -1."""
    room = np.full(world.n_states, -2)
    room[doorways(world)] = -1
    count = 0
    for first in range(world.n_states):
        if room[first] == -2:
            waiting = [first]
            room[first] = count
            while waiting:
                for state in world.successors[waiting.pop()]:
                    if room[state] == -2:
                        room[state] = count
                        waiting.append(state)
            count += 1
    return room


def doors_of(world: GridWorld, room: int) -> np.ndarray:
    """The doorways that touch a room, int array (k,)."""
    numbers, doors = rooms(world), doorways(world)
    return doors[(numbers[world.successors[doors]] == room).any(axis=1)]


def near(world: GridWorld, places: Iterable[int], steps: int) -> np.ndarray:
    """Whether each state is within some steps of one of the places, bool array (n_states,)."""
    return steps_to(world, places) <= steps


def steps_to(world: GridWorld, places: Iterable[int]) -> np.ndarray:
    """Steps from each state to the nearest of some places, int array (n_states,)."""
    return np.min([world.distances_to(int(place)) for place in places], axis=0)


def rectangle(world: GridWorld, rows: tuple[int, int], columns: tuple[int, int], shape: tuple[int, int]) -> np.ndarray:
    """States in a range of rows and columns (both ends included), bool array (n_states,).

    ``shape`` is that of the map on which the range was laid down; on another one it would mean nothing.
    """
    if world.shape != shape:
        raise Lacking(f"{world.name}: is not the map of {shape[0]} by {shape[1]} cells that the claim speaks of")
    row, column = world.cells.T
    return (rows[0] <= row) & (row <= rows[1]) & (columns[0] <= column) & (column <= columns[1])
