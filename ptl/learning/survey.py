"""Subgoal selection frequencies: how often each state is the subgoal over all pairs of start and goal.

The original FD metric, one task of Q-learning from nothing for every ordered pair (the article's figure 8).
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ptl.agent import seeding
from ptl.agent._kernel import Dynamics
from ptl.config import Learning
from ptl.errors import UserError
from ptl.learning._survey import subgoals_from
from ptl.world.gridworld import GridWorld

ATTEMPTS_PER_TRAJECTORY = 10
"""A task is given up after this many episodes for each successful one that is wanted."""

ARRAYS = ("counts", "unresolved", "pairs", "total_steps", "starts")
"""Names of the arrays that a survey yields; all of them add up over batches."""


def chosen_starts(world: GridWorld, number: int | None, root_seed: int, environment: str) -> np.ndarray:
    """Return the start states of the survey: all, or a random sample of ``number`` of them in ascending order."""
    if number is None or number >= world.n_states:
        return np.arange(world.n_states)
    random = seeding.generator(root_seed, "subgoal_frequencies", environment, "starts")
    return np.sort(random.choice(world.n_states, size=number, replace=False))


def subgoal_frequencies(
    world: GridWorld, starts: Iterable[int], trajectories: int, learning: Learning, root_seed: int, environment: str
) -> dict[str, np.ndarray]:
    """Count subgoals over the tasks from each start to every other state that it can reach.

    Each start has a random stream of its own, so the counts do not depend on how starts are shared out to jobs.

    Returns
    -------
    dict
        ``counts`` (n_states,) int64: tasks whose subgoal is the state; ``unresolved``: tasks whose metric is 0
        everywhere (adjacent cells); ``pairs``, ``total_steps``, ``starts`` (number of start states).

    Raises
    ------
    UserError
        If a task did not succeed often enough within the step limit.
    """
    dynamics = Dynamics(world.successors)
    counts = np.zeros(world.n_states, dtype=np.int64)
    unresolved = pairs = total_steps = n_starts = 0
    for start in starts:
        distance = world.distances_to(start)
        goals = np.flatnonzero(distance > 0).astype(np.int32)
        subgoals, steps = subgoals_from(
            dynamics,
            int(start),
            goals,
            seeding.bit_generator(root_seed, "subgoal_frequencies", environment, int(start)),
            trajectories,
            trajectories * ATTEMPTS_PER_TRAJECTORY,
            alpha=learning.alpha,
            gamma=learning.gamma,
            epsilon=learning.epsilon,
            max_steps=learning.max_steps,
        )
        if (subgoals == -2).any():
            raise UserError(
                f"{world.name}: from state {start} to state {goals[subgoals == -2][0]} too few episodes reached the"
                " goal within learning.max_steps; raise that limit"
            )
        counts += np.bincount(subgoals[subgoals >= 0], minlength=world.n_states)
        unresolved += int((subgoals == -1).sum())
        pairs += len(goals)
        total_steps += steps
        n_starts += 1
    values = (counts, unresolved, pairs, total_steps, n_starts)
    return {name: np.asarray(value, dtype=np.int64) for name, value in zip(ARRAYS, values, strict=True)}


def add_up(parts: Iterable[dict[str, np.ndarray]]) -> dict[str, np.ndarray]:
    """Add up the counts of several batches."""
    parts = list(parts)
    return {name: np.sum([part[name] for part in parts], axis=0) for name in parts[0]}
