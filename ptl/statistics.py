"""From per-seed measures to estimates with intervals, one row for each environment, task, method and metric.

Resampling is scipy's; this module only says what is resampled and when an interval does not exist. Choices
(ours):

* Intervals of means and ratios are bias-corrected and accelerated (BCa), because step counts are strongly
  skewed. Where BCa is undefined (the estimate lies at the edge of its bootstrap distribution) the percentile
  interval of the same resamples is taken. Equal values give an interval of no width, a single value gives
  none (NaN).
* A comparison with the base is paired by seed where it is a difference or a ratio; the probability of
  improvement compares all cross pairs, as rliable does (Agarwal et al., NeurIPS 2021), and has a percentile
  interval.
* A share of seeds has a Wilson interval.
* The random stream of every number is derived from the names of that number alone, so that adding a method,
  a task or an environment to a run moves no other number.
"""

from __future__ import annotations

import hashlib
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
import pandas as pd
from scipy import stats

from ptl.errors import UserError
from ptl.files import read_csv

TRIMMED_SHARE = 0.25
"""Cut off at either end by the interquartile mean."""

Better = Literal["lower", "higher"]

PER_SEED_METRICS: dict[str, Better] = {
    "first_episode": "lower",
    "jump_start": "higher",
    "asymptotic": "lower",
    "threshold_episode": "lower",
    "total_steps": "lower",
    "transfer_ratio": "higher",
}
"""Columns of the per-seed frame that are summarised, and which direction is the better one."""

COMPARED_BY = {"jump_start": "first_episode", "transfer_ratio": "total_steps"}
"""Metrics that are 0 for the base by definition, and the metric that is compared in their place."""

RATIO_METRICS: dict[str, tuple[str, str, float]] = {
    "jump_start_percent": ("jump_start", "first_episode", 100.0),
    "transfer_ratio_of_means": ("saved_steps", "total_steps", 1.0),
}
"""Aggregates that are a ratio of two means: numerator (of the method), denominator (of the base), factor."""

COLUMNS = (
    "environment", "task", "method", "metric", "mean", "std", "ci_low", "ci_high", "n",
    "iqm", "iqm_low", "iqm_high", "reached", "improvement", "improvement_low", "improvement_high",
    "reached_low", "reached_high", "seeds",
)  # fmt: skip
"""Columns of the frame that `summarise` returns; ``n`` values out of ``seeds`` runs entered the mean."""


@dataclass(frozen=True)
class Estimate:
    """A number with the ends of its interval; all NaN where it does not exist."""

    value: float
    low: float
    high: float


UNDEFINED = Estimate(np.nan, np.nan, np.nan)


@dataclass(frozen=True)
class Resampling:
    """How intervals are made.

    Parameters
    ----------
    confidence : float
        Level of every interval, between 0 and 1.
    resamples : int
        Number of bootstrap resamples.
    """

    confidence: float = 0.95
    resamples: int = 2000

    def __post_init__(self) -> None:
        if not 0 < self.confidence < 1:
            raise UserError(f"statistics.confidence: {self.confidence} is not between 0 and 1; use e.g. 0.95")
        if self.resamples < 1:
            raise UserError(f"statistics.resamples: {self.resamples} is not positive; use e.g. 2000")


def named_generator(*names: object) -> np.random.Generator:
    """Random stream that depends on these names and on nothing else."""
    digest = hashlib.sha256("/".join(map(str, names)).encode()).digest()
    return np.random.default_rng(np.random.SeedSequence(int.from_bytes(digest, "big")))


# -- single estimates ----------------------------------------------------------------------------------------


def mean(values: np.ndarray, how: Resampling, generator: np.random.Generator) -> Estimate:
    """Mean of the values (n,) with its bootstrap interval."""
    return _bootstrap(_mean, (values,), how, generator)


def interquartile_mean(values: np.ndarray, how: Resampling, generator: np.random.Generator) -> Estimate:
    """Mean of the middle half of the values (n,) with its bootstrap interval."""
    return _bootstrap(_interquartile_mean, (values,), how, generator)


def mean_difference(
    values: np.ndarray, others: np.ndarray, how: Resampling, generator: np.random.Generator
) -> Estimate:
    """Mean of ``values - others``, both (n,) in the same order of seeds; interval paired by seed."""
    return mean(np.subtract(values, others), how, generator)


def ratio_of_means(
    numerators: np.ndarray, denominators: np.ndarray, how: Resampling, generator: np.random.Generator
) -> Estimate:
    """Mean of the numerators over the mean of the denominators, both (n,); interval paired by seed.

    This is not the mean of the ratios: a seed counts by the size of its denominator.
    """
    if np.size(denominators) and np.mean(denominators) == 0:
        return UNDEFINED
    return _bootstrap(_ratio, (numerators, denominators), how, generator, paired=True)


