"""The skill to the frontier without a library: `ptl_frontier` without stored skills."""

from __future__ import annotations

import numpy as np

from ptl.config import Parameters
from ptl.world.gridworld import GridWorld
from studies.beyond.methods.ptl_frontier import Method as Frontier


class Method(Frontier):
    """As `ptl_frontier`, with the null skill and the frontier skill as the only candidates (control)."""

    label = "Frontier without library"
    colour = "#66bd63"

    def __init__(self, world: GridWorld, parameters: Parameters, random: np.random.Generator) -> None:
        super().__init__(world, parameters, random)
        # no part of a path is ever longer than the whole of what was seen, so no skill is added
        self.library.novelty = np.inf
