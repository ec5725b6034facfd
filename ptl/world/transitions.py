"""Shortest paths over transitions: all of a map, or those that an agent has seen."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from ptl.world._graph import breadth_first

N_ACTIONS = 4


def checked_states(states: ArrayLike | Sequence[int], n_states: int) -> np.ndarray:
    """Return states as an int32 array, or raise ValueError if one is not a whole number from 0 to n_states - 1."""
    given = np.asarray(states)
    if given.size and (given.dtype.kind not in "iu" or given.min() < 0 or given.max() >= n_states):
        raise ValueError(f"a state must be a whole number from 0 to {n_states - 1}, not {states!r}")
    return given.astype(np.int32)


class TransitionGraph:
    """The graph whose edges are the transitions (s, a, s') of a deterministic world.

    Parameters
    ----------
    successors : int array, shape (n_states, 4)
    seen : uint8 array, shape (n_states,), optional
        Bit a is set if action a was taken in the state; all transitions if not given.

    Raises
    ------
    ValueError
        If a successor, or a state given to a call, is not a state, or the shapes differ.
    """

    def __init__(self, successors: np.ndarray, seen: np.ndarray | None = None) -> None:
        self.n_states = len(successors)
        self.successors = checked_states(successors, self.n_states)
        if self.successors.shape != (self.n_states, N_ACTIONS) or (seen is not None and len(seen) != self.n_states):
            raise ValueError(f"successors must have the shape (n_states, {N_ACTIONS}), and seen one entry a state")
        if seen is None:
            self.known = np.ones(self.successors.shape, dtype=bool)
        else:
            self.known = (seen[:, None] >> np.arange(N_ACTIONS) & 1).astype(bool)
        states, actions = np.nonzero(self.known)
        self._origin = states.astype(np.int32)
        self._target = self.successors[states, actions]

    @property
    def visited(self) -> np.ndarray:
        """States at either end of a transition, in increasing order."""
        return np.union1d(self._origin, self._target)

    @cached_property
    def _forward(self) -> tuple[np.ndarray, np.ndarray]:
        return _compressed_rows(self._origin, self._target, self.n_states)

    @cached_property
    def _backward(self) -> tuple[np.ndarray, np.ndarray]:
        return _compressed_rows(self._target, self._origin, self.n_states)

    @cached_property
    def _both_ways(self) -> tuple[np.ndarray, np.ndarray]:
        ends = np.concatenate([self._origin, self._target])
        return _compressed_rows(ends, np.concatenate([self._target, self._origin]), self.n_states)

    def steps_from(self, sources: ArrayLike | Sequence[int]) -> np.ndarray:
        """Return the steps from the nearest of some states to every state, int32 (n_states,), -1 if no path leads."""
        return breadth_first(*self._forward, checked_states(sources, self.n_states).reshape(-1))

    def steps_to(self, target: int) -> np.ndarray:
        """Return the steps from every state to ``target``, int32 (n_states,), -1 if there is no path."""
        return breadth_first(*self._backward, checked_states([target], self.n_states))

    def shortest_path_policy(self, target: int) -> np.ndarray:
        """Return the first action of a shortest path to ``target``, int8 (n_states,), -1 at the target or if none.

        Among several the first in the order north, south, west, east.
        """
        steps = self.steps_to(target)
        closer = self.known & (steps[self.successors] == steps[:, None] - 1) & (steps[:, None] > 0)
        return np.where(closer.any(axis=1), closer.argmax(axis=1), -1).astype(np.int8)

    def diameter(self) -> int:
        """Return the longest shortest path in steps between connected states, transitions taken in both directions.

        Exact, by bounding the eccentricities from few searches (Takes and Kosters, 2011) instead of one from each
        state: d(v, w) <= ecc(w) <= ecc(v) + d(v, w) and ecc(w) >= ecc(v) - d(v, w).
        """
        connected = np.zeros(self.n_states, dtype=bool)
        connected[self._origin] = connected[self._target] = True
        longest = 0
        while connected.any():
            component = breadth_first(*self._both_ways, np.flatnonzero(connected)[:1].astype(np.int32)) >= 0
            longest = max(longest, self._component_diameter(np.flatnonzero(component)))
            connected &= ~component
        return longest

    def _component_diameter(self, states: np.ndarray) -> int:
        lower = np.zeros(len(states), dtype=np.int64)
        upper = np.full(len(states), np.iinfo(np.int64).max)
        open_ = np.ones(len(states), dtype=bool)
        take_highest = True
        while open_.any():
            # In turn a state that may be far out (raises the lower bound) and one that is central (lowers the upper).
            candidates = np.flatnonzero(open_)
            pick = candidates[upper[candidates].argmax() if take_highest else lower[candidates].argmin()]
            take_highest = not take_highest
            steps = breadth_first(*self._both_ways, states[[pick]].astype(np.int32))[states]
            eccentricity = steps.max()
            lower = np.maximum(lower, np.maximum(steps, eccentricity - steps))
            upper = np.minimum(upper, eccentricity + steps)
            upper[pick] = eccentricity
            open_ &= (upper > lower.max()) & (lower < upper)
        return int(lower.max())


def _compressed_rows(origin: np.ndarray, target: np.ndarray, n: int) -> tuple[np.ndarray, np.ndarray]:
    first = np.zeros(n + 1, dtype=np.int32)
    np.cumsum(np.bincount(origin, minlength=n), out=first[1:])
    return first, target[np.argsort(origin, kind="stable")]
