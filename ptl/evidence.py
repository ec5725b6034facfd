"""What verdicts look at: the measures, curves, subgoals, maps and library tables of one run, in memory.

Claims ask this object and nothing else, so a verdict on a run's files and one on a study's arrays are the
same code. What is not there, or stands on too few seeds, raises `Lacking`, which makes a claim undecided, not
wrong.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np
import pandas as pd

from ptl.archive import read_arrays
from ptl.errors import UserError
from ptl.files import read_csv
from ptl.gridworld import GridWorld, load_map
from ptl.statistics import PER_SEED_METRICS, Resampling, read_per_seed

SEEDS_NEEDED = 10
"""Fewer runs than this decide nothing: the bootstrap of fewer values gives intervals that are too narrow."""

COMPARED_WITH_BASE = ("jump_start", "transfer_ratio")
"""Measures that exist only beside runs of the base method."""


class Lacking(Exception):
    """Something that a claim needs is not in the run; the message says what."""


@dataclass(frozen=True)
class Evidence:
    """The results of one run.

    Attributes
    ----------
    per_seed : DataFrame
        As `ptl.measures.measure_files` makes it: a row for each environment, task, method and seed.
    worlds : mapping of str to GridWorld
        The map of each environment.
    steps : mapping, optional
        (environment, method, task) to int array (seeds, episodes).
    subgoals : DataFrame, optional
        As `ptl.measures.measure_files` makes it.
    growth : DataFrame, optional
        Columns run, tasks, library_size.
    selection_cost : DataFrame, optional
        Columns skills, seconds.
    library_bytes : DataFrame, optional
        Columns states, skills, bytes.
    how : Resampling
        Level and number of resamples of every interval.
    """

    per_seed: pd.DataFrame
    worlds: Mapping[str, GridWorld] = field(default_factory=dict)
    steps: Mapping[tuple[str, str, str], np.ndarray] | None = None
    subgoals: pd.DataFrame | None = None
    growth: pd.DataFrame | None = None
    selection_cost: pd.DataFrame | None = None
    library_bytes: pd.DataFrame | None = None
    how: Resampling = field(default_factory=Resampling)

    # -- measures ------------------------------------------------------------------------------------------

    def values(self, environment: str, task: str, method: str, metric: str) -> np.ndarray:
        """A measure of every seed in ascending order, float array (seeds,); NaN: never reached."""
        return self._series(environment, task, method, metric).to_numpy()

    def pair(
        self, first: tuple[str, str, str], second: tuple[str, str, str], metric: str
    ) -> tuple[np.ndarray, np.ndarray]:
        """A measure of two (environment, task, method) at the seeds that both have, two arrays (seeds,)."""
        one, other = self._series(*first, metric), self._series(*second, metric)
        common = one.index.intersection(other.index)
        _check_number(len(common), f"{' '.join(first)} and {' '.join(second)}")
        return one[common].to_numpy(), other[common].to_numpy()

    def _series(self, environment: str, task: str, method: str, metric: str) -> pd.Series:
        frame = self._frame(environment, task, method)
        series = frame[metric]
        if metric in COMPARED_WITH_BASE and series.isna().any():
            raise Lacking(f"{environment}: method no_transfer, the base of {metric}, is not in this run")
        return series

    def _frame(self, environment: str, task: str, method: str) -> pd.DataFrame:
        try:
            frame = self._frames[environment, task, method]
        except KeyError:
            for name, known in (
                (f"environment {environment}", {e for e, _, _ in self._frames}),
                (f"{environment}: method {method}", {m for e, _, m in self._frames if e == environment}),
            ):
                if name.split()[-1] not in known:
                    raise Lacking(f"{name} is not in this run") from None
            raise Lacking(f"{environment}: task {task} of method {method} is not in this run") from None
        _check_number(len(frame), f"{environment} {task} {method}")
        return frame

    @cached_property
    def _frames(self) -> dict[tuple[str, str, str], pd.DataFrame]:
        columns = list(PER_SEED_METRICS)
        return {
            (str(environment), str(task), str(method)): part.set_index("seed")[columns].astype(float).sort_index()
            for (environment, task, method), part in self.per_seed.groupby(["environment", "task", "method"])
        }

    def n_seeds(self) -> int:
        """Number of seeds of the run."""
        return int(self.per_seed["seed"].nunique())

    # -- everything else -----------------------------------------------------------------------------------

    def curve(self, environment: str, method: str, task: str) -> np.ndarray:
        """Steps per episode, int array (seeds, episodes)."""
        self._frame(environment, task, method)
        if self.steps is None or (environment, method, task) not in self.steps:
            raise Lacking(f"{environment}: steps per episode of {method}, task {task}, are not in this run")
        return self.steps[environment, method, task]

    def world(self, environment: str) -> GridWorld:
        """The map of an environment."""
        if environment not in self.worlds:
            raise Lacking(f"environment {environment} is not in this run")
        return self.worlds[environment]

    def peaks(self, environment: str, method: str, task: str, metric: str) -> np.ndarray:
        """State where a metric ("incremental" or "original") is greatest in each seed, int array (seeds,)."""
        return self._subgoal_rows(environment, method, task)[f"{metric}_peak"].to_numpy()

    def stored(self, environment: str, method: str, task: str) -> np.ndarray:
        """State that the library took up after a task in each seed, -1 for none, int array (seeds,)."""
        return self._subgoal_rows(environment, method, task)["subgoal"].to_numpy()

    def _subgoal_rows(self, environment: str, method: str, task: str) -> pd.DataFrame:
        if self.subgoals is None:
            raise Lacking("subgoals are not in this run")
        key = (environment, method, task)
        if key not in self._subgoal_frames:
            raise Lacking(f"{environment}: subgoals of {method}, task {task}, are not in this run")
        rows = self._subgoal_frames[key]
        _check_number(len(rows), f"{environment} {task} {method}")
        return rows

    @cached_property
    def _subgoal_frames(self) -> dict[tuple[str, str, str], pd.DataFrame]:
        assert self.subgoals is not None
        return {
            (str(environment), str(method), str(task)): rows.sort_values("seed")
            for (environment, method, task), rows in self.subgoals.groupby(["environment", "method", "task"])
        }

    def table(self, name: str) -> pd.DataFrame:
        """One of the tables ``growth``, ``selection_cost``, ``library_bytes``, ``subgoals``."""
        frame: pd.DataFrame | None = getattr(self, name)
        if frame is None or frame.empty:
            raise Lacking(f"{name.replace('_', ' ')} is not in this run")
        return frame


def _check_number(seeds: int, name: str) -> None:
    if seeds < SEEDS_NEEDED:
        raise Lacking(f"{name}: {seeds} seeds, fewer than the {SEEDS_NEEDED} that a verdict needs")


# -- from files ---------------------------------------------------------------------------------------------


def read_evidence(
    per_seed: str | Path,
    maps: Mapping[str, str | Path],
    steps: str | Path | None = None,
    subgoals: str | Path | None = None,
    growth: str | Path | None = None,
    selection_cost: str | Path | None = None,
    library_bytes: str | Path | None = None,
    how: Resampling | None = None,
) -> Evidence:
    """Read a run's files; those left out make the claims that need them undecided.

    Raises
    ------
    UserError
        When a file is missing, unreadable or lacks a column.
    """
    where = ("environment", "method", "seed", "task", "subgoal", "incremental_peak", "original_peak")
    return Evidence(
        per_seed=_with_columns(read_per_seed(per_seed), per_seed, PER_SEED_METRICS),
        worlds={name: load_map(path) for name, path in maps.items()},
        steps=None if steps is None else _read_steps(steps),
        subgoals=None if subgoals is None else _read_table(subgoals, where),
        growth=None if growth is None else _read_table(growth, ("run", "tasks", "library_size")),
        selection_cost=None if selection_cost is None else _read_table(selection_cost, ("skills", "seconds")),
        library_bytes=None if library_bytes is None else _read_table(library_bytes, ("states", "skills", "bytes")),
        how=how or Resampling(),
    )


def _read_table(path: str | Path, columns: tuple[str, ...]) -> pd.DataFrame:
    frame = read_csv(path, keep_default_na=False, na_values=[""])
    return _with_columns(frame, path, columns)


def _with_columns(
    frame: pd.DataFrame, path: str | Path, columns: Mapping[str, object] | tuple[str, ...]
) -> pd.DataFrame:
    for column in columns:
        if column not in frame:
            raise UserError(f"{path}: no column {column!r}; make it again")
    return frame


def _read_steps(path: str | Path) -> dict[tuple[str, str, str], np.ndarray]:
    arrays, _ = read_arrays(path, "ptl-steps/1")
    return {(environment, method, task): steps for name, steps in arrays.items()
            for environment, method, task in [name.split("/")]}  # fmt: skip
