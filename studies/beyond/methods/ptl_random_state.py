"""PTL whose skills end anywhere: does it matter where?"""

from __future__ import annotations

from ptl.agent import finders
from ptl.methods.ptl import Method as PartialTransfer


class Method(PartialTransfer):
    """As `ptl`, with any visited state as the new subgoal, under the same conditions (control)."""

    label = "PTL, subgoal = random state"
    colour = "#d7301f"

    def finder(self) -> finders.Finder:
        return finders.random_state(self.random)
