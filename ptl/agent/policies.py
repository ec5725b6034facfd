"""Stored policies, from action values and as action values."""

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


def values_of(policy: np.ndarray, subgoal: int | None, successors: np.ndarray, gamma: float) -> np.ndarray:
    """Return the values of a policy as if its subgoal were the goal, float (n_states, 4).

    The policy's action has gamma**(k - 1) in a state from which it takes k steps to the subgoal; all else is 0.

    Parameters
    ----------
    policy : int8 array, shape (n_states,)
        Action of each state, -1 where undefined.
    subgoal : int or None
        A policy without one has no values.
    successors : int array, shape (n_states, 4)
    gamma : float
    """
    q = np.zeros(successors.shape)
    after = np.where(policy >= 0, successors[np.arange(len(policy)), policy], -1)
    after[subgoal if subgoal is not None else slice(None)] = -1
    arriving, value = np.flatnonzero(after == subgoal), 1.0
    while len(arriving):
        q[arriving, policy[arriving]] = value
        arriving, value = np.flatnonzero(np.isin(after, arriving)), gamma * value
    return q
