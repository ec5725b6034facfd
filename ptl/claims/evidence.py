"""The evidence for verdicts: measures, curves, subgoals, maps and tables of one run, in memory.

Claims use this object alone, so that the main run and the settings of a study are judged by the same
code. Anything absent, or from too few seeds, raises `MissingEvidence`, which makes a claim undecided, not wrong.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from ptl.claims.reading import DEFAULT, Reading
from ptl.measures.measures import BASE, BY_NAME, PER_SEED, Names
from ptl.measures.statistics import Resampling
from ptl.world.gridworld import GridWorld

MIN_SEEDS = 10
"""Minimum number of runs for a verdict: the bootstrap of fewer values gives intervals that are too narrow."""


class MissingEvidence(Exception):
    """Results that a claim needs are missing from the run; the message names them."""


class Table(NamedTuple):
    """Runs of one method on one task, or on several added up.

    Attributes
    ----------
    seeds : int array (seeds,)
        In ascending order.
    values : dict of float arrays (seeds,)
        Measures by name.
    """

    seeds: np.ndarray
    values: dict[str, np.ndarray]


@dataclass(frozen=True, kw_only=True)
class Evidence:
    """The results of one run.

    Attributes
    ----------
    per_seed, subgoals : DataFrame
        As in `ptl.measures.measures.Measurements`; the subgoals are optional.
    worlds : mapping of str to GridWorld
        The map of each environment.
    how : Resampling
        Level and number of resamples of every interval.
    window : int
        Episodes of a block in which curves are compared (``measures.window``).
    breakpoint : int
        Number of tasks at which the growth of the library bends (``growth.breakpoint``).
    steps : mapping, optional
        (environment, method, task) to int array (seeds, episodes).
    growth : array, optional
        Size of the library after 0, 1, ... tasks, (runs, tasks + 1).
    frequencies : mapping, optional
        How often each state is the subgoal over all pairs of start and goal, int array (n_states,) by environment.
    selection_cost, library_bytes : DataFrame, optional
        As in `ptl.measures.library_cost`.
    reading : Reading
        How claims read the article's words.
    episodes : int, optional
        Episodes of a task, if there are no ``steps`` to tell.
    used : set of (str, str)
        Environments and methods whose runs have been asked for, "growth" for the growing library.
    """

    per_seed: pd.DataFrame
    worlds: Mapping[str, GridWorld]
    how: Resampling
    window: int
    breakpoint: int
    steps: Mapping[Names, np.ndarray] | None = None
    subgoals: pd.DataFrame | None = None
    growth: np.ndarray | None = None
    frequencies: Mapping[str, np.ndarray] | None = None
    selection_cost: pd.DataFrame | None = None
    library_bytes: pd.DataFrame | None = None
    reading: Reading = DEFAULT
    episodes: int | None = None
    used: set[tuple[str, str]] = field(default_factory=set, compare=False, repr=False)

    def under(self, reading: Reading) -> Evidence:
        """Return the same results under another reading; tables that do not depend on it are shared."""
        other = replace(self, reading=reading, used=set())
        other.__dict__["_tables"] = self._tables
        if self.subgoals is not None:
            other.__dict__["_subgoal_frames"] = self._subgoal_frames
        return other

    # -- measures ------------------------------------------------------------------------------------------

    def values(self, environment: str, task: str, method: str, metric: str) -> np.ndarray:
        """Return a measure of every seed in ascending order, float array (seeds,); NaN: never reached.

        Several tasks, "BCDEF", are added up seed by seed; the transfer ratio is that of their totals.
        """
        values = self._table(environment, task, method).values[metric]
        if BY_NAME[metric].saves and np.isnan(values).any():
            raise MissingEvidence(f"{environment}: method {BASE}, the base of {metric}, is not in this run")
        return values

    def pair(
        self, first: tuple[str, str, str], second: tuple[str, str, str], metric: str
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return a measure of two (environment, task, method) at the seeds that both have, two arrays (seeds,)."""
        one, other = self.values(*first, metric), self.values(*second, metric)
        ours, theirs = self._table(*first).seeds, self._table(*second).seeds
        if np.array_equal(ours, theirs):
            return one, other
        common = np.intersect1d(ours, theirs)
        _check_number(len(common), f"{' '.join(first)} and {' '.join(second)}")
        return one[np.isin(ours, common)], other[np.isin(theirs, common)]

    def _table(self, environment: str, task: str, method: str) -> Table:
        table = self._tables.get((environment, task, method))
        if table is None and len(task) > 1:
            table = self._tables[environment, task, method] = self._sum(environment, task, method)
        if table is None:
            if environment not in {e for e, _, _ in self._tables}:
                raise MissingEvidence(f"environment {environment} is not in this run")
            if (environment, method) not in {(e, m) for e, _, m in self._tables}:
                raise MissingEvidence(f"{environment}: method {method} is not in this run")
            raise MissingEvidence(f"{environment}: task {task} of method {method} is not in this run")
        _check_number(len(table.seeds), f"{environment} {task} {method}")
        self.used.add((environment, method))
        return table

    def _sum(self, environment: str, tasks: str, method: str) -> Table:
        tables = [self._table(environment, task, method) for task in tasks]
        seeds = tables[0].seeds
        if any(not np.array_equal(table.seeds, seeds) for table in tables):
            raise MissingEvidence(f"{environment}: the tasks of method {method} have different seeds")
        values = {name: np.sum([table.values[name] for table in tables], axis=0) for name in tables[0].values}
        if method != BASE and not np.isnan(values["transfer_ratio"]).any():
            base = self._table(environment, tasks, BASE)
            own, theirs = values["total_steps"], base.values["total_steps"][np.searchsorted(base.seeds, seeds)]
            values["transfer_ratio"] = (theirs - own) / theirs
        return Table(seeds, values)

    @cached_property
    def _tables(self) -> dict[tuple[str, str, str], Table]:
        columns = {
            measure.name: self.per_seed[measure.name].to_numpy(dtype=float, na_value=np.nan) for measure in PER_SEED
        }
        seeds = self.per_seed["seed"].to_numpy()
        tables = {}
        for names, rows in self.per_seed.groupby(["environment", "task", "method"]).indices.items():
            environment, task, method = map(str, names)
            rows = rows[np.argsort(seeds[rows], kind="stable")]
            values = {name: column[rows] for name, column in columns.items()}
            tables[environment, task, method] = Table(seeds[rows], values)
        return tables

    def n_seeds(self) -> int:
        """Return the number of seeds of the run."""
        return int(self.per_seed["seed"].nunique())

    # -- everything else -----------------------------------------------------------------------------------

    def curve(self, environment: str, method: str, task: str) -> np.ndarray:
        """Return the steps per episode, int array (seeds, episodes)."""
        self._table(environment, task, method)
        if self.steps is None or (environment, method, task) not in self.steps:
            raise MissingEvidence(f"{environment}: steps per episode of {method}, task {task}, are not in this run")
        return self.steps[environment, method, task]

    def length(self, environment: str, method: str, task: str) -> int:
        """Return the number of episodes of a task."""
        return self.episodes or self.curve(environment, method, task).shape[1]

    def curves(self, environment: str, methods: tuple[str, str], task: str) -> tuple[np.ndarray, np.ndarray]:
        """Return the steps per episode of two methods at the seeds that both have, two int arrays (seeds, episodes)."""
        curves = [self.curve(environment, method, task) for method in methods]
        seeds = [self._table(environment, task, method).seeds for method in methods]
        common = np.intersect1d(seeds[0], seeds[1])
        _check_number(len(common), f"{environment} {task} {' and '.join(methods)}")
        one, other = (curve[np.isin(own, common)] for curve, own in zip(curves, seeds, strict=True))
        if one.shape != other.shape:
            raise MissingEvidence(f"{environment}: {' and '.join(methods)} have different numbers of episodes")
        return one, other

    def world(self, environment: str) -> GridWorld:
        """Return the map of an environment."""
        if environment not in self.worlds:
            raise MissingEvidence(f"environment {environment} is not in this run")
        return self.worlds[environment]

    def goal(self, environment: str, letter: str) -> int:
        """Return the state of a goal letter."""
        world = self.world(environment)
        if letter not in world.goals:
            raise MissingEvidence(f"environment {environment} has no goal {letter}")
        return world.goal(letter)

    def peaks(self, environment: str, method: str, task: str, metric: str) -> np.ndarray:
        """Return the state where a metric ("incremental" or "original") is greatest, int array (seeds,)."""
        return self._subgoal_rows(environment, method, task)[f"{metric}_peak"].to_numpy()

    def stored(self, environment: str, method: str, task: str) -> np.ndarray:
        """Return the state that the library took up after a task, -1 for none, int array (seeds,)."""
        return self._subgoal_rows(environment, method, task)["subgoal"].to_numpy()

    def _subgoal_rows(self, environment: str, method: str, task: str) -> pd.DataFrame:
        rows = self._subgoal_frames.get((environment, method, task))
        if rows is None:
            raise MissingEvidence(f"{environment}: subgoals of {method}, task {task}, are not in this run")
        _check_number(len(rows), f"{environment} {task} {method}")
        self.used.add((environment, method))
        return rows

    @cached_property
    def _subgoal_frames(self) -> dict[tuple[str, str, str], pd.DataFrame]:
        return {
            (str(environment), str(method), str(task)): rows.sort_values("seed")
            for (environment, method, task), rows in self.needed("subgoals").groupby(["environment", "method", "task"])
        }

    def selected(self, environment: str) -> np.ndarray:
        """Return how often each state is the subgoal over all pairs of start and goal, int array (n_states,)."""
        if environment not in (self.frequencies or {}):
            raise MissingEvidence(f"{environment}: subgoal frequencies are not in this run")
        return self.needed("frequencies")[environment]

    def needed(self, name: str) -> Any:
        """Return the attribute of this name, which must not be absent or empty."""
        value = getattr(self, name)
        if value is None or len(value) == 0:
            raise MissingEvidence(f"{name.replace('_', ' ')}: not in this run")
        if name == "growth":
            self.used.add(("", name))
        return value


def _check_number(seeds: int, name: str) -> None:
    if seeds < MIN_SEEDS:
        raise MissingEvidence(f"{name}: {seeds} seeds, fewer than the {MIN_SEEDS} that a verdict needs")


def settings_of(groups: Any) -> dict[str, Any]:
    """Return the settings of `Evidence` from the groups measures, statistics and growth of the configuration.

    Parameters
    ----------
    groups : namespace
        Groups of the configuration as attributes, with their keys as attributes.
    """
    return {
        "how": Resampling(groups.statistics.confidence, groups.statistics.resamples),
        "window": groups.measures.window,
        "breakpoint": groups.growth.breakpoint,
    }
