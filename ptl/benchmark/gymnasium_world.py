"""A grid world as a Gymnasium environment, as small as the interface allows."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np


class GymnasiumWorld(gymnasium.Env):
    """States 0..n-1, four actions, reward 1 at the goal, which ends the episode."""

    def __init__(self, successors: np.ndarray, start: int, goal: int) -> None:
        self.observation_space = gymnasium.spaces.Discrete(len(successors))
        self.action_space = gymnasium.spaces.Discrete(successors.shape[1])
        self._successors, self._start, self._goal = successors, start, goal
        self._state = start

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[int, dict]:
        """Put the agent on the start."""
        super().reset(seed=seed)
        self._state = self._start
        return self._state, {}

    def step(self, action: int) -> tuple[int, float, bool, bool, dict]:
        """One primitive step."""
        self._state = int(self._successors[self._state, action])
        ended = self._state == self._goal
        return self._state, float(ended), ended, False, {}
