"""The measures of transfer, each defined once, and the tables of all seeds that are made from them.

Jump start, asymptotic performance and time to threshold go back to Langley; total performance and transfer ratio to
Taylor and Stone (JMLR 10, 2009). The transfer ratio has its sign flipped so that positive is good (stated in the
article). Performance is the number of steps of an episode; fewer is better.

To add a measure, add its entry to `MEASURES`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
import pandas as pd

from ptl.errors import UserError
from ptl.learning.discoveries import SubgoalRow
from ptl.measures.exact import expected_first_episode
from ptl.world.optimum import optimum

if TYPE_CHECKING:
    from ptl.config import Learning
    from ptl.world.gridworld import GridWorld

BASE = "no_transfer"
"""Method that the others are compared with, on the same environment, task and seed."""

Better = Literal["lower", "higher"]


# -- definitions ---------------------------------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class Curves:
    """Steps per episode of one method on one task, with the settings of the measures.

    Attributes
    ----------
    steps : int array (seeds, episodes)
    base : int array (seeds, episodes) or None
        Steps of the method without transfer, same seeds.
    truncated : int array (seeds,)
        Number of episodes cut off at the step limit.
    optimum : float
        Least expected steps from the start to the goal: the shortest path where no step slips.
    window : int
        Episodes that the asymptotic mean and the moving mean behind the time to threshold cover.
    threshold_factor : float
        The threshold is this many times the optimum.
    expected_first : float, optional
        Expected steps of the base's first episode, to be taken instead of those of ``base``.

    Raises
    ------
    UserError
        When the window is longer than a task.
    """

    steps: np.ndarray
    base: np.ndarray | None
    truncated: np.ndarray
    optimum: float
    window: int
    threshold_factor: float
    expected_first: float | None = None

    def __post_init__(self) -> None:
        episodes = self.steps.shape[1]
        if not 1 <= self.window <= episodes:
            raise UserError(f"measures.window: {self.window} is not between 1 and the {episodes} episodes of a task")


def first_episode(curves: Curves) -> np.ndarray:
    """Return the steps of the first episode, shape (seeds,)."""
    return curves.steps[:, 0]


def jump_start(curves: Curves) -> np.ndarray:
    """Return the first-episode steps of the base, their expectation if it is known, minus the method's, (seeds,)."""
    base = _base_steps(curves)[:, 0] if curves.expected_first is None else curves.expected_first
    return base - curves.steps[:, 0]


def asymptotic(curves: Curves) -> np.ndarray:
    """Return the mean steps of the last ``window`` episodes, shape (seeds,)."""
    return curves.steps[:, -curves.window :].mean(axis=1)


def threshold_episode(curves: Curves) -> np.ndarray:
    """Return the time to threshold, float array (seeds,), NaN where the threshold is never reached.

    It is the number (counted from 1) of the episode that completes the first ``window`` episodes whose mean is at
    most ``threshold_factor`` times the optimum; so it is never less than ``window``.
    """
    seeds, window = len(curves.steps), curves.window
    sums = np.cumsum(np.hstack([np.zeros((seeds, 1), dtype=np.int64), curves.steps]), axis=1)
    reached = (sums[:, window:] - sums[:, :-window]) / window <= curves.threshold_factor * curves.optimum
    return np.where(reached.any(axis=1), reached.argmax(axis=1) + float(window), np.nan)


def total_steps(curves: Curves) -> np.ndarray:
    """Return the sum of the steps of all episodes, shape (seeds,)."""
    return curves.steps.sum(axis=1)


def transfer_ratio(curves: Curves) -> np.ndarray:
    """Return (total of the base - total of the method) / total of the base, shape (seeds,)."""
    base = _base_steps(curves).sum(axis=1)
    return (base - curves.steps.sum(axis=1)) / base


def _base_steps(curves: Curves) -> np.ndarray:
    assert curves.base is not None  # see Measure.column
    return curves.base


def truncated(curves: Curves) -> np.ndarray:
    """Return the number of episodes cut off at the step limit, shape (seeds,)."""
    return curves.truncated


