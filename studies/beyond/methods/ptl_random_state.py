"""PTL whose skills end at random states: does the subgoal matter?"""

from __future__ import annotations

from ptl.agent.finders import Finder
from ptl.methods.ptl import Method as PartialTransfer
from studies.beyond import finders


class Method(PartialTransfer):
    """As `ptl`, with any visited state as the new subgoal, under the same conditions (control)."""

    label = "PTL, subgoal = random state"
    colour = "#d7301f"

    def finder(self) -> Finder:
        return finders.random_state(self.random)
