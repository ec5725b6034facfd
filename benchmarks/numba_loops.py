"""Loops that Numba compiles when they are first called: Q-learning as its users write it, and a bare walk."""

from __future__ import annotations

import numba
import numpy as np

from benchmarks.learners import Problem


class NumbaLoop:
    """One loop over arrays."""

    def __init__(self, task: Problem, seed: int) -> None:
        self.q = np.zeros(task.successors.shape)
        generator = np.random.default_rng(seed)
        parameters = (task.alpha, task.gamma, task.epsilon)
        self._arguments = (task.successors, self.q, task.start, task.goal, *parameters, generator)
        self.run(0)  # compiles the loop

    def run(self, episodes: int) -> int:
        """Learn; return the number of steps."""
        return _learn(*self._arguments, episodes)


class BareWalk:
    """A random walk to the goal that learns and records nothing, with random bits drawn beforehand.

    Each look-up waits for the one before it, so this bounds the speed of a learner that takes one step after another.
    With ``stride`` 2 a look-up gives the state two steps on; the step that would leave the goal counts as well.
    """

    def __init__(self, task: Problem, seed: int, stride: int = 1) -> None:
        table = task.successors.copy()
        table[task.goal] = task.goal
        if stride == 2:
            table = table[table].reshape(len(table), 16)
        self._stride, bits = stride, 2 * stride
        places = (task.start << bits, task.goal << bits)
        words = np.random.SFC64(seed).random_raw(2**12)
        self._arguments = ((table << bits).astype(np.uint32).ravel(), bits, *places, words)
        self.run(0)  # compiles the loop

    def run(self, episodes: int) -> int:
        """Walk; return the number of steps."""
        return self._stride * _walk(*self._arguments, episodes)


@numba.njit
def _learn(
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
    """Learn some episodes in place in ``q``; return the number of steps."""
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


@numba.njit
def _walk(table: np.ndarray, bits: int, start: int, goal: int, words: np.ndarray, episodes: int) -> int:
    """Walk from ``start`` to ``goal`` some times; return the number of look-ups.

    Parameters
    ----------
    table : uint32 array, shape (n_states * 2**bits,)
        Index of the first of the next state's entries; ``start`` and ``goal`` are such indices too.
    words : uint64 array, shape (k,)
        Random words. They are reused, each time under another mask, because the same words could lead to an endless
        cycle.
    """
    lookups, place, left = 0, 0, 0
    word, shift, mask = np.uint64(0), np.uint64(bits), np.uint64((1 << bits) - 1)
    changed = np.uint64(0)
    for _ in range(episodes):
        index = np.uint64(start)
        while index != goal:
            if left == 0:
                word = words[place] ^ changed
                place += 1
                if place == len(words):
                    place = 0
                    changed = changed * np.uint64(6364136223846793005) + np.uint64(1442695040888963407)
                left = 64 // bits
            index = np.uint64(table[index + (word & mask)])
            word >>= shift
            left -= 1
            lookups += 1
    return lookups
