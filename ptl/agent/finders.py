"""Subgoal finders: each scores the states of a map after a task, and the library takes the best one.

A finder is a function of the task's `Discovery`, the graph of the transitions seen in the task and the subgoals that
are stored already. It returns a score for every state, float array (n_states,); a state with a score of 0 is no
candidate. `incremental` is the article's.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeAlias

import numpy as np

from ptl.agent.subgoals import Discovery
from ptl.world.transitions import TransitionGraph

Finder: TypeAlias = Callable[[Discovery, TransitionGraph, Sequence[int]], np.ndarray]


def incremental(discovery: Discovery, graph: TransitionGraph, stored: Sequence[int]) -> np.ndarray:
    """Score by the incremental FD metric (stated by the article in words; its form is our choice)."""
    return discovery.incremental.product
