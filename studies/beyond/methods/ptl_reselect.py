"""PTL under one reading of what a drawn skill does: ``skills.skill_use: reselect``."""

from __future__ import annotations

import numpy as np

from ptl.config import Parameters
from ptl.methods.ptl import Method as PartialTransfer
from ptl.world.gridworld import GridWorld


class Method(PartialTransfer):
    """As `ptl`, where a drawn skill leads from the start of an episode and after each further draw (our choice).

    Knows the goal's coordinates, as `ptl`. The reading is named here, whatever the configuration says.
    """

    label = "PTL, drawn again"
    colour = "#4292c6"

    def __init__(self, world: GridWorld, parameters: Parameters, random: np.random.Generator) -> None:
        super().__init__(world, parameters.replace(skills__skill_use="reselect"), random)
