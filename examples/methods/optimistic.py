"""Optimistic initial values: every action is worth trying until it has disappointed (Sutton and Barto, 2.6)."""

from __future__ import annotations

import numpy as np

from ptl.methods import BaseMethod


class Method(BaseMethod):
    """Greedy Q-learning from Q = 1, the value of a step into the goal."""

    label = "Optimistic"
    colour = "#7f7f7f"

    def begin_task(self, start, goal):
        return np.ones((self.world.n_states, 4))

    def run_episode(self, learner):
        learner.explore(epsilon=0.0)
