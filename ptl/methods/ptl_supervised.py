"""Partial transfer learning with a supervisor who knows the map and names the skill."""

from __future__ import annotations

import numpy as np

from ptl.methods.ptl import Method as PartialTransfer


class Method(PartialTransfer):
    """As `ptl`, but always the skill whose subgoal is nearest to the goal by shortest path (our choice).

    The start itself counts as a candidate: where it is nearest the supervisor names the null skill.
    """

    label = "PTL, supervised"
    colour = "#56b4e9"

    def begin_task(self, start: int, goal: int) -> np.ndarray | None:
        distance = self.world.distances_to(goal)[[start, *self.library.subgoals]]
        self.named_skill = int(np.where(distance < 0, distance.max() + 1, distance).argmin())
        return super().begin_task(start, goal)

    def draw_skill(self) -> int:
        return self.named_skill
