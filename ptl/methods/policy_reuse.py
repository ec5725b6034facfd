"""Probabilistic policy reuse: PRQ-learning of Fernandez and Veloso over the policies of all earlier tasks."""

from __future__ import annotations

import numpy as np

from ptl.agent._kernel import Learner
from ptl.agent._selection import ArmSelection
from ptl.agent.plan import Guide, Mixing, Plan
from ptl.agent.policies import greedy_policy
from ptl.config import Parameters
from ptl.methods._base import BaseMethod
from ptl.world.gridworld import GridWorld


class Method(BaseMethod):
    """PRQ-learning (source: FV 2006, 2013). That all policies are kept is stated by the article.

    Arm 0 is the new policy, followed greedily; arm j > 0 reuses the policy of the j-th earlier task by pi-reuse. An arm
    is drawn with probability exp(tau W_k) / sum_j exp(tau W_j); W_k is the mean discounted return of its episodes
    (`ptl.agent._selection.ArmSelection`).
    """

    label = "Policy reuse"
    colour = "#009e73"

    def __init__(self, world: GridWorld, parameters: Parameters, random: np.random.Generator) -> None:
        super().__init__(world, parameters, random)
        self.past_policies: list[np.ndarray] = []

    def begin_task(self, start: int, goal: int) -> np.ndarray | None:
        reuse = self.parameters.policy_reuse
        self.guides = [None, *map(Guide, self.past_policies)]
        gamma = self.parameters.learning.gamma
        self.selection = ArmSelection(len(self.guides), gamma, reuse.temperature, reuse.temperature_step)
        return None

    def plan(self) -> Plan:
        reuse = self.parameters.policy_reuse
        return Plan(
            draw=self.draw_arm,
            guide=self.guides.__getitem__,
            mixing=Mixing(reuse.psi, reuse.psi_decay),
            epsilon=0.0,
            note=self.selection.record,
        )

    def draw_arm(self) -> int:
        """Draw the arm of the next episode."""
        return self.selection.draw(self.random)

    def end_task(self, learner: Learner) -> None:
        untaught = self.parameters.policy_reuse.untaught
        self.past_policies.append(greedy_policy(learner.q, everywhere=untaught == "first_action"))

    def arm_probabilities(self) -> np.ndarray:
        """Return the probability of each arm in the next episode, float (1 + earlier tasks,)."""
        return self.selection.probabilities()
