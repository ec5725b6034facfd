"""PTL with a skill to the frontier of what was seen: a proposal of ours."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from ptl.agent._kernel import Learner
from ptl.agent.plan import Guide, Leader
from ptl.agent.selection import prior, prior_of_distances
from ptl.config import Parameters
from ptl.methods.ptl import NULL_SKILL
from ptl.methods.ptl import Method as PartialTransfer
from ptl.world.gridworld import GridWorld
from ptl.world.transitions import N_ACTIONS
from studies.beyond.methods._transitions import UNSEEN, graph_of, updated


class Method(PartialTransfer):
    """As `ptl`, with one more candidate that leads to the promising edge of the seen part of the map (ours).

    The frontier state f is, among the states seen so far, in all tasks and in this one while it runs, that still have
    an untried action, the one nearest to the goal in a straight line (ties: fewest steps from the start, then lowest
    number); the goal itself once it has been seen. When drawn, a shortest path over seen transitions leads to f; prior
    and likelihood are those of `ptl`. The agent needs a memory of all transitions.

    Attributes
    ----------
    offers_frontier : bool
        Whether f is a candidate.
    path_prior : bool
        Whether the prior falls with the steps from a subgoal to f over seen transitions instead of with the straight
        distance to the goal: P(s|g) proportional to exp(-d(s, f) / (sigma L)), 0 where no seen path leads.
    """

    label = "PTL + frontier (ours)"
    colour = "#1a9850"
    offers_frontier: ClassVar[bool] = True
    path_prior: ClassVar[bool] = False

    def __init__(self, world: GridWorld, parameters: Parameters, random: np.random.Generator) -> None:
        super().__init__(world, parameters, random)
        self.after_before = np.full((world.n_states, N_ACTIONS), UNSEEN)
        self.frontier: int
        self._to_frontier: Guide | None = None

    def begin_task(self, start: int, goal: int) -> np.ndarray | None:
        self.start, self.goal = start, goal
        self._seen = np.zeros(self.world.n_states, dtype=np.uint8)
        self._look(self.after_before)
        return super().begin_task(start, goal)

    def run_episode(self, learner: Learner) -> list[int] | None:
        self._learner = learner
        return super().run_episode(learner)

    def draw_skill(self) -> int:
        seen = self._learner.seen
        if not np.array_equal(seen, self._seen):
            self._seen = seen
            self._look(updated(self.after_before, self._learner.transitions))
            self.selection.prior = self.prior(self.goal)
        return super().draw_skill()

    def guide(self, skill: int) -> Leader | None:
        if skill <= len(self.library):
            return super().guide(skill)
        if self._to_frontier is None:
            self._to_frontier = Guide(self.graph.shortest_path_policy(self.frontier), self.frontier)
        return self._to_frontier

    def end_task(self, learner: Learner) -> None:
        self.after_before = updated(self.after_before, learner.transitions)

    def prior(self, goal: int) -> np.ndarray:
        places = [self.start, *self.library.subgoals, *([self.frontier] if self.offers_frontier else [])]
        skills, world, allowed = self.parameters.skills, self.world, self.allowed(len(places))
        if not self.path_prior:
            return prior(world.cells, places, goal, world.diagonal, skills.prior_form, skills.prior_width, allowed)
        steps = self.graph.steps_to(self.frontier)[places]
        allowed &= steps >= 0
        # f is reached from the start over seen transitions, so at least the null skill is a candidate
        allowed[NULL_SKILL] |= not allowed.any()
        return prior_of_distances(steps, skills.prior_width * world.diagonal, allowed=allowed)

    def _look(self, after: np.ndarray) -> None:
        """Find the frontier state anew from the state after each action that was seen, int (n_states, 4)."""
        self._after, self._to_frontier = after, None
        self.graph = graph_of(after)
        self.frontier = self._frontier_state()

    def _frontier_state(self) -> int:
        steps = self.graph.steps_from([self.start])
        if steps[self.goal] >= 0:
            return self.goal
        open_ = np.flatnonzero((steps >= 0) & (self._after == UNSEEN).any(axis=1))
        away = ((self.world.cells[open_] - self.world.cells[self.goal]) ** 2).sum(axis=1)
        return int(open_[np.lexsort((open_, steps[open_], away))[0]])
