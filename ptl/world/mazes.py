"""Generated maps of any size: chains of rooms, random rooms and mazes.

Our choice throughout; the article has three fixed maps. These serve the tests, the measurements of how the cost
grows, and studies. A map text has ``#`` for a wall,
``.`` for a free cell, ``I`` for the start and letters for goals. Every map joins its start to all of its goals.
"""

from __future__ import annotations

import hashlib
from collections import deque

import numpy as np

WALL, FREE, START = "#", ".", "I"
GOALS = "ABCDEF"


def chain_of_rooms(rooms: int, size: int = 10, goals: str = GOALS) -> str:
    """Return ``rooms`` square rooms of ``size`` x ``size`` cells in a row, one doorway between neighbours.

    Doors are in the same row everywhere, ``I`` in the first room, goals deep in the last
    ``len(goals)`` rooms.
    ``chain_of_rooms(7)`` is environment 1 of the first reference.
    """
    if rooms <= len(goals) or size < 3:
        raise ValueError("needs more rooms than goals, of at least 3 x 3 cells")
    grid = np.full((size + 2, rooms * (size + 1) + 1), WALL)
    for room in range(rooms):
        left = room * (size + 1) + 1
        grid[1 : size + 1, left : left + size] = FREE
        if room > 0:
            grid[size // 2 + 1, left - 1] = FREE
    grid[min(2, size), min(2, size)] = START
    for room, letter in enumerate(goals, start=rooms - len(goals)):
        grid[size - 1, room * (size + 1) + size - 1] = letter
    return to_text(grid)


def random_rooms(rng: np.random.Generator, rows: int, columns: int, goals: str = GOALS) -> str:
    """Return a framed grid, cut recursively into rooms by walls with one or two doors each."""
    return to_text(with_letters(rng, split_into_rooms(rng, framed(rows, columns)), goals))


def split_into_rooms(rng: np.random.Generator, grid: np.ndarray) -> np.ndarray:
    """Cut a framed grid recursively into rooms by walls with one or two doors each; return it."""
    rows, columns = grid.shape
    parts = [(1, 1, rows - 1, columns - 1)]
    while parts:
        top, left, bottom, right = parts.pop()
        height, width = bottom - top, right - left
        across = height > width or (height == width and bool(rng.integers(2)))
        if (height if across else width) < 5:
            continue
        doors = int(rng.integers(1, 3))
        # A wall never ends at a door of an older wall: its line is drawn again until both ends meet a wall.
        for _ in range(20):
            if across:
                line = int(rng.integers(top + 2, bottom - 2))
                ends = grid[line, left - 1], grid[line, right]
            else:
                line = int(rng.integers(left + 2, right - 2))
                ends = grid[top - 1, line], grid[bottom, line]
            if all(end == WALL for end in ends):
                break
        else:
            continue
        if across:
            grid[line, left:right] = WALL
            grid[line, rng.integers(left, right, doors)] = FREE
            parts += [(top, left, line, right), (line + 1, left, bottom, right)]
        else:
            grid[top:bottom, line] = WALL
            grid[rng.integers(top, bottom, doors), line] = FREE
            parts += [(top, left, bottom, line), (top, line + 1, bottom, right)]
    return grid


def framed(rows: int, columns: int) -> np.ndarray:
    """Return free cells within a frame of walls; (rows, columns) counts the frame."""
    grid = np.full((rows, columns), WALL)
    grid[1:-1, 1:-1] = FREE
    return grid


def with_letters(rng: np.random.Generator, grid: np.ndarray, goals: str) -> np.ndarray:
    """Put start and goals on random cells of the largest connected part; walls go if that is too small."""
    part = largest_part(grid)
    if len(part) <= len(goals):
        grid = framed(*grid.shape)
        part = largest_part(grid)
    if len(part) <= len(goals):
        raise ValueError(f"a map of {grid.shape} cells has no room for a start and {len(goals)} goals")
    for letter, cell in zip(START + goals, rng.permutation(len(part)), strict=False):
        grid[part[cell]] = letter
    return grid


def largest_part(grid: np.ndarray) -> list[tuple[int, int]]:
    """Return the cells of the largest connected set of free cells, row by row; the first of several."""
    free = [(int(row), int(column)) for row, column in np.argwhere(grid != WALL)]
    unvisited = set(free)
    best: list[tuple[int, int]] = []
    for cell in free:
        if cell not in unvisited:
            continue
        unvisited.remove(cell)
        part, seen = [], deque([cell])
        while seen:
            row, column = seen.popleft()
            part.append((row, column))
            for near in ((row - 1, column), (row + 1, column), (row, column - 1), (row, column + 1)):
                if near in unvisited:
                    unvisited.remove(near)
                    seen.append(near)
        if len(part) > len(best):
            best = part
    return sorted(best)


def to_text(grid: np.ndarray) -> str:
    """Return the map text of a grid of letters, shape (rows, columns)."""
    return "".join("".join(row) + "\n" for row in grid)


# -- grids with about a given number of free cells, without letters


def rooms(rng: np.random.Generator, states: int) -> np.ndarray:
    """Return a square cut recursively into rooms, with one or two doors in each wall."""
    side = round(np.sqrt(1.25 * states)) + 2
    return split_into_rooms(rng, framed(side, side))


def maze(rng: np.random.Generator, states: int) -> np.ndarray:
    """Return a perfect maze, in which one path joins any two cells (Kruskal's algorithm with random weights)."""
    side = round(np.sqrt(states / 2))
    grid = np.full((2 * side + 1, 2 * side + 1), WALL)
    grid[1::2, 1::2] = FREE
    part = np.arange(side * side)
    walls = [(row, column) for row in range(1, 2 * side) for column in range(1, 2 * side) if (row + column) % 2]
    for row, column in rng.permutation(walls):
        across = row % 2 == 0
        first = (row - across) // 2 * side + (column - (not across)) // 2
        second = (row + across) // 2 * side + (column + (not across)) // 2
        if part[first] != part[second]:
            part[part == part[second]] = part[first]
            grid[row, column] = FREE
    return grid


def chain(rng: np.random.Generator, states: int) -> np.ndarray:
    """Return six to nine rooms of random lengths in a row, with a door at a random place of each wall between."""
    number = int(rng.integers(6, 10))
    height = round(np.sqrt(states / number))
    length = states / number / height
    lengths = rng.integers(max(2, round(0.6 * length)), round(1.4 * length) + 1, number)
    grid = framed(height + 2, lengths.sum() + number + 1)
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
    # The largest part takes more of a larger cave: beyond 3,000 states nearly 0.74 of it.
    side = round(np.sqrt((1.9 if states <= 3000 else 1.36) * states)) + 2
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


def stream(*names: str | int) -> np.random.Generator:
    """Return the random numbers of a generated map, which its names determine."""
    digest = hashlib.sha256("/".join(map(str, names)).encode()).digest()
    return np.random.Generator(np.random.SFC64(int.from_bytes(digest, "big")))


def draw(family: str, states: int, seed: int) -> np.ndarray:
    """Return the grid of a family, size and seed, without letters."""
    return FAMILIES[family](stream(family, states, seed), states)
