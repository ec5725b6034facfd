"""Policy reuse with the settings that do best on the tuning band."""

from __future__ import annotations

import numpy as np

from ptl.config import Parameters
from ptl.methods.policy_reuse import Method as PolicyReuse
from ptl.world.gridworld import GridWorld
from studies.beyond.methods._tuned import POLICY_REUSE, tuned_at


class Method(PolicyReuse):
    """As `policy_reuse`, but guidance lasts longer, and from the second episode on the arm that gains most is drawn.

    Returns are gamma to the length of an episode, so that with the temperature of the source all arms are drawn almost
    equally often on maps of this size. The settings are those chosen at the slip of the world, or at the nearest slip
    that was tuned. Knows nothing of the goal.
    """

    label = "Policy reuse, tuned"
    colour = "#b2df8a"

    def __init__(self, world: GridWorld, parameters: Parameters, random: np.random.Generator) -> None:
        super().__init__(world, parameters.replace(**tuned_at(POLICY_REUSE, world.slip)), random)
