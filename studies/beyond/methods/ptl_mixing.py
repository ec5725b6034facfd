"""PTL under one reading of what a drawn skill does: ``skills.skill_use: mixing``."""

from __future__ import annotations

import numpy as np

from ptl.config import Parameters
from ptl.methods.ptl import Method as PartialTransfer
from ptl.world.gridworld import GridWorld


class Method(PartialTransfer):
    """As `ptl`, where a drawn skill is mixed into the agent's own policy by pi-reuse (our choice).

    Knows the goal's coordinates, as `ptl`. The reading is named here, whatever the configuration says.
    """

    label = "PTL, mixed policy"
    colour = "#6baed6"

    def __init__(self, world: GridWorld, parameters: Parameters, random: np.random.Generator) -> None:
        super().__init__(world, parameters.replace(skills__skill_use="mixing"), random)
