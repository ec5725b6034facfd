"""Q-learning that explores by counts: actions that were seldom taken get a bonus (Strehl and Littman, 2008)."""

from __future__ import annotations

import numpy as np

from ptl.methods import BaseMethod

WEIGHT = 0.1


class Method(BaseMethod):
    """Greedy over Q(s,a) + WEIGHT / sqrt(1 + n(s,a)), where n counts how often a was taken in s in this task."""

    label = "Count bonus"
    colour = "#bcbd22"

    def begin_task(self, start, goal):
        self.counts = np.zeros((self.world.n_states, 4))

    def run_episode(self, learner):
        while not (learner.at_goal or learner.truncated):
            state = learner.state
            action = learner.choose(epsilon=0.0, bonus=WEIGHT / np.sqrt(1 + self.counts[state]))
            self.counts[state, action] += 1
            learner.act(action)
