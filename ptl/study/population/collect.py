"""From the files of lives to a row for each life, and for each of its tasks."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import msgspec
import numpy as np
import pandas as pd

from ptl import methods
from ptl.config import Parameters
from ptl.errors import UserError
from ptl.files.arrays import read_arrays
from ptl.files.csv import read_csv
from ptl.files.remedies import make_again
from ptl.files.schema import LIVES
from ptl.methods.beyond import reference
from ptl.study.population.running import Cell
from ptl.study.tables import read_table

KEYS = ("family", "map", "size", "sequence", "method", "per_task", "seed")
TASK_COLUMNS = (
    *KEYS, "task", "steps", "first_episode", "optimum", "truncated", "library_size", "states", "winding",
)  # fmt: skip
"""``task`` counts from 1; ``optimum`` is episodes x shortest path; ``library_size`` is that after the task."""

LIFE_COLUMNS = ("family", "map", "size", "sequence", "method", "seed", "total_steps", "optimum", "library_size")
"""Columns of ``per_life.csv``: steps and optimum are those of the tasks after the first."""


def per_task(paths: Iterable[str | Path]) -> pd.DataFrame:
    """Return a row for each task of each life, columns `TASK_COLUMNS`.

    ``size`` is the wanted number of states of a generated map and the number of states of a given one.

    Raises
    ------
    UserError
        When a file is missing, damaged or of another kind.
    """
    return pd.concat(map(_rows, paths), ignore_index=True)


def _rows(path: str | Path) -> pd.DataFrame:
    arrays, origin = read_arrays(path, LIVES)
    job = origin["job"]
    try:
        cell = msgspec.convert(job["cell"], Cell)
    except msgspec.ValidationError as error:
        raise UserError(f"{path}: holds a job that cannot be right ({error}); {make_again(path)}") from error
    episodes = Parameters.from_dict(job["parameters"]).learning.episodes
    shape = arrays["steps"].shape
    maps, seeds = shape[:2]
    if (maps, seeds) != (len(cell.maps), cell.seeds):
        raise UserError(f"{path}: holds {maps} x {seeds} lives, not those of its job; {make_again(path)}")
    places = [place if cell.size else Path(str(place)).stem for place in cell.maps]
    of_map, of_seed, of_task = (index.ravel() for index in np.indices(shape))
    return pd.DataFrame(
        {
            "family": cell.family,
            "map": np.array(places, dtype=object).astype(str)[of_map],
            "size": cell.size or arrays["states"][of_map],
            "sequence": cell.sequence,
            "method": methods.identifier(reference(cell.method)),
            "per_task": cell.per_task,
            "seed": of_seed,
            "task": of_task + 1,
            "steps": arrays["steps"].ravel(),
            "first_episode": arrays["first"].ravel(),
            "optimum": (episodes * arrays["shortest"])[of_map, of_task],
            "truncated": arrays["truncated"].ravel(),
            "library_size": arrays["library_size"].ravel(),
            "states": arrays["states"][of_map],
            "winding": arrays["winding"][of_map],
        },
        columns=list(TASK_COLUMNS),
    )


def per_life(tasks: pd.DataFrame) -> pd.DataFrame:
    """Return a row for each life of a method as it is, columns `LIFE_COLUMNS`; the sums leave out the first task.

    The first task is the same for all methods that need a library or a memory, which is empty then.
    """
    later = tasks[(tasks["task"] > 1) & (tasks["per_task"] == 0)]
    grouped = later.groupby([name for name in KEYS if name != "per_task"], sort=False)
    return grouped.agg(
        total_steps=("steps", "sum"), optimum=("optimum", "sum"), library_size=("library_size", "last")
    ).reset_index()[list(LIFE_COLUMNS)]


def read_tasks(path: str | Path) -> pd.DataFrame:
    """Read the table of `per_task` back."""
    return read_csv(path, dtype=dict.fromkeys(("family", "map", "sequence", "method"), str))


def read_lives(path: str | Path) -> pd.DataFrame:
    """Read ``per_life.csv`` or a table of the same columns that another program has written.

    Raises
    ------
    UserError
        When it cannot be read, lacks a column, or holds a life twice.
    """
    frame = read_table(path, LIFE_COLUMNS)
    frame["map"] = frame["map"].astype(str)
    twice = frame[frame.duplicated(["family", "map", "size", "sequence", "method", "seed"])]
    if len(twice):
        row = twice.iloc[0]
        raise UserError(
            f"{path}: family {row['family']}, map {row['map']}, method {row['method']}, seed {row['seed']} is there"
            " twice; give each life once"
        )
    return frame
