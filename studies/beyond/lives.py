"""Many lives of one method on some maps, stored as sums over episodes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from ptl import methods
from ptl.config import Parameters
from ptl.errors import UserError
from ptl.learning.life import Task, learn_life, tasks_of
from ptl.methods.ptl import Method as PartialTransfer
from ptl.world.gridworld import GridWorld
from ptl.world.optimum import optimal_steps
from studies.beyond.changes import changing_worlds
from studies.beyond.maps import winding
from studies.beyond.methods._sized import sized

NO_CHANGE = "none"
"""Name of the rule by which no map changes."""


def variant(reference: str, per_task: int) -> type[methods.BaseMethod]:
    """Return a method as it is, or one that adds ``per_task`` skills after each task.

    Raises
    ------
    UserError
        If there is no such method, or skills are to be added to a method other than a variant of PTL.
    """
    kind = methods.load(reference)
    if not per_task:
        return kind
    if not issubclass(kind, PartialTransfer):
        raise UserError(f"per_task: {per_task} skills a task need a variant of ptl, not {reference}")
    return sized(kind, methods.identifier(kind), per_task)


def tasks_in(world: GridWorld, letters: str, change: str, *names: str | int) -> list[Task]:
    """Return the tasks of a map, each with its own map if these change, see `studies.beyond.changes.changing_worlds`.

    Parameters
    ----------
    letters : str
        Goals in the order in which they are learned.
    change : str
        `NO_CHANGE`, or the rule by which the map changes between tasks.
    names : str or int
        What the changes derive from.
    """
    if change == NO_CHANGE:
        return tasks_of(world, letters)
    worlds = changing_worlds(world, change, len(letters), *names)
    return [Task(letter, there.start, there.goal(letter), there) for letter, there in zip(letters, worlds, strict=True)]


def lives_on_maps(
    worlds: Iterable[tuple[str | int, GridWorld]],
    letters: str,
    kind: type[methods.BaseMethod],
    parameters: Parameters,
    root_seed: int,
    seeds: int,
    *stream_names: str | int,
    change: str = NO_CHANGE,
) -> dict[str, np.ndarray]:
    """Learn the tasks of each map with one method, ``seeds`` lives on each.

    Parameters
    ----------
    worlds : iterable
        Pairs of a map's name in random streams and the map.
    letters : str
        Goals in the order in which they are learned.
    stream_names : str or int
        First names of the random streams, followed by those of the map and of the life.
    change : str
        See `tasks_in`; the changes are those of a map, whatever the method, the life and the slip.

    Returns
    -------
    dict of arrays
        int64 (maps, seeds, tasks): ``steps`` of all episodes, ``first`` (steps of the first episode), ``last`` (steps
        of the last `last_episodes`), ``truncated`` (number of episodes) and ``library_size`` after the task; int64
        (maps, tasks): ``shortest`` path of each task;
        float64 (maps, tasks): ``optimum``, the expected steps of the best policy where steps slip; ``states``,
        int64 (maps,), and ``winding``, float64 (maps,).
    """
    rows: list[dict[str, Any]] = []
    for place, world in worlds:
        tasks = tasks_in(world, letters, change, *stream_names, place)
        world = tasks[0].world or world
        names = (*stream_names, place)
        lives = [learn_life(world, tasks, kind, parameters, root_seed, *names, seed).records for seed in range(seeds)]
        placed = [(task, task.world or world) for task in tasks]
        rows.append(
            {
                "steps": [[record.steps.sum() for record in life] for life in lives],
                "first": [[record.steps[0] for record in life] for life in lives],
                "last": [[record.steps[-last_episodes(parameters) :].sum() for record in life] for life in lives],
                "truncated": [[record.truncated.sum() for record in life] for life in lives],
                "library_size": [[record.library_size for record in life] for life in lives],
                "shortest": [there.shortest_path_length(task.start, task.goal) for task, there in placed],
                "optimum": [expected_optimum(there, task) for task, there in placed],
                "states": world.n_states,
                "winding": winding(world),
            }
        )
    return _stacked(rows)


def last_episodes(parameters: Parameters) -> int:
    """Return how many episodes at the end of a task show what was learned: a tenth, at least one."""
    return max(1, parameters.learning.episodes // 10)


def expected_optimum(world: GridWorld, task: Task) -> float:
    """Return the expected steps of the best policy; without slip the shortest path, as a whole number."""
    if world.slip == 0:
        return float(world.shortest_path_length(task.start, task.goal))
    return float(optimal_steps(world, task.goal)[task.start])


def _stacked(rows: Sequence[Mapping[str, Any]]) -> dict[str, np.ndarray]:
    types = {name: np.float64 if name in ("winding", "optimum") else np.int64 for name in rows[0]}
    return {name: np.array([row[name] for row in rows], dtype=kind) for name, kind in types.items()}
