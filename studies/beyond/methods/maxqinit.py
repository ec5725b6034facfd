"""MaxQInit: the greatest values of earlier tasks, optimism elsewhere (Abel et al., 2018)."""

from __future__ import annotations

import numpy as np

from ptl.agent._kernel import Learner
from ptl.config import Parameters
from ptl.world.gridworld import GridWorld
from ptl.world.transitions import TransitionGraph
from studies.beyond.methods.optimistic_fast import Method as Optimistic


class Method(Optimistic):
    """As `optimistic_fast`, but a pair of state and action tried before starts from its greatest final value so far.

    D. Abel, Y. Jinnai, S. Guo, G. Konidaris, M. Littman, ICML 2018. Knows nothing of the goal. It learns with alpha = 1
    as its sibling does, so that the two differ in what they keep from task to task alone.
    """

    label = "MaxQInit"
    colour = "#80cdc1"

    def __init__(self, world: GridWorld, parameters: Parameters, random: np.random.Generator) -> None:
        super().__init__(world, parameters, random)
        self.greatest = np.full((world.n_states, 4), -np.inf)

    def begin_task(self, start: int, goal: int) -> np.ndarray | None:
        return np.where(np.isfinite(self.greatest), self.greatest, 1.0)

    def end_task(self, learner: Learner) -> None:
        tried = TransitionGraph(self.world.successors, learner.seen).known
        self.greatest = np.where(tried, np.maximum(self.greatest, learner.q), self.greatest)
