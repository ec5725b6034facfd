"""Full transfer: Q-learning from the final Q of earlier tasks."""

from __future__ import annotations

import numpy as np

from ptl.agent._kernel import Learner
from ptl.agent.plan import Plan
from ptl.agent.policies import greedy_policy
from ptl.config import Parameters
from ptl.methods._base import BaseMethod
from ptl.world.gridworld import GridWorld

LEAST = 1e-100
"""Minimum value of a handed-over action."""


class Method(BaseMethod):
    """Epsilon-greedy Q-learning from what was learned before, ``full_transfer.hands_over``.

    ``latest``  the final Q of the previous task (stated by the article; so Barrett, Taylor and Stone, 2010);
    ``mean``    the mean of the final Q of all earlier tasks (our choice);
    ``policy``  of the final Q of the previous task its greedy actions alone, with equal values (our choice).
    """

    label = "Full transfer"
    colour = "#d55e00"

    def __init__(self, world: GridWorld, parameters: Parameters, random: np.random.Generator) -> None:
        super().__init__(world, parameters, random)
        self._handed_over: np.ndarray | None = None
        self._tasks = 0

    def begin_task(self, start: int, goal: int) -> np.ndarray | None:
        return self._handed_over

    def plan(self) -> Plan:
        return Plan()

    def end_task(self, learner: Learner) -> None:
        q, before = learner.q, self._handed_over
        self._tasks += 1
        match self.parameters.full_transfer.hands_over:
            case "latest":
                self._handed_over = q
            case "mean":
                self._handed_over = q if before is None else before + (q - before) / self._tasks
            case "policy":
                self._handed_over = self.faint_values(greedy_policy(q))

    def faint_values(self, policy: np.ndarray) -> np.ndarray:
        """Return equal values for a policy's actions, those of a goal as many steps away as there are states."""
        states = np.flatnonzero(policy >= 0)
        q = np.zeros((len(policy), 4))
        # updates only make them smaller before the goal is found, so they start far above the least double
        q[states, policy[states]] = max(self.parameters.learning.gamma ** len(policy), LEAST)
        return q
