"""What all contestants of the benchmark learn."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Task:
    """A task and the parameters of Q-learning, the same for all contestants.

    Attributes
    ----------
    successors : int array, shape (n_states, 4)
    start, goal : int
    alpha, gamma, epsilon : float
    """

    successors: np.ndarray
    start: int
    goal: int
    alpha: float = 0.05
    gamma: float = 0.95
    epsilon: float = 0.1
