"""R-max for a deterministic world: a model of what was tried, and untried actions first (Brafman and Tennenholtz)."""

from __future__ import annotations

import numpy as np

from ptl.agent._kernel import Learner
from ptl.config import Parameters
from ptl.methods._base import BaseMethod
from ptl.world.gridworld import GridWorld
from studies.beyond.methods._model import Model


class Method(BaseMethod):
    """Goes to the goal if a path of tried actions leads there, else tries the nearest untried action.

    R. Brafman, M. Tennenholtz, JMLR 3, 2002, simplified for deterministic moves and one goal (our choice): once a path
    to the goal is known, it is taken, whether or not an untried action might shorten it. Every task begins with an
    empty model.
    """

    label = "R-max, model forgotten"
    colour = "#8c510a"

    def __init__(self, world: GridWorld, parameters: Parameters, random: np.random.Generator) -> None:
        super().__init__(world, parameters, random)
        self.model = Model(world.n_states)

    def begin_task(self, start: int, goal: int) -> np.ndarray | None:
        self.goal = goal
        self.goal_is_known = False
        self.model = Model(self.world.n_states)
        self._route: tuple[int, int, list[int]] = (-1, -1, [])
        return None

    def run_episode(self, learner: Learner) -> list[int]:
        while not (learner.at_goal or learner.truncated):
            for action in self._way(learner.state):
                state = learner.state
                after = learner.act(action)
                self.model.note(state, action, after)
                if learner.at_goal or learner.truncated:
                    break
        self.goal_is_known |= learner.at_goal
        return []

    def _way(self, state: int) -> list[int]:
        if self.goal_is_known:
            # most episodes repeat the last one's path
            known, origin, way = self._route
            if (known, origin) == (self.model.size, state):
                return way
            path = self.model.way_to(state, self.goal)
            if path is not None:
                self._route = (self.model.size, state, path)
                return path
        untried = self.model.way_to_untried(state, self.random)
        assert untried is not None  # the goal can be reached, so until it is, something is untried
        return untried
