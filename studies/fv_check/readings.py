"""The readings of the experiment: all runs of one reading of the motion, and what can be asked of them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from ptl.agent import seeding
from ptl.config import Parameters
from ptl.world.gridworld import GridWorld
from studies.fv_check.experiment import LETTERS, LIBRARIES, NEW_TASK, STREAM
from studies.fv_check.simulator import (
    MOTIONS,
    ORDERS,
    TIES,
    Outcome,
    Robots,
    learn,
    optimal_policies,
    policy_quality,
    tie_ranks,
)

SHOWN = tuple(library for library in LIBRARIES if library.published is not None)
"""Libraries with a published value."""

PUBLISHED = {library.name: library.published for library in LIBRARIES if library.published is not None}
"""Published mean gain of each of them by name, read off the source's figure."""

TASKS = tuple(LETTERS)
"""Past tasks, in the order of the files."""


@dataclass(frozen=True)
class Reading:
    """Runs under one reading of the motion and of ties.

    Attributes
    ----------
    motion, ties : str
        Names in `MOTIONS` and `TIES`.
    gain : float array (libraries, runs)
        Mean gain over all trials.
    arm_gain : float array (libraries, runs, arms)
        Mean gain of the trials of each arm.
    arm_trials : int array (libraries, runs, arms)
    quality : float array (past tasks,)
        Mean gain of the past policies in their own tasks, relative to the optimum without noise.
    """

    motion: str
    ties: str
    gain: np.ndarray
    arm_gain: np.ndarray
    arm_trials: np.ndarray
    quality: np.ndarray

    def over_trials(self, library: int) -> np.ndarray:
        """Return the mean gain over all trials of each run, float (runs,)."""
        return self.gain[library]

    def over_arms(self, library: int) -> np.ndarray:
        """Return the mean over the arms of a library of each arm's mean gain, float (runs,)."""
        return self.arm_gain[library, :, : 1 + len(SHOWN[library].tasks)].mean(axis=-1)


SUMMARIES: dict[str, tuple[str, Callable[[Reading, int], np.ndarray]]] = {
    "trials": ("mean over all trials", Reading.over_trials),
    "arms": ("mean over arms, unweighted", Reading.over_arms),
}
"""Readings of what the figure plots by name, as text and as a function of a reading and the index of a library.

The text of the source says the mean over trials. The results that come with one public re-implementation hold 0.071 for
the first library as the unweighted mean over arms, so that may be what was plotted.
"""


def by_order(values: np.ndarray) -> np.ndarray:
    """Return the mean of the runs (runs,) under ties "first_any" with each order of the actions that was run."""
    orders = np.arange(len(values)) % len(ORDERS["first_any"])
    return np.bincount(orders, values) / np.bincount(orders)


def simulate(
    world: GridWorld,
    motion: str,
    parameters: Parameters,
    root_seed: int,
    runs: int,
    trials: int,
    watch: Callable[[Sequence[int]], Iterable[int]] = iter,
) -> dict[str, np.ndarray]:
    """Learn the new task under one motion with every rule for ties and every library.

    Returns
    -------
    dict of arrays
        Those of a file, see `studies.fv_check.jobs.Readings`.
    """
    random = seeding.generator(root_seed, STREAM, "readings", motion)
    robots = Robots(world, MOTIONS[motion], random)
    goals = [world.goal(LETTERS[task]) for task in TASKS]
    ranks, spread = map(np.concatenate, zip(*(tie_ranks(ties, runs) for ties in TIES), strict=True))
    policies = optimal_policies(world, goals, ranks, spread, random)
    # lanes: library by library, in each rule by rule, in each run by run
    members = [[TASKS.index(task) for task in library.tasks] for library in SHOWN]
    outcome = learn(
        robots,
        world.goal(NEW_TASK),
        [own[tasks] for tasks in members for own in policies],
        np.tile(ranks, (len(SHOWN), 1)),
        np.tile(spread, (len(SHOWN), 1)),
        parameters,
        trials,
        random,
        watch,
    )
    quality = [policy_quality(robots, goal, own, parameters) for own, goal in _by_ties(policies, goals)]
    return _by_library(outcome, runs) | {"policy_quality": np.reshape(quality, (len(TIES), len(TASKS)))}


def _by_ties(policies: np.ndarray, goals: Sequence[int]) -> Iterable[tuple[np.ndarray, int]]:
    """Yield the policies of each task (runs, n_states) with its goal, rule by rule."""
    for own in np.split(policies, len(TIES)):
        yield from ((own[:, index], goal) for index, goal in enumerate(goals))


def _by_library(outcome: Outcome, runs: int) -> dict[str, np.ndarray]:
    """Return what the lanes gained by rule, library and run."""
    values = {
        "gain": outcome.gain.mean(axis=0),
        "arm_gain": outcome.arm_gain,
        "arm_trials": outcome.arm_trials,
    }
    shape = (len(SHOWN), len(TIES), runs)
    by_ties = {name: array.reshape(*shape, *array.shape[1:]).swapaxes(0, 1) for name, array in values.items()}
    return {name: np.ascontiguousarray(array) for name, array in by_ties.items()}
