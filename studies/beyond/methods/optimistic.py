"""Optimistic initial values: every action is worth trying until it has disappointed (Koenig and Simmons, 1996)."""

from __future__ import annotations

import numpy as np

from ptl.agent._kernel import Learner
from ptl.methods._base import BaseMethod


class Method(BaseMethod):
    """Greedy Q-learning from Q = 1, the value of a step into the goal, in each task.

    S. Koenig, R. Simmons, Machine Learning 22, 1996: the initial values decide whether undirected exploration takes
    exponential or polynomial time.
    """

    label = "Optimistic Q"
    colour = "#35978f"

    def begin_task(self, start: int, goal: int) -> np.ndarray | None:
        return np.ones((self.world.n_states, 4))

    def run_episode(self, learner: Learner) -> list[int]:
        learner.explore(epsilon=0.0)
        return []
