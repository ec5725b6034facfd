"""The files of a run: result files measured, and the tables made from them read back.

See `ptl.measures.measures` for the definitions of the measures; that module reads and writes no files.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pandas as pd

from ptl.config import Learning
from ptl.errors import UserError
from ptl.files.store import Result, read_arrays, write_arrays
from ptl.files.tables import read_table
from ptl.jobs.learn import TaskView, tasks_in
from ptl.learning.discoveries import SubgoalRow, subgoal_row
from ptl.measures.library_cost import SELECTION_COLUMNS, STORAGE_COLUMNS
from ptl.measures.measures import PER_SEED_COLUMNS, SUBGOAL_COLUMNS, Measurements, Names, Runs, Steps, measure
from ptl.world.gridworld import GridWorld


def measure_files(
    results: Iterable[Result],
    window: int,
    threshold_factor: float,
    foreign: Iterable[Runs] = (),
    learning: Learning | None = None,
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
    learning : Learning, optional
        See `ptl.measures.measures.measure`.

    Raises
    ------
    UserError
        If a file cannot be used, or the window is longer than a task.
    """
    worlds: dict[str, GridWorld] = {}
    collected: dict[Names, list[tuple[int, np.ndarray, int, SubgoalRow | None]]] = {}
    for result in results:
        job = result.job
        worlds[job.environment] = result.world
        keeps_library = "library/subgoals" in result.arrays
        for letter, task in tasks_in(result).items():
            row = (
                job.seed,
                task.steps,
                int(np.count_nonzero(task.truncated)),
                _subgoal_row(task) if keeps_library else None,
            )
            collected.setdefault((job.environment, job.method, letter), []).append(row)
    if not collected:
        raise UserError("no learning file to measure; name at least one")
    runs = [*(_together(*item) for item in collected.items()), *foreign]
    return measure(runs, worlds, window, threshold_factor, learning)


def _subgoal_row(task: TaskView) -> SubgoalRow:
    return subgoal_row(task.subgoal, task.reason, task.novelty, task.incremental, task.original)


def _together(names: Names, rows: list[tuple[int, np.ndarray, int, SubgoalRow | None]]) -> Runs:
    seeds, steps, truncated, subgoals = zip(*rows, strict=True)
    kept = [row for row in subgoals if row is not None]
    return Runs(
        *names,
        seeds=np.array(seeds),
        steps=np.stack(steps),
        truncated=np.array(truncated),
        subgoals=dict(zip(SubgoalRow._fields, map(np.array, zip(*kept, strict=True)), strict=True)) if kept else None,
    )


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


def episode_table(measured: Measurements) -> pd.DataFrame:
    """Return the steps per episode as a table.

    Returns
    -------
    DataFrame
        Columns environment, task, method and seed, then a column of steps for each episode, counted from 1. Rows are
        those of ``per_seed``.
    """
    names = measured.per_seed[["environment", "task", "method", "seed"]]
    in_order = names[["environment", "method", "task"]].drop_duplicates()
    steps = np.concatenate([measured.steps[key] for key in in_order.itertuples(index=False, name=None)])
    return names.join(pd.DataFrame(steps, columns=range(1, steps.shape[1] + 1)))


# -- tables -------------------------------------------------------------------------------------------------------

GROWTH_COLUMNS = ("run", "tasks", "library_size")


def library_sizes(results: Iterable[Result]) -> pd.DataFrame:
    """Return the size of the library after every task of each growth file, columns `GROWTH_COLUMNS`."""
    parts = []
    for result in results:
        sizes = result.arrays["library_size"]
        parts.append(pd.DataFrame({"run": result.job.seed, "tasks": range(len(sizes)), "library_size": sizes}))
    return pd.concat(parts, ignore_index=True)


def read_sizes(path: str | Path) -> np.ndarray:
    """Read the table of `library_sizes` as float array (runs, tasks + 1); column t is the size after t tasks.

    Raises
    ------
    UserError
        When the file cannot be read or a run lacks a number of tasks that others have.
    """
    frame = read_table(path, GROWTH_COLUMNS)
    sizes = frame.pivot_table(index="run", columns="tasks", values="library_size")
    if not sizes.size == len(frame) > 0 or sizes.columns.tolist() != list(range(sizes.shape[1])):
        raise UserError(
            f"{path}: runs with different numbers of tasks, or none; remove the table and run the workflow again"
        )
    return sizes.to_numpy(dtype=float)


def read_per_seed(path: str | Path) -> pd.DataFrame:
    """Read ``per_seed.csv``; errors as in `ptl.files.tables.read_table`."""
    return read_table(path, PER_SEED_COLUMNS)


def read_subgoals(path: str | Path) -> pd.DataFrame:
    """Read ``subgoals.csv``; errors as in `ptl.files.tables.read_table`."""
    return read_table(path, SUBGOAL_COLUMNS)


def read_selection(path: str | Path) -> pd.DataFrame:
    """Read the operations of a selection; errors as in `ptl.files.tables.read_table`."""
    return read_table(path, SELECTION_COLUMNS)


def read_storage(path: str | Path) -> pd.DataFrame:
    """Read the bytes of libraries; errors as in `ptl.files.tables.read_table`."""
    return read_table(path, STORAGE_COLUMNS)
