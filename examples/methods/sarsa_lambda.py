"""Sarsa(lambda) with replacing eligibility traces (Singh and Sutton, 1996)."""

from __future__ import annotations

from ptl.methods import BaseMethod

LAMBDA = 0.9


class Method(BaseMethod):
    """Sarsa(lambda) from Q = 0 in each task."""

    label = "Sarsa(lambda)"
    colour = "#e377c2"

    def run_episode(self, learner):
        learning = self.parameters.learning
        traces = {}
        state, action = learner.state, learner.choose()
        while not (learner.at_goal or learner.truncated):
            after = learner.act(action, learn=False)
            action_after = learner.choose()
            target = 1.0 if learner.at_goal else learning.gamma * learner.value(after, action_after)
            error = target - learner.value(state, action)
            traces[state, action] = 1.0
            for pair, trace in traces.items():
                learner.set_value(*pair, learner.value(*pair) + learning.alpha * error * trace)
            decay = learning.gamma * LAMBDA
            traces = {pair: decay * trace for pair, trace in traces.items() if trace > 1e-3}
            state, action = after, action_after
