"""Partial transfer learning with a skill library: the article's method, goal known."""

from __future__ import annotations

import numpy as np

from ptl.agent import finders
from ptl.agent._selection import SkillSelection
from ptl.agent.plan import Leader, Plan
from ptl.agent.selection import prior
from ptl.agent.skills import SkillLibrary
from ptl.config import Parameters
from ptl.methods._base import BaseMethod
from ptl.world.gridworld import GridWorld

NULL_SKILL = 0
"""Candidate without guidance, whose subgoal is the start state (our choice); library skill i is candidate i + 1."""


def allowed_candidates(number: int, null_skill: bool) -> np.ndarray:
    """Return which of ``number`` candidates may be drawn, bool (number,): all, or all but the null skill."""
    allowed = np.ones(number, dtype=bool)
    allowed[NULL_SKILL] = null_skill
    return allowed


class Method(BaseMethod):
    """Follows a drawn skill to its subgoal, then explores; draws again when patience runs out.

    That skills are drawn with probability proportional to P(C|s_i, g) P(s_i|g) is stated by the article; the null
    skill, patience and repeated drawing are our choice.
    """

    label = "PTL"
    colour = "#0072b2"

    def __init__(self, world: GridWorld, parameters: Parameters, random: np.random.Generator) -> None:
        super().__init__(world, parameters, random)
        subgoals = parameters.subgoals
        self.library: SkillLibrary = SkillLibrary(subgoals.novelty, subgoals.threshold, self.finder())

    def finder(self) -> finders.Finder:
        """Return the function that says where a new skill ends."""
        return finders.incremental

    def begin_task(self, start: int, goal: int) -> np.ndarray | None:
        skills = self.parameters.skills
        self.candidates = [start, *self.library.subgoals]
        self.selection = SkillSelection(self.prior(goal), skills.likelihood_exponent, skills.likelihood_weight)
        return None

    def plan(self) -> Plan:
        skills = self.parameters.skills
        reselect = skills.skill_use == "reselect"
        return Plan(
            draw=self.draw_skill,
            guide=self.guide,
            patience=skills.patience * self.world.n_states if reselect else None,
            growth=skills.patience_growth,
            note=self.selection.record,
        )

    def allowed(self, number: int) -> np.ndarray:
        """Return which candidates may be drawn, as `allowed_candidates`."""
        return allowed_candidates(number, self.parameters.skills.null_skill or not len(self.library))

    def prior(self, goal: int) -> np.ndarray:
        """Return P(s_i|g) of the null skill and the library's skills, float (1 + library size,), 0 if not allowed."""
        skills, world = self.parameters.skills, self.world
        allowed = self.allowed(len(self.candidates))
        return prior(world.cells, self.candidates, goal, world.diagonal, skills.prior_form, skills.prior_width, allowed)

    def guide(self, skill: int) -> Leader | None:
        """Return what leads when a candidate has been drawn, None for the null skill."""
        return None if skill == NULL_SKILL else self.library.skills[skill - 1]

    def draw_skill(self) -> int:
        """Draw the candidate to use next."""
        return self.selection.draw(self.random)
