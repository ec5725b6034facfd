"""Exact expectations that need no run."""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import spsolve

from ptl.config import Learning
from ptl.world.gridworld import GridWorld

MAX_STATES = 10**5
"""Maximum number of states for the linear system; it takes seconds then."""

ROOM = 50
"""Minimum step limit in numbers of the expected steps. Lengths of walks have an exponential tail, so that hardly one in
10^20 is truncated."""


def expected_first_episode(world: GridWorld, goal: int, learning: Learning) -> float | None:
    """Return the expected steps of a first episode without transfer, None if it is no uniform walk or too large."""
    if learning.ties != "random" or world.n_states > MAX_STATES:
        return None
    expected = first_episode_without_transfer(world, goal)
    return expected if learning.max_steps >= ROOM * expected else None


def first_episode_without_transfer(world: GridWorld, goal: int) -> float:
    """Return the expected steps of a first episode from Q = 0, which is a uniform random walk from start to goal.

    The expected steps m of all states that the start reaches solve m(s) = 1 + the mean of m over the four next states,
    with m = 0 at the goal.
    """
    states = np.flatnonzero(world.distances_to(goal) > 0)
    place = np.full(world.n_states, -1)
    place[states] = np.arange(len(states))
    after = place[world.successors[states]]
    rows, actions = np.nonzero(after >= 0)
    walk = sparse.coo_array((np.full(len(rows), 0.25), (rows, after[rows, actions])), shape=(len(states),) * 2)
    system = sparse.eye_array(len(states)) - walk
    return float(spsolve(system.tocsc(), np.ones(len(states)))[place[world.start]])
