"""PTL whose skills end at the goals of the tasks: no discovery at all."""

from __future__ import annotations

from ptl.agent.finders import Finder
from ptl.methods.ptl import Method as PartialTransfer
from studies.beyond import finders


class Method(PartialTransfer):
    """As `ptl`, with the task's goal as the new subgoal (control)."""

    label = "PTL, subgoal = goal"
    colour = "#e08214"

    def finder(self) -> Finder:
        return finders.task_goal
