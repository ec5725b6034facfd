"""Partial transfer learning when the place of the goal is not known before it is found."""

from __future__ import annotations

import numpy as np

from ptl.methods.ptl import Method as PartialTransfer


class Method(PartialTransfer):
    """As `ptl`, with a uniform prior over the skills (our choice)."""

    label = "PTL, goal unknown"
    colour = "#cc79a7"

    def prior(self, goal: int) -> np.ndarray:
        allowed = self.allowed(len(self.candidates))
        return allowed / allowed.sum()
