"""Loops that Numba compiles when they are first called: Q-learning as its users write it, and two bare limits."""

from __future__ import annotations

from collections.abc import Callable

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


@numba.njit
def walk(table: np.ndarray, bits: int, start: int, goal: int, words: np.ndarray, episodes: int) -> int:
    """Walk at random from ``start`` to ``goal``, some times; return the number of look-ups.

    Nothing but what each look-up needs to know from the one before: an index and ``bits`` random bits.

    Parameters
    ----------
    table : uint32 array, shape (n_states * 2**bits,)
        Index of the first of the next state's entries; ``start`` and ``goal`` are such indices too.
    words : uint64 array, shape (k,)
        Random words, so that drawing them costs nothing. They are used over and over, each time under another mask: the
        very same words again could lead round in a circle for ever.
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


@numba.njit
def draw(next_word: Callable[[int], int], state: int, number: int) -> np.uint64:
    """Call a bit generator's C function a number of times, as the kernel does; return the words' exclusive or."""
    mixed = np.uint64(0)
    for _ in range(number):
        mixed ^= next_word(state)
    return mixed
