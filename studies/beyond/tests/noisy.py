"""A robot whose moves are uncertain, in plain Python, and what its best policy costs."""

from __future__ import annotations

import numpy as np


class NoisyLearner:
    """The part of `ptl.agent._kernel.Learner` that methods with a model use; with probability p a move is any move."""

    truncated = False

    def __init__(self, successors: np.ndarray, goal: int, slip: float, seed: int) -> None:
        self.successors, self.goal, self.slip = successors, goal, slip
        self.random = np.random.default_rng(seed)

    @property
    def at_goal(self) -> bool:
        return self.state == self.goal

    def begin_episode(self, start: int) -> None:
        self.state, self.steps = start, 0

    def act(self, action: int) -> int:
        if self.random.random() < self.slip:
            action = int(self.random.integers(4))
        self.state = int(self.successors[self.state, action])
        self.steps += 1
        assert self.steps < 10**5
        return self.state


def expected_steps(successors: np.ndarray, goal: int, slip: float) -> np.ndarray:
    """Return the expected steps to the goal under the best policy, float (n_states,)."""
    steps = np.zeros(len(successors))
    for _ in range(10**4):
        of_moves = steps[successors]
        new = 1 + ((1 - slip) * of_moves + slip * of_moves.mean(axis=1, keepdims=True)).min(axis=1)
        new[goal] = 0
        if np.abs(new - steps).max() < 1e-9:
            return new
        steps = new
    raise AssertionError("the goal is not reached from everywhere")
