"""Subgoal selection frequencies: how often each state is the subgoal over all pairs of start and goal.

The original FD metric, one task of Q-learning from nothing for every ordered pair (the article's figure 8).
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from ptl.agent import seeding
from ptl.agent._kernel import Dynamics
from ptl.config import Learning
from ptl.errors import UserError
from ptl.learning._survey import GIVEN_UP, NO_SUBGOAL, Survey, subgoals_from
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
        everywhere (adjacent cells); ``pairs``; ``simulated_steps``, a small part of all steps of these tasks if equal
        actions tie at random.

    Raises
    ------
    UserError
        If an episode did not reach the goal within the step limit.
    """
    dynamics, kept = Dynamics(world.successors, world.slip), ("alpha", "gamma", "epsilon", "max_steps")
    rates: dict[str, Any] = {name: getattr(learning, name) for name in kept}
    survey = Survey(dynamics, trajectories, **rates)
    single_steps = 0
    counts = np.zeros(world.n_states, dtype=np.int64)
    unresolved = pairs = 0
    for goal in goals:
        origins = starts[world.distances_to(goal)[starts] > 0]
        random = seeding.bit_generator(root_seed, "subgoal_frequencies", environment, int(goal))
        if learning.ties == "random":
            subgoals = survey.subgoals_to(goal, origins, random)
        else:  # where nothing is known the agent does not walk uniformly, so every step is simulated
            subgoals = np.empty(len(origins), dtype=np.int32)
            for i, start in enumerate(origins):
                [subgoals[i]], steps = subgoals_from(
                    dynamics, start, [goal], random, trajectories, trajectories, **rates, ties=learning.ties
                )
                single_steps += steps
        if (subgoals == GIVEN_UP).any():
            raise UserError(
                f"{world.name}: an episode from state {origins[subgoals == GIVEN_UP][0]} to state {goal} did not reach"
                " the goal within learning.max_steps; raise that limit"
            )
        counts += np.bincount(subgoals[subgoals >= 0], minlength=world.n_states)
        unresolved += int((subgoals == NO_SUBGOAL).sum())
        pairs += len(origins)
    values = (counts, unresolved, pairs, survey.steps + single_steps)
    return {name: np.asarray(value, dtype=np.int64) for name, value in zip(ARRAYS, values, strict=True)}


def add_up(parts: Iterable[dict[str, np.ndarray]]) -> dict[str, np.ndarray]:
    """Add up the counts of several batches."""
    parts = list(parts)
    return {name: np.sum([part[name] for part in parts], axis=0) for name in parts[0]}
