"""Measures of the learning files of a run, and the file of steps per episode that they leave."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

import numpy as np

from ptl.errors import UserError
from ptl.files.store import Result, read_arrays, write_arrays
from ptl.jobs.learn import TaskView, tasks_in
from ptl.learning.discoveries import Found, found
from ptl.measures.measures import Measurements, Names, Runs, measure
from ptl.world.gridworld import GridWorld


def measure_files(
    results: Iterable[Result], window: int, threshold_factor: float, foreign: Iterable[Runs] = ()
) -> Measurements:
    """Measure the learning files of a run, one at a time in memory.

    Parameters
    ----------
    results : iterable of Result
        Files of learning jobs. Environments and methods keep the order in which they first appear, and the seeds of a
        method follow each other in ascending order.
    window, threshold_factor
        See `ptl.measures.measures.Curves`.
    foreign : iterable of Runs
        Runs of other programs on the same environments, tasks, seeds and episodes.

    Raises
    ------
    UserError
        If a file cannot be used, or the window is longer than a task.
    """
    worlds: dict[str, GridWorld] = {}
    collected: dict[Names, list[tuple[int, np.ndarray, int, Found | None]]] = {}
    for result in results:
        job = result.job
        worlds[job.environment] = result.world
        keeps_library = "library/subgoals" in result.arrays
        for letter, task in tasks_in(result).items():
            row = job.seed, task.steps, int(np.count_nonzero(task.truncated)), _found(task) if keeps_library else None
            collected.setdefault((job.environment, job.method, letter), []).append(row)
    if not collected:
        raise UserError("no learning file to measure; name at least one")
    return measure([*(_together(*item) for item in collected.items()), *foreign], worlds, window, threshold_factor)


def _found(task: TaskView) -> Found:
    return found(task.subgoal, task.reason, task.novelty, task.incremental, task.original)


def _together(names: Names, rows: list[tuple[int, np.ndarray, int, Found | None]]) -> Runs:
    seeds, steps, truncated, subgoals = zip(*rows, strict=True)
    kept = [row for row in subgoals if row is not None]
    return Runs(
        *names,
        seeds=np.array(seeds),
        steps=np.stack(steps),
        truncated=np.array(truncated),
        found=dict(zip(Found._fields, map(np.array, zip(*kept, strict=True)), strict=True)) if kept else None,
    )


Steps = Mapping[Names, np.ndarray]
"""Steps per episode by environment, method and task, int64 arrays (seeds, episodes)."""


def write_steps(path: str | Path, steps: Steps) -> None:
    """Write the steps per episode: /<environment>/<method>/<task>."""
    write_arrays(path, {"/".join(names): values for names, values in steps.items()}, {})


def read_steps(path: str | Path) -> dict[Names, np.ndarray]:
    """Read the file of `write_steps`.

    Raises
    ------
    UserError
        If it is missing or damaged.
    """
    arrays, _ = read_arrays(path)
    return {
        (environment, method, task): values
        for name, values in arrays.items()
        for environment, method, task in [name.split("/")]
    }
