"""Optimistic initial values with the learning rate of a deterministic world."""

from __future__ import annotations

import numpy as np

from ptl.config import Parameters
from ptl.world.gridworld import GridWorld
from studies.beyond.methods.optimistic import Method as Optimistic


class Method(Optimistic):
    """As `optimistic`, with alpha = 1: one try tells all where moves are deterministic (Koenig and Simmons, 1996)."""

    label = "Optimistic Q, α = 1"
    colour = "#01665e"

    def __init__(self, world: GridWorld, parameters: Parameters, random: np.random.Generator) -> None:
        super().__init__(world, parameters.replace(learning__alpha=1.0), random)
