"""The task that all contestants of the benchmark learn."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ptl.world.gridworld import GridWorld


@dataclass(frozen=True)
class Task:
    """A task and the parameters of Q-learning, the same for all contestants.

    Attributes
    ----------
    world : GridWorld
    letter : str
        Letter of the goal.
    alpha, gamma, epsilon : float
    """

    world: GridWorld
    letter: str
    alpha: float = 0.05
    gamma: float = 0.95
    epsilon: float = 0.1

    @property
    def successors(self) -> np.ndarray:
        """Next states, int array (n_states, 4)."""
        return self.world.successors

    @property
    def start(self) -> int:
        """State on which every episode starts."""
        return self.world.start

    @property
    def goal(self) -> int:
        """State that ends an episode."""
        return self.world.goal(self.letter)

    def initial_q(self, known: np.ndarray | None) -> np.ndarray:
        """Return a copy of the known action values, or zeros; float array (n_states, 4)."""
        return np.zeros(self.successors.shape) if known is None else known.copy()
