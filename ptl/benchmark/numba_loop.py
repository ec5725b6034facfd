"""Tabular Q-learning as users of Numba write it: one plain loop over arrays, compiled when first called."""

from __future__ import annotations

import numba
import numpy as np


@numba.njit
def learn(
    successors: np.ndarray,
    q: np.ndarray,
    start: int,
    goal: int,
    alpha: float,
    gamma: float,
    epsilon: float,
    generator: np.random.Generator,
    episodes: int,
) -> int:
    """Learn some episodes in place in ``q``, ties broken uniformly; return the number of steps taken."""
    steps = 0
    for _ in range(episodes):
        state = start
        while state != goal:
            if generator.random() < epsilon:
                action = int(4 * generator.random())
            else:
                best = max(q[state, 0], q[state, 1], q[state, 2], q[state, 3])
                tied = 0
                for candidate in range(4):
                    tied += q[state, candidate] == best
                chosen = int(tied * generator.random()) if tied > 1 else 0
                action = 0
                for candidate in range(4):
                    if q[state, candidate] == best:
                        if chosen == 0:
                            action = candidate
                            break
                        chosen -= 1
            after = successors[state, action]
            target = 1.0 if after == goal else gamma * max(q[after, 0], q[after, 1], q[after, 2], q[after, 3])
            q[state, action] += alpha * (target - q[state, action])
            state = after
            steps += 1
    return steps
