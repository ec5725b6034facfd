"""Map texts of all kinds as a Hypothesis strategy, and open grids; the other generators are those of the package."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

from ptl.world.gridworld import GridWorld
from ptl.world.mazes import GOALS, WALL, chain_of_rooms, framed, random_rooms, to_text, with_letters

__all__ = ["chain_of_rooms", "framed", "maps", "open_grid", "random_rooms", "random_world", "to_text"]


def open_grid(rng: np.random.Generator, rows: int, columns: int, wall_share: float, goals: str = GOALS) -> str:
    """Return a framed grid with random walls; start and goals are connected, other free cells need not be."""
    grid = framed(rows, columns)
    inside = grid[1:-1, 1:-1]
    inside[rng.random(inside.shape) < wall_share] = WALL
    return to_text(with_letters(rng, grid, goals))


@st.composite
def maps(draw: st.DrawFn, goals: str = GOALS, largest: int = 14) -> str:
    """Hypothesis strategy: map texts of all kinds, open grids and rooms of at most ``largest`` rows."""
    kind = draw(st.sampled_from(["open", "rooms", "chain"]))
    if kind == "chain":
        return chain_of_rooms(len(goals) + draw(st.integers(1, 2)), draw(st.integers(3, 5)), goals)
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    rows, columns = draw(st.integers(5, largest)), draw(st.integers(5, largest))
    if kind == "rooms":
        return random_rooms(rng, rows, columns, goals)
    return open_grid(rng, rows, columns, draw(st.sampled_from([0.0, 0.15, 0.3])), goals)


def random_world(rng: np.random.Generator) -> GridWorld:
    """Return a small open grid with random walls, of some 60 states."""
    return GridWorld.from_text(open_grid(rng, 10, 11, 0.25), "random")
