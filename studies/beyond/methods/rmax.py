"""R-max: a model of what was tried, and what is not known yet first (Brafman and Tennenholtz, 2002)."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from ptl.agent._kernel import Learner
from ptl.config import Parameters
from ptl.methods._base import BaseMethod
from ptl.world.gridworld import GridWorld
from studies.beyond.methods._model import Model


class Method(BaseMethod):
    """Goes to the goal if a path of known actions leads there, else tries the nearest action that is not known.

    R. Brafman, M. Tennenholtz, JMLR 3, 2002. An action of a state is known after m tries, and its counts go on. Plans
    to the goal are by value iteration over the known actions with the shares of what they led to. Three rules are ours:
    once a path of known actions leads to the goal, it is taken, whether or not something unknown might shorten it; the
    way to the nearest unknown action, and to the goal for the rest of an episode in which a path has changed, takes the
    most frequent outcome of each action for certain; and if by what is believed neither the goal nor anything unknown
    can be reached, all actions that left the agent where it was are tried once more, and if that does not help, m
    doubles. Every task begins with an empty model.

    Knows nothing of the goal before it has been there. Certain moves are not assumed; with m = 1 one try is believed.

    Attributes
    ----------
    visits : int
        m.
    """

    label = "R-max, model forgotten"
    colour = "#8c510a"
    visits: ClassVar[int] = 1
    forgets: ClassVar[bool] = False

    def __init__(self, world: GridWorld, parameters: Parameters, random: np.random.Generator) -> None:
        super().__init__(world, parameters, random)
        self.model = self.new_model()

    def new_model(self) -> Model:
        """Return a model in which nothing is known."""
        return Model(self.world.n_states, self.visits, self.forgets)

    def begin_task(self, start: int, goal: int) -> np.ndarray | None:
        self.goal = goal
        self.goal_is_known = False
        self.model = self.new_model()
        self._planned, self._rough = -1, False
        self.policy = [-1] * self.world.n_states
        return None

    def run_episode(self, learner: Learner) -> list[int]:
        if self.goal_is_known and (self._rough or self._planned != self.model.changes):
            self._plan(rough=False)
        state = learner.state
        while not (state == self.goal or learner.truncated):
            action = self.policy[state]
            state = self._act(learner, state, action) if action >= 0 else self._explore(learner, state)
        self.goal_is_known |= learner.at_goal
        return []

    def way(self, state: int) -> list[int]:
        """Return the actions that lead to something unknown, the last of them unknown."""
        while (way := self.model.way_to_unknown(state, self.random)) is None:
            self.model.doubt()
        return way

    def _explore(self, learner: Learner, state: int) -> int:
        for action in self.way(state):
            expected = self.model.pairs[state][action].usual
            state = self._act(learner, state, action)
            if state == self.goal or learner.truncated or state != expected or self.policy[state] >= 0:
                break
        return state

    def _act(self, learner: Learner, state: int, action: int) -> int:
        model = self.model
        edges, after = model.edges, learner.act(action)
        model.note(state, action, after)
        if self.goal_is_known and self._planned != model.changes:
            self._plan(rough=edges != model.edges)
        return after

    def _plan(self, rough: bool) -> None:
        if rough:
            policy = self.model.route_to(self.goal)
        else:
            policy = self.model.policy_to(self.goal, self.parameters.learning.gamma)
        self.policy, self._planned, self._rough = policy.tolist(), self.model.changes, rough
