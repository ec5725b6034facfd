"""Generated maps of any size: chains of rooms, open grids with random walls, random rooms.

Our choice throughout; the article has three fixed maps. These serve the tests and the measurements of how the cost
grows. A map text has ``#`` for a wall, ``.`` for a free cell, ``I`` for the start and letters for goals. Every map
joins its start to all of its goals; open grids may keep free cells that no path leads to.
"""

from __future__ import annotations

from collections import deque

import numpy as np

WALL, FREE, START = "#", ".", "I"
GOALS = "ABCDEF"


def chain_of_rooms(rooms: int, size: int = 10, goals: str = GOALS) -> str:
    """Return ``rooms`` square rooms of ``size`` x ``size`` cells in a row, one doorway between neighbours.

    Doors are in the same row everywhere, ``I`` in the first room, goals deep in the last
    ``len(goals)`` rooms.
    ``chain_of_rooms(7)`` is environment 1.
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


def open_grid(rng: np.random.Generator, rows: int, columns: int, wall_share: float, goals: str = GOALS) -> str:
    """Return a framed grid with random walls; start and goals are in one connected part."""
    grid = framed(rows, columns)
    inside = grid[1:-1, 1:-1]
    inside[rng.random(inside.shape) < wall_share] = WALL
    return to_text(with_letters(rng, grid, goals))


def random_rooms(rng: np.random.Generator, rows: int, columns: int, goals: str = GOALS) -> str:
    """Return a framed grid, cut recursively into rooms by walls with one or two doors each."""
    grid = framed(rows, columns)
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
    return to_text(with_letters(rng, grid, goals))


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
