"""Exact expectations that need no run."""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import spsolve

from ptl.world.gridworld import GridWorld


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
