"""The start states of the survey of subgoals."""

from __future__ import annotations

import numpy as np

from ptl.agent import seeding
from ptl.world.gridworld import GridWorld


def chosen_starts(world: GridWorld, number: int | None, root_seed: int, environment: str) -> np.ndarray:
    """Return the start states of the survey: all, or a random sample of ``number`` of them in ascending order."""
    if number is None or number >= world.n_states:
        return np.arange(world.n_states)
    random = seeding.generator(root_seed, "subgoal_frequencies", environment, "starts")
    return np.sort(random.choice(world.n_states, size=number, replace=False))
