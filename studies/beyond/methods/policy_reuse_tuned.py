"""Policy reuse with the settings that do best on the tuning band."""

from __future__ import annotations

import numpy as np

from ptl.config import Parameters
from ptl.methods.policy_reuse import Method as PolicyReuse
from ptl.world.gridworld import GridWorld

TUNED = {"policy_reuse__psi_decay": 0.98, "policy_reuse__temperature_step": 50000.0}
"""The chosen row of config/tuned.csv, which `make tune-beyond` makes."""


class Method(PolicyReuse):
    """As `policy_reuse`, but guidance lasts longer, and from the second episode on the arm that gains most is drawn.

    Returns are gamma to the length of an episode, so that with the temperature of the source all arms are drawn almost
    equally often on maps of this size. Knows nothing of the goal.
    """

    label = "Policy reuse, tuned"
    colour = "#b2df8a"

    def __init__(self, world: GridWorld, parameters: Parameters, random: np.random.Generator) -> None:
        super().__init__(world, parameters.replace(**TUNED), random)
