"""Shortest paths over transitions: all of a map, or those that an agent has seen."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from ptl.world._graph import breadth_first, checked_states, compressed_rows, diameter, first_steps

N_ACTIONS = 4


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
            self.known = np.unpackbits(seen[:, None], axis=1, count=N_ACTIONS, bitorder="little").view(bool)

    @property
    def visited(self) -> np.ndarray:
        """States at either end of a transition, in increasing order."""
        states, actions = np.nonzero(self.known)
        return np.union1d(states, self.successors[states, actions])

    @cached_property
    def _forward(self) -> tuple[np.ndarray, np.ndarray]:
        return self._rows(forward=True)

    @cached_property
    def _backward(self) -> tuple[np.ndarray, np.ndarray]:
        return self._rows(backward=True)

    def _rows(self, forward: bool = False, backward: bool = False) -> tuple[np.ndarray, np.ndarray]:
        return compressed_rows(self.successors, self.known.view(np.uint8), forward, backward)

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
        return first_steps(self.successors, self.known.view(np.uint8), self.steps_to(target))

    def diameter(self) -> int:
        """Return the longest shortest path in steps between connected states, transitions taken in both directions."""
        return diameter(self.successors, self.known.view(np.uint8))
