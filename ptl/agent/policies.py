"""Stored policies, from action values."""

from __future__ import annotations

import numpy as np


def greedy_policy(q: np.ndarray, everywhere: bool = False) -> np.ndarray:
    """Return the greedy action of each state, int8 (n_states,), -1 where the values say nothing.

    Ties go to the first action in the order north, south, west, east. A state whose four values are equal was never
    informed, so the policy is undefined there unless it is wanted ``everywhere`` (our choice).

    Parameters
    ----------
    q : float array, shape (n_states, 4)
    """
    informed = (q != q[:, :1]).any(axis=1)
    return np.where(informed | everywhere, q.argmax(axis=1), -1).astype(np.int8)
