"""A memory of transitions over tasks: the state after a step in each direction, of which the newest counts."""

from __future__ import annotations

import numpy as np

from ptl.world.transitions import TransitionGraph

UNSEEN = -1


def updated(before: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """Return a memory after a task; both are int arrays (n_states, 4), `UNSEEN` where no step was seen."""
    return np.where(seen == UNSEEN, before, seen)


def graph_of(after: np.ndarray) -> TransitionGraph:
    """Return the transitions in a memory as a graph."""
    known = after != UNSEEN
    successors = np.where(known, after, np.arange(len(after))[:, np.newaxis])
    return TransitionGraph(successors, np.packbits(known, axis=1, bitorder="little")[:, 0])
