"""Families of generated maps: grids with about a given number of free cells, without letters. Our choice throughout."""

from __future__ import annotations

import numpy as np

from ptl.world.mazes import FREE, WALL, framed, largest_part, maze, rooms


def chain(rng: np.random.Generator, states: int) -> np.ndarray:
    """Return six to nine rooms of random lengths in a row, with a door at a random place of each wall between."""
    rooms = int(rng.integers(6, 10))
    height = round(np.sqrt(states / rooms))
    length = states / rooms / height
    lengths = rng.integers(max(2, round(0.6 * length)), round(1.4 * length) + 1, rooms)
    grid = framed(height + 2, lengths.sum() + rooms + 1)
    for wall in np.cumsum(lengths + 1)[:-1]:
        grid[:, wall] = WALL
        grid[rng.integers(1, height + 1), wall] = FREE
    return grid


def braided(rng: np.random.Generator, states: int) -> np.ndarray:
    """Return a maze without dead ends: one more wall of each is opened."""
    grid = maze(rng, round(0.9 * states))
    for row, column in np.argwhere(grid[1::2, 1::2] == FREE) * 2 + 1:
        sides = [(row - 1, column), (row + 1, column), (row, column - 1), (row, column + 1)]
        closed = [(r, c) for r, c in sides if grid[r, c] == WALL]
        inner = [(r, c) for r, c in closed if 0 < r < len(grid) - 1 and 0 < c < len(grid) - 1]
        if len(closed) == 3:
            grid[inner[rng.integers(len(inner))]] = FREE
    return grid


def cave(rng: np.random.Generator, states: int) -> np.ndarray:
    """Return a cave: a cellular automaton on random walls, in which a cell takes the majority of its nine."""
    side = round(np.sqrt(1.9 * states)) + 2
    while True:
        wall = np.ones((side, side), dtype=int)
        wall[1:-1, 1:-1] = rng.random((side - 2, side - 2)) < 0.43
        for _ in range(3):
            around = np.sum([np.roll(wall, (y, x), (0, 1)) for y in (-1, 0, 1) for x in (-1, 0, 1)], axis=0)
            wall[1:-1, 1:-1] = around[1:-1, 1:-1] >= 5
        grid = np.where(wall, WALL, FREE)
        if 0.75 < len(largest_part(grid)) / states < 1.25:
            return grid


def ground(rng: np.random.Generator, states: int) -> np.ndarray:
    """Return open ground with rectangular obstacles on a fifth of it."""
    side = round(np.sqrt(1.25 * states)) + 2
    grid = framed(side, side)
    while np.mean(grid[1:-1, 1:-1] == WALL) < 0.2:
        top, left = rng.integers(1, side - 1, 2)
        height, width = rng.integers(1, 5, 2)
        grid[top : min(top + height, side - 1), left : min(left + width, side - 1)] = WALL
    return grid


FAMILIES = {"chain": chain, "rooms": rooms, "maze": maze, "braided": braided, "cave": cave, "ground": ground}
"""Generators by the name of the family: a random generator and a number of states give a grid."""
