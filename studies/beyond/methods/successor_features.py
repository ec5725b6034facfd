"""Successor features and generalised policy improvement (Barreto et al., 2017), in tables."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array, eye_array
from scipy.sparse.linalg import spsolve

from ptl.agent._kernel import Learner
from ptl.agent.policies import greedy_policy
from ptl.config import Parameters
from ptl.methods._base import BaseMethod
from ptl.world.gridworld import GridWorld


def discounted_visits(policy: np.ndarray, after: np.ndarray, goal: int, gamma: float) -> np.ndarray:
    """Return one column of a policy's successor features, float (n_states,).

    The features of a state are its indicator, so that the successor features are (I - gamma P)^-1 for the matrix P of
    the policy's transitions. Its column for a goal has the discounted visits of the goal from every state.

    Parameters
    ----------
    policy : int array, shape (n_states,)
        Action of each state, -1 where it ends.
    after : int array, shape (n_states, 4)
        State after each action.
    goal : int
    gamma : float
    """
    n_states = len(policy)
    led = np.flatnonzero(policy >= 0)
    places = (led, after[led, policy[led]])
    transitions = csr_array((np.full(len(led), gamma), places), shape=(n_states, n_states))
    indicator = np.zeros(n_states)
    indicator[goal] = 1.0
    return spsolve((eye_array(n_states) - transitions).tocsc(), indicator)


class Method(BaseMethod):
    """Acts greedily on the greatest of the values that its policy and those of all earlier tasks have for the goal.

    A. Barreto et al., Successor features for transfer in reinforcement learning, NeurIPS 2017. A state's features are
    its indicator and the weights of a task are 1 at the goal, so that the value of a past policy is its discounted
    visits of the goal. Two simplifications make it cheaper and can only help it (our choice): the successor features of
    a past policy are exact, from the last outcome of each of its actions, not estimated by temporal differences; and of
    those of the present policy the column of the goal alone is learned, which is Q-learning. Exploration is
    epsilon-greedy.

    Knows the state of the goal, and keeps policies and what their actions led to.
    """

    label = "Successor features, GPI"
    colour = "#999999"

    def __init__(self, world: GridWorld, parameters: Parameters, random: np.random.Generator) -> None:
        super().__init__(world, parameters, random)
        self.policies: list[np.ndarray] = []
        self.seen = np.zeros(world.n_states, dtype=np.uint8)

    def begin_task(self, start: int, goal: int) -> np.ndarray | None:
        self.goal = goal
        gamma, after = self.parameters.learning.gamma, self.world.successors
        columns = [discounted_visits(policy, after, goal, gamma) for policy in self.policies]
        visits = np.max(columns, axis=0, initial=0.0) if columns else np.zeros(self.world.n_states)
        seen = (self.seen[:, None] >> np.arange(4) & 1).astype(bool)
        # an action is worth the visits from the state that it leads to: 1 for a step into the goal
        self.past = np.where(seen, visits[after], 0.0)
        return None

    def run_episode(self, learner: Learner) -> list[int]:
        if not self.past.any():
            learner.explore()
            return []
        epsilon, past = self.parameters.learning.epsilon, self.past.tolist()
        worth: list[bool] = np.any(self.past, axis=1).tolist()
        while not (learner.at_goal or learner.truncated):
            state = learner.state
            if not worth[state]:
                learner.explore(budget=1)
                continue
            values = [max(pair) for pair in zip(learner.values_of(state), past[state], strict=True)]
            best = max(values) if self.random.random() >= epsilon else -np.inf
            among = [action for action, value in enumerate(values) if value >= best]
            learner.act(among[int(self.random.random() * len(among))])
        return []

    def end_task(self, learner: Learner) -> None:
        self.seen |= learner.seen
        policy = greedy_policy(learner.q)
        policy[self.goal] = -1
        self.policies.append(policy)
