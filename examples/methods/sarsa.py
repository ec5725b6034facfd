"""Sarsa (Rummery and Niranjan, 1994): Q-learning's update with the action that is taken next."""

from __future__ import annotations

from ptl.methods import BaseMethod


class Method(BaseMethod):
    """Sarsa from Q = 0 in each task."""

    label = "Sarsa"
    colour = "#8c564b"

    def run_episode(self, learner):
        gamma = self.parameters.learning.gamma
        state, action = learner.state, learner.choose()
        while not (learner.at_goal or learner.truncated):
            after = learner.act(action, learn=False)
            action_after = learner.choose()
            target = 1.0 if learner.at_goal else gamma * learner.value(after, action_after)
            learner.update(state, action, target)
            state, action = after, action_after
