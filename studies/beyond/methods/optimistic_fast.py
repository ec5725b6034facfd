"""Optimistic initial values with the learning rate that does best on the tuning band."""

from __future__ import annotations

import numpy as np

from ptl.config import Parameters
from ptl.world.gridworld import GridWorld
from studies.beyond.methods._tuned import OPTIMISTIC, tuned_at
from studies.beyond.methods.optimistic import Method as Optimistic


class Method(Optimistic):
    """As `optimistic`, with alpha = 1: one try tells all where moves are deterministic (Koenig and Simmons, 1996).

    Where steps slip, alpha is the one chosen at that slip, or at the nearest slip that was tuned.
    """

    label = "Optimistic Q, α tuned"
    colour = "#01665e"

    def __init__(self, world: GridWorld, parameters: Parameters, random: np.random.Generator) -> None:
        super().__init__(world, parameters.replace(**tuned_at(OPTIMISTIC, world.slip)), random)
