"""Full transfer: all that was learned for the previous task is carried into the next one."""

from __future__ import annotations

import numpy as np

from ptl._kernel import Learner
from ptl.gridworld import GridWorld
from ptl.methods._base import BaseMethod
from ptl.parameters import Parameters


class Method(BaseMethod):
    """Epsilon-greedy Q-learning from the final Q of the previous task (stated by the article)."""

    label = "Full transfer"
    colour = "#d55e00"

    def __init__(self, world: GridWorld, parameters: Parameters, random: np.random.Generator) -> None:
        super().__init__(world, parameters, random)
        self._previous_q: np.ndarray | None = None

    def begin_task(self, start: int, goal: int) -> np.ndarray | None:
        return self._previous_q

    def run_episode(self, learner: Learner) -> list[int]:
        learner.explore()
        return []

    def end_task(self, q: np.ndarray) -> None:
        self._previous_q = q
