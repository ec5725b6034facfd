"""Partial transfer learning with a skill library: the article's method, goal known."""

from __future__ import annotations

import numpy as np

from ptl.agent import finders
from ptl.agent._selection import SkillSelection
from ptl.agent.plan import Leader, Mixing, Plan
from ptl.agent.policies import values_of
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
    skill, patience and repeated drawing are our choice. So is what a drawn skill does, ``skills.skill_use``:

    ``reselect``        leads from the start of the episode and after each further draw, as above;
    ``lead_in``         is drawn and leads once an episode;
    ``initiation_set``  as ``reselect``, and it leads again wherever exploring enters its initiation set and nothing is
                        known yet;
    ``mixing``          as ``reselect``, but its policy is mixed into the agent's own by pi-reuse;
    ``initial_values``  is drawn once a task, and Q starts from the values of its policy.

    Attributes
    ----------
    kept_skill : int or None
        Candidate of the whole task if it is drawn once a task.
    """

    label = "PTL"
    colour = "#0072b2"
    kept_skill: int | None = None

    def __init__(self, world: GridWorld, parameters: Parameters, random: np.random.Generator) -> None:
        super().__init__(world, parameters, random)
        subgoals = parameters.subgoals
        initiation_sets = parameters.skills.skill_use == "initiation_set"
        self.library: SkillLibrary = SkillLibrary(
            subgoals.novelty, subgoals.threshold, self.finder(), initiation_sets=initiation_sets
        )

    def finder(self) -> finders.Finder:
        """Return the function that says where a new skill ends."""
        return finders.incremental

    def begin_task(self, start: int, goal: int) -> np.ndarray | None:
        skills = self.parameters.skills
        self.candidates = [start, *self.library.subgoals]
        self.selection = SkillSelection(self.prior(goal), skills.likelihood_exponent, skills.likelihood_weight)
        self.kept_skill = None
        if skills.skill_use != "initial_values":
            return None
        self.kept_skill = self.draw_skill()
        leader, gamma = self.guide(self.kept_skill), self.parameters.learning.gamma
        return None if leader is None else values_of(leader.policy, leader.subgoal, self.world.successors, gamma)

    def plan(self) -> Plan:
        kept, skills, reuse = self.kept_skill, self.parameters.skills, self.parameters.policy_reuse
        if kept is not None:
            return Plan(draw=lambda: kept)
        return Plan(
            draw=self.draw_skill,
            guide=self.guide,
            mixing=Mixing(reuse.psi, reuse.psi_decay) if skills.skill_use == "mixing" else None,
            patience=None if skills.skill_use == "lead_in" else skills.patience * self.world.n_states,
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
