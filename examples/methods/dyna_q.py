"""Dyna-Q (Sutton, 1990): Q-learning with further updates from a learned model after each step."""

from __future__ import annotations

from ptl.methods import BaseMethod

UPDATES = 10


class Method(BaseMethod):
    """Dyna-Q; the model, which knows no goal, is kept from task to task."""

    label = "Dyna-Q"
    colour = "#17becf"

    def __init__(self, world, parameters, random):
        super().__init__(world, parameters, random)
        self.model = {}

    def begin_task(self, start, goal):
        self.goal = goal

    def run_episode(self, learner):
        gamma = self.parameters.learning.gamma
        while not (learner.at_goal or learner.truncated):
            state, action = learner.state, learner.choose()
            self.model[state, action] = learner.act(action)
            pairs = list(self.model)
            for number in self.random.integers(len(pairs), size=UPDATES):
                after = self.model[pairs[number]]
                target = 1.0 if after == self.goal else gamma * max(learner.values_of(after))
                learner.update(*pairs[number], target)
