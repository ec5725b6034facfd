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
from ptl.learning._survey import GIVEN_UP, NO_SUBGOAL, Survey
from ptl.world.gridworld import GridWorld

ARRAYS = ("counts", "unresolved", "pairs", "simulated_steps")
"""Names of the arrays that a survey yields; all of them add up over batches."""


def subgoal_frequencies(
    world: GridWorld,
    starts: np.ndarray,
    goals: Iterable[int],
    trajectories: int,
    learning: Learning,
    root_seed: int,
    environment: str,
) -> dict[str, np.ndarray]:
    """Count subgoals over the tasks to each goal from every start, other than the goal, that can reach it.

    Each goal has its own random stream, so the counts do not depend on how goals are shared out to jobs.

    Returns
    -------
    dict
        ``counts`` (n_states,) int64: tasks whose subgoal is the state; ``unresolved``: tasks whose metric is 0
        everywhere (adjacent cells); ``pairs``; ``simulated_steps``, a small part of all steps of these tasks.

    Raises
    ------
    UserError
        If an episode did not reach the goal within the step limit.
    """
    survey = Survey(
        Dynamics(world.successors),
        trajectories,
        alpha=learning.alpha,
        gamma=learning.gamma,
        epsilon=learning.epsilon,
        max_steps=learning.max_steps,
    )
    counts = np.zeros(world.n_states, dtype=np.int64)
    unresolved = pairs = 0
    for goal in goals:
        origins = starts[world.distances_to(goal)[starts] > 0]
        random = seeding.bit_generator(root_seed, "subgoal_frequencies", environment, int(goal))
        subgoals = survey.subgoals_to(goal, origins, random)
        if (subgoals == GIVEN_UP).any():
            raise UserError(
                f"{world.name}: an episode from state {origins[subgoals == GIVEN_UP][0]} to state {goal} did not reach"
                " the goal within learning.max_steps; raise that limit"
            )
        counts += np.bincount(subgoals[subgoals >= 0], minlength=world.n_states)
        unresolved += int((subgoals == NO_SUBGOAL).sum())
        pairs += len(origins)
    values = (counts, unresolved, pairs, survey.steps)
    return {name: np.asarray(value, dtype=np.int64) for name, value in zip(ARRAYS, values, strict=True)}


def add_up(parts: Iterable[dict[str, np.ndarray]]) -> dict[str, np.ndarray]:
    """Add up the counts of several batches."""
    parts = list(parts)
    return {name: np.sum([part[name] for part in parts], axis=0) for name in parts[0]}
