"""PTL whose skills end far from each other."""

from __future__ import annotations

from ptl.agent.finders import Finder
from ptl.methods.ptl import Method as PartialTransfer
from studies.beyond import finders


class Method(PartialTransfer):
    """As `ptl`, with the visited state farthest from start and stored subgoals (Gonzalez, 1985: k-centre)."""

    label = "PTL, subgoal = farthest state"
    colour = "#7b3294"

    def finder(self) -> Finder:
        return finders.farthest
