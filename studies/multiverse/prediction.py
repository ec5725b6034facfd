"""Predictions of the article's tables 1 to 6, which we have not seen, from the settings that were drawn.

Each setting gives every cell a distribution of what 30 runs in it would print; a prediction is the mixture of these
over settings. Choices (ours):

* With mean m and standard deviation s of n runs of a setting, a mean of 30 further runs is m + s √(1/30 + 1/n) t, where
  t has Student's distribution with n − 1 degrees of freedom: the sampling error of the 30 and the estimation error of
  the n runs. This is exact for normal values. Steps and episodes are positive and skewed, so their error is taken on
  the scale of logarithms (m exp(s √(1/30 + 1/n) t / m)), that of a transfer ratio on the logarithms of 1 − m.
* A standard deviation of 30 further runs is s √F, where F has the F-distribution with 29 / `TAILS` and (n − 1) /
  `TAILS` degrees of freedom; both errors again. Normal values would need 29 and n − 1, but steps have heavy tails, and
  the variance of a variance grows with kurtosis − 1: the degrees of freedom are those of exponential values, to which
  long first episodes come near. Still heavier tails (rare late failures) make this too narrow, and regular learning
  (total performance) makes it too wide: the predictions of deviations are less reliable than those of means.
* A ratio of means takes the means of method and base as independent.
* A run that never reaches the threshold counts with all its episodes; the article may have counted otherwise.

A setting's distribution is given by `POINTS` of its quantiles, so nothing is drawn at random but the pairs of two means
in a ratio.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy import stats

from ptl.claims.reading import ARTICLE_RUNS, DEFAULT, TRANSFER_TASKS
from ptl.errors import UserError
from ptl.files.atomic import write_text
from ptl.files.csv import write_csv
from ptl.files.regular import sha256
from ptl.measures.measures import BASE, BY_NAME, MEASURES, Measure
from ptl.measures.scoring import CELL, CONDITIONAL, LEVELS, MEAN, PREDICTION_COLUMNS, PRIOR, SD
from ptl.measures.statistics import named_generator
from ptl.report.table_kinds import KINDS
from ptl.text import number, percent
from studies.multiverse.shares import BEST, best_weights, drawn, held

POINTS = 40
"""Points of the distribution of a setting, each with the same probability."""

TAILS = 4.0
"""Variance of the variance of exponential values (kurtosis 9), relative to that of normal ones (kurtosis 3)."""

ALSO = {"transfer": ("first_episode",)}
"""Measures beyond those of a kind of table: the article may print first episodes instead of their savings."""

ROUNDING = 1e-9
"""Tolerance of sums of weights."""

CENTRES = (np.arange(POINTS) + 0.5) / POINTS
NAME, PAGE = "predictions.csv", "README.md"


class Cell(NamedTuple):
    """A cell of the tables; the fields are `ptl.measures.scoring.CELL`."""

    table: int
    environment: str
    task: str
    method: str
    measure: str


def cells(environments: Sequence[str], methods: Sequence[str]) -> Iterator[Cell]:
    """Yield the cells of all tables, two for each environment; comparisons of the base with itself are left out."""
    tables = [(environment, kind) for environment in environments for kind in KINDS]
    for table, (environment, kind) in enumerate(tables, start=1):
        own = [measure for measure in MEASURES if measure.table == kind or measure.name in ALSO.get(kind, ())]
        for task in TRANSFER_TASKS:
            for method in methods:
                for measure in own:
                    if not (method == BASE and measure.saves):
                        yield Cell(table, environment, task, method, measure.name)


# -- settings ------------------------------------------------------------------------------------------------------


def prior_weights(estimates: pd.DataFrame) -> pd.Series:
    """Return the weight of each drawn setting by its name; all are equal."""
    names = drawn(estimates)["setting"].unique()
    if not len(names):
        raise UserError("multiverse, predictions: no setting was drawn; learn the settings first")
    return pd.Series(1 / len(names), index=names)


def shares_of_claims(verdicts: pd.DataFrame) -> pd.Series:
    """Return the share of claims that hold in each drawn setting, among those that are decided in it.

    Claims are read strictly, on task F where they leave the task open, with the default tolerance and, for "not
    significant", at the article's number of runs (`studies.multiverse.shares.reading_of`).
    """
    return held(drawn(verdicts), DEFAULT.tasks).mean(axis=1).dropna()


def conditional_weights(verdicts: pd.DataFrame) -> pd.Series:
    """Return the weight of each drawn setting: equal in the best `BEST` by the share of claims that hold, else 0.

    Settings of the share at the edge have equal parts of the weight that is left.
    """
    shares = shares_of_claims(verdicts)
    if shares.empty:
        raise UserError("multiverse, predictions: no claim is decided in a drawn setting; judge the settings first")
    weights = best_weights(shares)
    return weights / weights.sum()


# -- distributions of one setting ----------------------------------------------------------------------------------


def mean_points(measure: str, means: np.ndarray, deviations: np.ndarray, runs: np.ndarray) -> np.ndarray:
    """Return points of the distribution of a mean of 30 runs in each setting, float array (settings, `POINTS`).

    Parameters
    ----------
    measure : str
        Decides the scale of the error.
    means, deviations, runs : arrays (settings,)
        Estimates of the settings, and the number of runs behind them.
    """
    student = _by_runs(runs, lambda own: stats.t.ppf(CENTRES, own - 1))
    errors = (deviations * np.sqrt(1 / ARTICLE_RUNS + 1 / runs))[:, np.newaxis] * student
    middle = means[:, np.newaxis]
    if measure == "transfer_ratio":
        return 1 - (1 - middle) * np.exp(-errors / (1 - middle))
    if BY_NAME[measure].saves:
        return middle + errors
    return middle * np.exp(errors / middle)


def deviation_points(deviations: np.ndarray, runs: np.ndarray) -> np.ndarray:
    """Return points of the distribution of a standard deviation of 30 runs, float array (settings, `POINTS`)."""
    factors = _by_runs(runs, lambda own: np.sqrt(stats.f.ppf(CENTRES, (ARTICLE_RUNS - 1) / TAILS, (own - 1) / TAILS)))
    return deviations[:, np.newaxis] * factors


def _by_runs(runs: np.ndarray, points: Callable[[int], np.ndarray]) -> np.ndarray:
    numbers, places = np.unique(runs, return_inverse=True)
    return np.array([points(own) for own in numbers])[places]


# -- predictions ---------------------------------------------------------------------------------------------------


def predict(
    estimates: pd.DataFrame, verdicts: pd.DataFrame, environments: Sequence[str], methods: Sequence[str]
) -> pd.DataFrame:
    """Predict mean and standard deviation of 30 runs in every cell of the tables.

    Parameters
    ----------
    estimates, verdicts : DataFrame
        Columns `studies.multiverse.judging.ESTIMATE_COLUMNS` and ``VERDICT_COLUMNS``; settings that were not drawn are
        left out.
    environments, methods : sequence of str
        In the order of the tables and of their rows.

    Returns
    -------
    DataFrame
        Columns `ptl.measures.scoring.PREDICTION_COLUMNS`. A cell that was learned in a part of the settings is
        predicted from that part.

    Raises
    ------
    UserError
        If a cell was learned in no setting.
    """
    weights = {PRIOR: prior_weights(estimates), CONDITIONAL: conditional_weights(verdicts)}
    cloud = drawn(estimates)
    groups = {
        tuple(map(str, names)): part.set_index("setting")[["mean", "sd", "seeds"]]
        for names, part in cloud[cloud["sd"].notna()].groupby(["environment", "tasks", "method", "measure"], sort=False)
    }
    rows: list[tuple[object, ...]] = []
    for cell in cells(environments, methods):
        for statistic, points in _points(cell, groups).items():
            for distribution, all_weights in weights.items():
                own = all_weights.reindex(points.index).fillna(0.0)
                used = own > 0
                if not used.any():
                    raise _nowhere(
                        cell.environment, cell.task, cell.method, cell.measure, f"of the {distribution} distribution"
                    )
                quantiles = _quantiles(points[used].to_numpy(), own[used].to_numpy())
                rows.append((*cell, statistic, distribution, int(used.sum()), *quantiles))
    return pd.DataFrame(rows, columns=list(PREDICTION_COLUMNS))


def _points(cell: Cell, groups: Mapping[tuple[str, ...], pd.DataFrame]) -> dict[str, pd.DataFrame]:
    """Return the points of mean and standard deviation of a cell, frames (settings, `POINTS`)."""
    measure = BY_NAME[cell.measure]
    if measure.function is None:
        return {MEAN: _ratio_points(cell, measure, groups)}
    frame = _group(groups, cell, cell.method, cell.measure)
    return {
        MEAN: _mean_frame(cell.measure, frame),
        SD: pd.DataFrame(deviation_points(frame["sd"].to_numpy(), frame["seeds"].to_numpy()), index=frame.index),
    }


def _ratio_points(cell: Cell, measure: Measure, groups: Mapping[tuple[str, ...], pd.DataFrame]) -> pd.DataFrame:
    own, base = (_mean_frame(measure.saves, _group(groups, cell, name, measure.saves)) for name in (cell.method, BASE))
    both = own.index.intersection(base.index, sort=False)
    random = named_generator("multiverse", "predictions", *cell)
    paired = random.permuted(base.loc[both].to_numpy(), axis=1)
    return measure.factor * (paired - own.loc[both]) / paired


def _group(groups: Mapping[tuple[str, ...], pd.DataFrame], cell: Cell, method: str, measure: str) -> pd.DataFrame:
    names = (cell.environment, cell.task, method, measure)
    if names not in groups:
        raise _nowhere(*names)
    return groups[names]


def _nowhere(environment: str, task: str, method: str, measure: str, of: str = "drawn") -> UserError:
    """Return the error of a cell without a setting."""
    return UserError(
        f"multiverse, predictions: {environment} {task} {method} {measure}: learned in no setting {of}; draw more"
        f" settings, or lower methods.{method}.every"
    )


def _mean_frame(measure: str, frame: pd.DataFrame) -> pd.DataFrame:
    values = (frame[name].to_numpy(dtype=float) for name in ("mean", "sd", "seeds"))
    return pd.DataFrame(mean_points(measure, *values), index=frame.index)


def _quantiles(points: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Return the quantiles of a mixture at `LEVELS`; ``points`` (settings, points) have the weights of their settings.

    A quantile is the smallest point up to which the weights add up to its level, to within rounding.
    """
    values = points.ravel()
    order = np.argsort(values)
    reached = np.cumsum(np.repeat(weights, points.shape[1])[order])
    return values[order[np.searchsorted(reached, (LEVELS - ROUNDING) * reached[-1])]]


