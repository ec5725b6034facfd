"""PTL with covering options for skills."""

from __future__ import annotations

from ptl.agent.finders import Finder
from ptl.methods.ptl import Method as PartialTransfer
from studies.beyond import finders


class Method(PartialTransfer):
    """As `ptl`, with the end of the Fiedler vector as the new subgoal (Jinnai et al., 2019, arXiv:1903.00606)."""

    label = "PTL, subgoal = Fiedler end"
    colour = "#c51b7d"

    def finder(self) -> Finder:
        return finders.covering
