"""PTL with the metric that the article improves upon."""

from __future__ import annotations

from ptl.agent.finders import Finder
from ptl.methods.ptl import Method as PartialTransfer
from studies.beyond import finders


class Method(PartialTransfer):
    """As `ptl`, with the argmax of the original FD metric as the new subgoal (Kretchmar et al., 2003)."""

    label = "PTL, original FD metric"
    colour = "#b2abd2"

    def finder(self) -> Finder:
        return finders.original_fd
