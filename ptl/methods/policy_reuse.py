"""Probabilistic policy reuse: PRQ-learning of Fernandez and Veloso over the policies of all earlier tasks."""

from __future__ import annotations

import numpy as np

from ptl.agent._kernel import Learner
from ptl.agent._selection import draw_index
from ptl.agent.policies import greedy_policy
from ptl.config import Parameters
from ptl.methods._base import BaseMethod
from ptl.world.gridworld import GridWorld


class Method(BaseMethod):
    """PRQ-learning (source: FV 2006, 2013). That all policies are kept is stated by the article.

    Arm 0 is the new policy, followed greedily; arm j > 0 reuses the policy of the j-th earlier task by pi-reuse. An arm
    is drawn with probability exp(tau W_k) / sum_j exp(tau W_j); W_k is the mean discounted return of its episodes.
    """

    label = "Policy reuse"
    colour = "#009e73"

    def __init__(self, world: GridWorld, parameters: Parameters, random: np.random.Generator) -> None:
        super().__init__(world, parameters, random)
        self.past_policies: list[np.ndarray] = []

    def begin_task(self, start: int, goal: int) -> np.ndarray | None:
        arms = 1 + len(self.past_policies)
        self._gain = np.zeros(arms)
        self._uses = np.zeros(arms)
        self._temperature = self.parameters.policy_reuse.temperature
        return None

    def run_episode(self, learner: Learner) -> list[int]:
        reuse = self.parameters.policy_reuse
        arm = draw_index(self.arm_weights(), self.random)
        if arm == 0:
            learner.explore(epsilon=0.0)
        else:
            learner.reuse(self.past_policies[arm - 1], reuse.psi, reuse.psi_decay)
        # The only reward is 1 at the goal, so the discounted return of an episode of m steps is gamma**(m - 1).
        discounted = self.parameters.learning.gamma ** (learner.steps - 1) if learner.at_goal else 0.0
        self._gain[arm] = (self._gain[arm] * self._uses[arm] + discounted) / (self._uses[arm] + 1)
        self._uses[arm] += 1
        self._temperature += reuse.temperature_step
        return [arm]

    def end_task(self, learner: Learner) -> None:
        untaught = self.parameters.policy_reuse.untaught
        self.past_policies.append(greedy_policy(learner.q, everywhere=untaught == "first_action"))

    def arm_weights(self) -> np.ndarray:
        """Return a multiple of the probability of each arm in the next episode, float (1 + earlier tasks,)."""
        return np.exp(self._temperature * (self._gain - self._gain.max()))

    def arm_probabilities(self) -> np.ndarray:
        """Return the probability of each arm in the next episode, float (1 + earlier tasks,)."""
        weights = self.arm_weights()
        return weights / weights.sum()