# -- files ---------------------------------------------------------------------------------------------------------


def write_predictions(predictions: pd.DataFrame, verdicts: pd.DataFrame, folder: Path) -> None:
    """Write predictions (columns `PREDICTION_COLUMNS`) and the page with their digest; no date enters the files."""
    write_csv(predictions, folder / NAME)
    write_text(folder / PAGE, page(predictions, verdicts, sha256(folder / NAME)))


def page(predictions: pd.DataFrame, verdicts: pd.DataFrame, digest: str) -> str:
    """Return the page on the predictions, Markdown."""
    settings = predictions.groupby("distribution")["settings"].agg(["min", "max"])
    shares = shares_of_claims(verdicts)
    edge = shares[conditional_weights(verdicts) > 0].min()
    number_of_cells = len(predictions[list(CELL)].drop_duplicates())
    return f"""\
# Predictions of tables 1 to 6

The article's tables exist in print; we have not seen them. `{NAME}` predicts each of their
{number(number_of_cells)} cells: mean and standard deviation (sd) over {ARTICLE_RUNS} runs, by the quantiles from 1
to 99% (`q01` to `q99`).

    sha256 {digest}

The date of the predictions is that of the commit that brought these bytes: `git log --format=%cs -- {NAME}`.
It is not in the files, so that a rerun gives the same bytes and the same digest (`sha256sum {NAME}`).

Do you have the article? Type its tables in and score them:

    ptl score --template printed.csv
    ptl score printed.csv

## What is predicted

* `prior`: all settings that were drawn, with equal weights ({_span(settings.loc[PRIOR])} settings a cell).
* `conditional`: the {percent(BEST)} of the settings in which most of the article's claims hold, {percent(edge)} or more
  of those decided in a setting; settings of this share fill up the rest with equal parts of their weight
  ({_span(settings.loc[CONDITIONAL])} settings a cell). Claims are read strictly, on task {DEFAULT.tasks} where they
  leave the task open, with a tolerance of {DEFAULT.tolerance} step, and as of {ARTICLE_RUNS} runs where they speak of
  significance.

Column `settings` is the number of settings behind a cell; some methods were learned in a part of them only.
`first_episode` is no column of our tables, but the article may print it instead of the jump start. Tasks are B to F.

## How

Each setting gives a distribution of what {ARTICLE_RUNS} runs would print, and a prediction is the mixture over
settings. The error of a mean is that of {ARTICLE_RUNS} runs and that of the setting's own runs together (Student's t;
on the scale of logarithms for steps, episodes and 1 − transfer ratio), the error of a standard deviation that of both
(F-distribution, with the degrees of freedom of exponential values rather than normal ones).

## Weaknesses

* The errors of means are exact for normal values only, and somewhat too small for skewed ones.
* Standard deviations follow the tails of the values. Rare failures late in a task have heavier tails than is assumed
  here (the ranges are too narrow, mostly for asymptotic performance), totals have lighter ones (too wide).
* Ratios of means (`jump_start_percent`, `transfer_ratio_of_means`) take method and base as independent, and have no
  sd.
* A run that never reaches the threshold counts with all its episodes. The article may have counted otherwise.
* The conditional prediction uses sentences of the article about the same tables. The prior does not, but the ranges
  of some unknowns were chosen with the article's text in view; each range has its reason in
  `studies/multiverse/config/multiverse.yaml`.
* Maps, ranges of the unknowns and rivals for the method are our choice. What lies outside of them is not predicted.
"""


def _span(row: pd.Series) -> str:
    low, high = int(row["min"]), int(row["max"])
    return number(low) if low == high else f"{number(low)} to {number(high)}"