def probability_of_improvement(
    values: np.ndarray,
    base: np.ndarray,
    better: Better,
    how: Resampling,
    generator: np.random.Generator,
) -> Estimate:
    """P(a run is better than a run of the base) + P(both are equal) / 2, over all cross pairs.

    Parameters
    ----------
    values, base : array, shapes (n,) and (m,)
        Not paired. Infinity is a value worse or better than every number (a threshold that was never
        reached).
    better : "lower" or "higher"
        Which values are better.
    """
    # Only the order matters, and small integers compare faster (and, unlike infinities, subtract).
    ranks = stats.rankdata(np.concatenate([values, base]), method="dense").astype(np.int16)
    own, other = ranks[: np.size(values)], ranks[np.size(values) :]
    lower, upper = (own, other) if better == "lower" else (other, own)
    return _bootstrap(_probability_of_being_lower, (lower, upper), how, generator, method="percentile")


def share(count: int, total: int, how: Resampling) -> Estimate:
    """``count / total`` with its Wilson interval."""
    if total == 0:
        return UNDEFINED
    interval = stats.binomtest(count, total).proportion_ci(how.confidence, method="wilson")
    return Estimate(count / total, float(interval.low), float(interval.high))


def _mean(values: np.ndarray, axis: int = -1) -> np.ndarray:
    return np.mean(values, axis=axis)


def _interquartile_mean(values: np.ndarray, axis: int = -1) -> np.ndarray:
    return stats.trim_mean(values, TRIMMED_SHARE, axis=axis)


def _ratio(numerators: np.ndarray, denominators: np.ndarray, axis: int = -1) -> np.ndarray:
    return np.mean(numerators, axis=axis) / np.mean(denominators, axis=axis)


def _probability_of_being_lower(lower: np.ndarray, upper: np.ndarray, axis: int = -1) -> np.ndarray:
    left = np.moveaxis(lower, axis, -1)[..., :, np.newaxis]
    right = np.moveaxis(upper, axis, -1)[..., np.newaxis, :]
    wins = np.count_nonzero(left < right, axis=(-2, -1)) + np.count_nonzero(left <= right, axis=(-2, -1))
    return wins / (2 * left.shape[-2] * right.shape[-1])


def _bootstrap(
    statistic: Callable[..., np.ndarray],
    samples: tuple[np.ndarray, ...],
    how: Resampling,
    generator: np.random.Generator,
    paired: bool = False,
    method: str = "BCa",
) -> Estimate:
    samples = tuple(np.asarray(sample) for sample in samples)
    smallest = min(map(len, samples))
    if smallest == 0:
        return UNDEFINED
    value = float(statistic(*samples))
    if smallest == 1:
        return Estimate(value, np.nan, np.nan)
    if all(np.all(sample == sample[0]) for sample in samples):
        return Estimate(value, value, value)
    options = {"confidence_level": how.confidence, "paired": paired, "vectorized": True}
    with warnings.catch_warnings():
        # scipy warns where BCa is undefined and gives NaN, which is handled here
        warnings.simplefilter("ignore", stats.DegenerateDataWarning)
        warnings.filterwarnings("ignore", "invalid value encountered", RuntimeWarning)
        result = stats.bootstrap(samples, statistic, n_resamples=how.resamples, method=method, rng=generator, **options)
        low, high = result.confidence_interval
        if not (np.isfinite(low) and np.isfinite(high)):
            result = stats.bootstrap(
                samples, statistic, n_resamples=0, method="percentile", bootstrap_result=result, **options
            )
            low, high = result.confidence_interval
    return Estimate(value, float(low), float(high))


# -- all estimates of a run ----------------------------------------------------------------------------------


def read_per_seed(path: str | Path) -> pd.DataFrame:
    """Read the per-seed table that `ptl measure` wrote; names stay text, whatever they look like."""
    return read_csv(
        path,
        dtype=dict.fromkeys(("environment", "task", "method"), str),
        keep_default_na=False,
        na_values={name: [""] for name in PER_SEED_METRICS},
    )


def summarise(per_seed: pd.DataFrame, how: Resampling, base: str = "no_transfer") -> pd.DataFrame:
    """Estimates of every metric, one row for each environment, task, method and metric.

    Parameters
    ----------
    per_seed : DataFrame
        As `ptl.measures.measure_files` makes it.
    how : Resampling
    base : str
        Method that the others are compared with; without it in the frame, comparisons are left empty.

    Returns
    -------
    DataFrame
        Columns `COLUMNS`, in the order in which environments, tasks and methods first appear. The mean,
        deviation and interquartile mean of ``threshold_episode`` are over the ``n`` seeds that reached it,
        and ``reached`` is their share; in its probability of improvement a seed that never reached it is
        worse than one that did.

    Raises
    ------
    UserError
        When a column is missing, a row stands twice, or a seed of a method has no run of the base.
    """
    _check_per_seed(per_seed)
    rows: list[dict[str, object]] = []
    for (environment, task), frame in per_seed.groupby(["environment", "task"], sort=False):
        by_method = {str(name): part.set_index("seed") for name, part in frame.groupby("method", sort=False)}
        reference = by_method.get(base)
        for method, part in by_method.items():
            names = (str(environment), str(task), method)
            paired = None
            if reference is not None:
                paired = _pair(part, reference, names, base)
            for row in _method_rows(part, paired, reference, names, how, is_base=method == base):
                rows.append(dict(zip(("environment", "task", "method"), names, strict=True)) | row)
    return pd.DataFrame(rows, columns=list(COLUMNS))