@dataclass(frozen=True)
class Measure:
    """The definition of a measure.

    Attributes
    ----------
    name : str
        Column of ``per_seed.csv`` and metric of ``metrics.csv``.
    heading, unit : str
        Name and unit for readers.
    better : "lower" or "higher"
    function : callable, optional
        Takes `Curves` and returns an array (seeds,). Without it the measure is the ratio of two means: of the steps
        saved by ``saves``, to the base's.
    table : "transfer" or "total", optional
        Table of each environment that shows it.
    saves : str
        Measure whose savings against the base this one expresses; such a measure is 0 for the base by definition,
        and runs are compared by the measure that it names.
    difference : str
        Measure that has the steps saved by each run, for a ratio of means; without it runs are subtracted.
    factor : float
        Factor of a ratio of means (100 for percent).
    whole : bool
        Whether its values are whole numbers.
    can_miss : bool
        Whether a run may have no value; the share of runs that have one is estimated too.
    compared : bool
        Whether runs are compared with runs of the base by it.
    """

    name: str
    heading: str
    unit: str
    better: Better
    function: Callable[[Curves], np.ndarray] | None = None
    table: Literal["transfer", "total"] | None = None
    saves: str = ""
    difference: str = ""
    factor: float = 1.0
    whole: bool = False
    can_miss: bool = False
    compared: bool = True

    @property
    def compared_by(self) -> str:
        """Name of the measure by which runs are compared with runs of the base."""
        return self.saves or self.name

    def column(self, curves: Curves) -> np.ndarray:
        """Return its value for each seed; all are NaN if it needs a base and there is none."""
        assert self.function is not None
        absent = self.saves and curves.base is None
        return np.full(len(curves.steps), np.nan) if absent else self.function(curves)


MEASURES = (
    Measure("first_episode", "First episode", "steps", "lower", first_episode, whole=True),
    Measure("jump_start", "Jump start", "steps", "higher", jump_start, "transfer", saves="first_episode"),
    Measure("jump_start_percent", "Jump start", "% of the base's mean", "higher", table="transfer",
            saves="first_episode", factor=100.0, difference="jump_start"),
    Measure("asymptotic", "Asymptotic performance", "steps", "lower", asymptotic, "transfer"),
    Measure("threshold_episode", "Time to threshold", "episodes", "lower", threshold_episode, "transfer",
            whole=True, can_miss=True),
    Measure("total_steps", "Total performance", "steps", "lower", total_steps, "total", whole=True),
    Measure("transfer_ratio", "Transfer ratio", "mean of per-seed ratios", "higher", transfer_ratio, "total",
            saves="total_steps"),
    Measure("transfer_ratio_of_means", "Transfer ratio", "ratio of the means", "higher", table="total",
            saves="total_steps"),
    Measure("truncated", "Truncated episodes", "episodes", "lower", truncated, whole=True, compared=False),
)  # fmt: skip
"""All measures, in the order of the tables."""

BY_NAME = {measure.name: measure for measure in MEASURES}

PER_SEED = tuple(sorted((m for m in MEASURES if m.function), key=lambda m: (not m.compared, bool(m.saves))))
"""Measures with a value for each seed, in the order of ``per_seed.csv``: own values, comparisons, the rest."""

PER_SEED_COLUMNS = ("environment", "task", "method", "seed", *(measure.name for measure in PER_SEED))

SUBGOAL_COLUMNS = (
    "environment", "method", "seed", "task", "subgoal", "row", "column", "novelty", "metric_value", "reason",
    "incremental_peak", "original_peak",
)  # fmt: skip


# -- measuring -----------------------------------------------------------------------------------------------

Names = tuple[str, str, str]
"""Environment, method and task."""

Steps = Mapping[Names, np.ndarray]
"""Steps per episode by environment, method and task, int64 arrays (seeds, episodes)."""


@dataclass(frozen=True)
class Runs:
    """Runs of one method on one task of an environment.

    Attributes
    ----------
    environment, method, task : str
    seeds : int array (seeds,)
        In ascending order.
    steps : int array (seeds, episodes)
    truncated : int array (seeds,)
        Number of episodes cut off at the step limit.
    subgoals : dict of arrays (seeds,), optional
        Fields of `ptl.learning.discoveries.SubgoalRow`, for methods that keep a library.
    """

    environment: str
    method: str
    task: str
    seeds: np.ndarray
    steps: np.ndarray
    truncated: np.ndarray
    subgoals: Mapping[str, np.ndarray] | None = None

    @property
    def names(self) -> Names:
        """Environment, method and task."""
        return self.environment, self.method, self.task


@dataclass(frozen=True)
class Measurements:
    """Tables and curves of all runs.

    Attributes
    ----------
    per_seed : DataFrame
        Columns `PER_SEED_COLUMNS`. Comparisons are missing where a seed has no run of the base.
    subgoals : DataFrame
        Columns `SUBGOAL_COLUMNS`, a row for each task of the methods that keep a library; the cell is missing if no
        subgoal was taken up. See `ptl.learning.discoveries.SubgoalRow`.
    steps : dict
        (environment, method, task) to int array (seeds, episodes), seeds in ascending order.
    """

    per_seed: pd.DataFrame
    subgoals: pd.DataFrame
    steps: dict[Names, np.ndarray]


