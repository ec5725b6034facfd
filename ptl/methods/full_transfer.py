"""Full transfer: Q-learning from the final Q of the previous task."""

from __future__ import annotations

import numpy as np

from ptl.agent._kernel import Learner
from ptl.agent.plan import Plan
from ptl.config import Parameters
from ptl.methods._base import BaseMethod
from ptl.world.gridworld import GridWorld


class Method(BaseMethod):
    """Epsilon-greedy Q-learning from the final Q of the previous task (stated by the article)."""

    label = "Full transfer"
    colour = "#d55e00"

    def __init__(self, world: GridWorld, parameters: Parameters, random: np.random.Generator) -> None:
        super().__init__(world, parameters, random)
        self._previous_q: np.ndarray | None = None

    def begin_task(self, start: int, goal: int) -> np.ndarray | None:
        return self._previous_q

    def plan(self) -> Plan:
        return Plan()

    def end_task(self, learner: Learner) -> None:
        self._previous_q = learner.q
