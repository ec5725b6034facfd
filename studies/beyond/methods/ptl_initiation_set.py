"""PTL under one reading of what a drawn skill does: ``skills.skill_use: initiation_set``."""

from __future__ import annotations

import numpy as np

from ptl.config import Parameters
from ptl.methods.ptl import Method as PartialTransfer
from ptl.world.gridworld import GridWorld


class Method(PartialTransfer):
    """As `ptl`, where a drawn skill leads again wherever exploring enters its initiation set (our choice).

    It does so where nothing is known yet, and otherwise leads as in `ptl_reselect`.

    Knows the goal's coordinates, as `ptl`. The reading is named here, whatever the configuration says.
    """

    label = "PTL, initiation set"
    colour = "#08519c"

    def __init__(self, world: GridWorld, parameters: Parameters, random: np.random.Generator) -> None:
        super().__init__(world, parameters.replace(skills__skill_use="initiation_set"), random)