def measure(
    runs: Sequence[Runs],
    worlds: Mapping[str, GridWorld],
    window: int,
    threshold_factor: float,
    learning: Learning | None = None,
) -> Measurements:
    """Measure runs.

    Parameters
    ----------
    runs : sequence of Runs
        Environments, their tasks and methods keep the order in which they first appear here.
    worlds : mapping of environment to GridWorld
    window, threshold_factor
        See `Curves`.
    learning : Learning, optional
        Settings of the learner. With them first episodes are compared with the exact expectation of those of the base,
        where there is one.

    Raises
    ------
    UserError
        When the window is longer than a task.
    """
    by_names = {own.names: own for own in runs}
    tasks = list(dict.fromkeys((own.environment, own.task) for own in runs))
    environments, methods = (list(dict.fromkeys(names[place] for names in by_names)) for place in (0, 1))
    in_order = sorted(
        runs,
        key=lambda own: (
            environments.index(own.environment),
            tasks.index((own.environment, own.task)),
            methods.index(own.method),
        ),
    )
    expected = {
        (environment, task): expected_first_episode(worlds[environment], worlds[environment].goal(task), learning)
        for environment, task in tasks
        if learning is not None and (environment, BASE, task) in by_names
    }
    optima = {(name, task): optimum(worlds[name], worlds[name].goal(task)) for name, task in tasks}
    frames = []
    for own in in_order:
        base = by_names.get((own.environment, BASE, own.task))
        curves = Curves(
            steps=own.steps,
            base=_paired(own, base),
            truncated=own.truncated,
            optimum=optima[own.environment, own.task],
            window=window,
            threshold_factor=threshold_factor,
            expected_first=None if own is base else expected.get((own.environment, own.task)),
        )
        names = {"environment": own.environment, "task": own.task, "method": own.method, "seed": own.seeds}
        frames.append(pd.DataFrame(names | {measure.name: measure.column(curves) for measure in PER_SEED}))
    learners = list(dict.fromkeys((own.environment, own.method) for own in runs if own.subgoals is not None))
    parts = [
        pd.concat([_subgoals(own, worlds[own.environment]) for own in runs if own.names[:2] == learner])
        for learner in learners
    ]
    subgoals = [part.sort_values("seed", kind="stable") for part in parts]
    per_seed = pd.concat(frames, ignore_index=True) if frames else pd.DataFrame(columns=list(PER_SEED_COLUMNS))
    return Measurements(
        per_seed=per_seed.astype({own.name: "Int64" if own.whole else "float64" for own in PER_SEED}),
        subgoals=pd.concat(subgoals, ignore_index=True) if subgoals else pd.DataFrame(columns=list(SUBGOAL_COLUMNS)),
        steps={own.names: own.steps for own in runs},
    )


def _paired(own: Runs, base: Runs | None) -> np.ndarray | None:
    """Return the steps of the base at the method's seeds, or None if it lacks one of them."""
    if base is None or not np.isin(own.seeds, base.seeds).all():
        return None
    return base.steps[np.searchsorted(base.seeds, own.seeds)]


def _subgoals(own: Runs, world: GridWorld) -> pd.DataFrame:
    assert own.subgoals is not None
    subgoal = own.subgoals["subgoal"]
    row, column = (pd.Series(part, dtype="Int64").mask(subgoal < 0) for part in world.cells[subgoal].T)
    names = {"environment": own.environment, "method": own.method, "seed": own.seeds, "task": own.task}
    return pd.DataFrame({**names, "row": row, "column": column, **own.subgoals})[list(SUBGOAL_COLUMNS)]


def runs_of(environment: str, method: str, letters: str, arrays: Mapping[str, np.ndarray]) -> list[Runs]:
    """Return the runs of every task from the arrays of `learn_lives`."""
    return [_runs((environment, method, task), arrays, index) for index, task in enumerate(letters)]


def _runs(names: tuple[str, str, str], arrays: Mapping[str, np.ndarray], index: int) -> Runs:
    kept = None
    if "subgoal" in arrays:
        kept = {name: arrays[name][:, index] for name in SubgoalRow._fields}
        kept["reason"] = kept["reason"].astype(str)
    return Runs(*names, arrays["seeds"], arrays["steps"][:, index], arrays["truncated"][:, index], kept)
