"""Many lives of one method in one process, stored as the few arrays that measures and verdicts need."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ptl.agent import seeding
from ptl.config import Parameters
from ptl.learning.discoveries import SubgoalRow, subgoal_row
from ptl.learning.growth import METHOD as GROWTH_METHOD
from ptl.learning.growth import random_tasks
from ptl.learning.life import TaskRecord, learn_life, tasks_of
from ptl.world.gridworld import GridWorld

GROWTH = "growth"
"""Name of the growth of the library in random streams, as in `ptl.learning.growth`."""


def learn_lives(
    world: GridWorld,
    letters: str,
    method: str,
    parameters: Parameters,
    root_seed: int,
    seeds: Iterable[int],
    *stream_names: str,
    budget: int | None = None,
) -> dict[str, np.ndarray]:
    """Learn the tasks of a map with one method, a life for each seed.

    Parameters
    ----------
    stream_names : str
        First names of the random streams, followed by the seed.
    budget : int, optional
        Steps after which no further life is begun.

    Returns
    -------
    dict of arrays
        ``seeds`` (lives,), ``steps`` (lives, tasks, episodes), ``truncated`` (lives, tasks; number of episodes) and, if
        the method keeps a library, the fields of `ptl.learning.discoveries.SubgoalRow` (lives, tasks).
    """
    tasks = tasks_of(world, letters)
    done: list[int] = []
    steps, truncated, rows = [], [], []
    taken = 0
    for seed in seeds:
        if budget is not None and taken > budget:
            break
        life = learn_life(world, tasks, method, parameters, root_seed, *stream_names, seed)
        done.append(seed)
        steps.append([record.steps for record in life.records])
        truncated.append([np.count_nonzero(record.truncated) for record in life.records])
        if life.library is not None:
            rows.append([_subgoal_row(record) for record in life.records])
        taken += int(np.sum(steps[-1]))
    arrays = {"seeds": np.array(done), "steps": np.array(steps), "truncated": np.array(truncated)}
    for name in SubgoalRow._fields if rows else ():
        values = np.array([[getattr(cell, name) for cell in row] for row in rows])
        arrays[name] = values.astype(bytes) if values.dtype.kind == "U" else values
    return arrays


def _subgoal_row(record: TaskRecord) -> SubgoalRow:
    metrics = (record.discovery.incremental.product, record.discovery.original.product)
    return subgoal_row(record.update.subgoal, record.update.reason, record.discovery.novelty, *metrics)


def grow_lives(
    world: GridWorld,
    environment: str,
    tasks: int,
    parameters: Parameters,
    root_seed: int,
    runs: Iterable[int],
    *stream_names: str,
) -> np.ndarray:
    """Let libraries grow over random tasks, a life for each run; return their sizes, int array (runs, tasks + 1)."""
    sizes = []
    for run in runs:
        names: tuple[str | int, ...] = (*stream_names, GROWTH, environment, run)
        drawn = random_tasks(world, tasks, seeding.generator(root_seed, *names, "tasks"))
        life = learn_life(world, drawn, GROWTH_METHOD, parameters, root_seed, *names)
        sizes.append(np.concatenate([[0], np.cumsum([record.update.subgoal >= 0 for record in life.records])]))
    return np.array(sizes)