def _check_per_seed(per_seed: pd.DataFrame) -> None:
    keys = ["environment", "task", "method", "seed"]
    missing = [name for name in (*keys, *PER_SEED_METRICS, "truncated") if name not in per_seed.columns]
    if missing:
        raise UserError(f"per-seed table: no column {missing[0]!r}; make it again with `ptl measure`")
    twice = per_seed[per_seed.duplicated(keys)]
    if len(twice):
        environment, task, method, seed = twice.iloc[0][keys]
        raise UserError(
            f"per-seed table: environment {environment}, task {task}, method {method}, seed {seed} stands"
            " twice; give each learning file once"
        )


def _pair(part: pd.DataFrame, reference: pd.DataFrame, names: tuple[str, str, str], base: str) -> pd.DataFrame:
    unpaired = part.index.difference(reference.index)
    if len(unpaired):
        environment, task, method = names
        raise UserError(
            f"per-seed table: environment {environment}, task {task}, method {method}, seed {unpaired[0]} has"
            f" no run of {base} to be paired with; learn that seed with {base} too"
        )
    return reference.loc[part.index]


def _method_rows(
    part: pd.DataFrame,
    paired: pd.DataFrame | None,
    reference: pd.DataFrame | None,
    names: tuple[str, str, str],
    how: Resampling,
    is_base: bool,
) -> Iterator[dict[str, object]]:
    """Rows of one method; ``reference`` is the base, ``paired`` the base at the method's seeds."""
    improvements = {}
    if reference is not None and not is_base:
        improvements = {
            metric: _improvement(part[metric], reference[metric], better, names, metric, how)
            for metric, better in PER_SEED_METRICS.items()
            if metric not in COMPARED_BY
        }
    for metric in PER_SEED_METRICS:
        row = _spread(part[metric].to_numpy(dtype=float, na_value=np.nan), names, metric, how)
        if metric == "threshold_episode":
            reached = share(int(row["n"]), len(part), how)  # type: ignore[call-overload]
            row |= {"reached": reached.value, "reached_low": reached.low, "reached_high": reached.high}
        yield row | improvements.get(COMPARED_BY.get(metric, metric), {})
    for metric, (numerator, denominator, factor) in RATIO_METRICS.items():
        row = {"metric": metric, "n": 0, "seeds": len(part)}
        if paired is not None:
            if numerator == "saved_steps":
                above = paired["total_steps"].to_numpy(float) - part["total_steps"].to_numpy(float)
            else:
                above = part[numerator].to_numpy(dtype=float, na_value=np.nan)
            below = paired[denominator].to_numpy(dtype=float)
            ratio = ratio_of_means(factor * above, below, how, named_generator(*names, metric))
            row |= {"mean": ratio.value, "ci_low": ratio.low, "ci_high": ratio.high, "n": len(part)}
        yield row
    yield _spread(part["truncated"].to_numpy(dtype=float), names, "truncated", how)


def _spread(values: np.ndarray, names: tuple[str, str, str], metric: str, how: Resampling) -> dict[str, object]:
    present = values[~np.isnan(values)]
    middle = mean(present, how, named_generator(*names, metric, "mean"))
    quartiles = interquartile_mean(present, how, named_generator(*names, metric, "iqm"))
    return {
        "metric": metric,
        "mean": middle.value,
        "std": float(np.std(present, ddof=1)) if len(present) > 1 else np.nan,
        "ci_low": middle.low,
        "ci_high": middle.high,
        "n": len(present),
        "iqm": quartiles.value,
        "iqm_low": quartiles.low,
        "iqm_high": quartiles.high,
        "seeds": len(values),
    }


def _improvement(
    values: pd.Series,
    base: pd.Series,
    better: Better,
    names: tuple[str, str, str],
    metric: str,
    how: Resampling,
) -> dict[str, object]:
    worst = np.inf if better == "lower" else -np.inf
    own, other = (series.astype(float).fillna(worst).to_numpy() for series in (values, base))
    estimate = probability_of_improvement(own, other, better, how, named_generator(*names, metric, "improvement"))
    return {
        "improvement": estimate.value,
        "improvement_low": estimate.low,
        "improvement_high": estimate.high,
    }
