"""The survey of figure 8 by two methods of the same law: every step simulated, and with trees (docs/performance.md)."""

from __future__ import annotations

import time
from collections.abc import Iterable

import numpy as np

from ptl.agent._kernel import Dynamics
from ptl.config import Learning
from ptl.learning._survey import Survey, subgoals_from
from ptl.world.gridworld import GridWorld

EVERY_STEP, TREES = "survey, every step simulated", "survey, with trees"
METHODS = (EVERY_STEP, TREES)

NO_LIMIT = 10**12
"""Steps of an episode at most: the two methods count different steps, so a limit must never be met."""

GOALS = 5
"""Goals of a sampled start, enough to hide what a start itself costs."""

Group = tuple[int, np.ndarray]
"""Pairs that are learned in one call: a start and its goals if every step is simulated, else a goal and its starts."""


def costs(
    world: GridWorld, method: str, groups: Iterable[Group], trajectories: int, learning: Learning, seed: int = 0
) -> np.ndarray:
    """Find the subgoals of some pairs; return CPU seconds, simulated steps and pairs of each group, float (k, 3)."""
    dynamics = Dynamics(world.successors)
    law = {"alpha": learning.alpha, "gamma": learning.gamma, "epsilon": learning.epsilon, "max_steps": NO_LIMIT}
    survey = Survey(dynamics, trajectories, **law)
    rows = []
    for state, others in groups:
        random, before, begin = np.random.SFC64([seed, state]), survey.steps, time.process_time()
        if method == TREES:
            survey.subgoals_to(state, others, random)
            steps = survey.steps - before
        else:
            _, steps = subgoals_from(dynamics, state, others, random, trajectories, trajectories, **law)
        rows.append((time.process_time() - begin, steps, len(others)))
    return np.array(rows, dtype=float)


def batch_of(world: GridWorld, batch: int, batches: int) -> list[Group]:
    """Return all pairs of every so many-th start, or goal; all batches together hold all ordered pairs of a map."""
    states = np.arange(world.n_states)
    return [(int(state), np.delete(states, state)) for state in states[batch::batches]]


def sample_of(world: GridWorld, method: str, number: int, random: np.random.Generator) -> list[Group]:
    """Draw some goals with all their starts for the trees, or some starts with `GOALS` goals each."""
    states = np.arange(world.n_states)
    groups = [(int(state), np.delete(states, state)) for state in random.choice(states, number, replace=False)]
    if method == EVERY_STEP:
        groups = [(start, random.choice(goals, GOALS, replace=False)) for start, goals in groups]
    return groups
