"""Estimates with intervals: single ones, and those of every measure of a run.

scipy resamples; this module chooses the samples and decides when an interval is undefined. Choices (ours):

* Intervals of means and ratios are bias-corrected and accelerated (BCa), because step counts are strongly
  skewed. Where BCa is undefined (the estimate is at the edge of its bootstrap distribution) the percentile
  interval of the same resamples is taken. Equal values give an interval of no width; fewer values than
  `MIN_FOR_INTERVAL` give none (NaN).
* A comparison with the base is paired by seed where it is a difference or a ratio; the probability of
  improvement compares all cross pairs, as rliable does (Agarwal et al., NeurIPS 2021), and has a percentile
  interval.
* A share of seeds has a Wilson interval, of that many seeds or more.
* The random stream of every number is derived from the names of that number alone, so that adding a method,
  a task or an environment to a run moves no other number.
"""

from __future__ import annotations

import hashlib
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from scipy import stats

from ptl.errors import UserError
from ptl.measures.measures import BASE, BY_NAME, MEASURES, PER_SEED, PER_SEED_COLUMNS, Better, Measure
from ptl.measures.sample_size import MIN_FOR_INTERVAL

VALUES_AT_ONCE = 2**17
"""Resampled values in memory at a time; they fit the processor's cache."""

TRIMMED_SHARE = 0.25
"""Cut off at either end by the interquartile mean."""

FITS = 200
"""Maximum number of resamples of a statistic that is the outcome of a fit."""

SUMMARISED = tuple(sorted(MEASURES, key=lambda measure: (not measure.compared, measure.function is None)))
"""Measures in the order of ``metrics.csv``: those of each seed, ratios of means, the rest."""

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


def exactly(value: float) -> Estimate:
    """Return an estimate without uncertainty, for numbers that are counted."""
    return Estimate(value, value, value)


@dataclass(frozen=True)
class Resampling:
    """Settings of the intervals.

    Parameters
    ----------
    confidence : float
        Level of every interval, between 0 and 1.
    resamples : int
        Number of bootstrap resamples; with 0 every interval is its estimate, as if the runs were all there are.
    normal : bool
        Take the intervals of large samples instead, estimate and normal standard errors, without resampling.
    """

    confidence: float
    resamples: int
    normal: bool = False

    def __post_init__(self) -> None:
        if not 0 < self.confidence < 1:
            raise UserError(f"statistics.confidence: {self.confidence} is not between 0 and 1; use e.g. 0.95")
        if self.resamples < 0:
            raise UserError(f"statistics.resamples: {self.resamples} is negative; use e.g. 2000")


def named_generator(*names: object) -> np.random.Generator:
    """Return a random stream that depends on these names and on nothing else."""
    digest = hashlib.sha256("/".join(map(str, names)).encode()).digest()
    return np.random.default_rng(np.random.SeedSequence(int.from_bytes(digest, "big")))


# -- single estimates ----------------------------------------------------------------------------------------


def mean(values: np.ndarray, how: Resampling, generator: np.random.Generator) -> Estimate:
    """Return the mean of the values (n,) with its bootstrap interval."""
    return _bootstrap(_mean, (values,), how, generator)


def mean_intervals(
    samples: np.ndarray, how: Resampling, generator: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Return the ends of the bootstrap interval of the mean of each sample, two arrays (m,).

    Parameters
    ----------
    samples : array (m, n)
        Samples of n values. One draw of resamples serves all of them.
    """
    with _undefined_intervals():
        result = stats.bootstrap(
            (samples,), _mean, axis=1, confidence_level=how.confidence, n_resamples=how.resamples, rng=generator,
            batch=max(1, VALUES_AT_ONCE // samples.size),
        )  # fmt: skip
    means = np.quantile(result.bootstrap_distribution, [(1 - how.confidence) / 2, (1 + how.confidence) / 2], axis=1)
    ends = zip(result.confidence_interval, means, strict=True)
    low, high = (np.where(np.isfinite(own), own, percentile) for own, percentile in ends)
    return low, high


def mean_of_fewer(values: np.ndarray, runs: int, how: Resampling) -> Estimate:
    """Return the mean of the values (n,) with Student's interval of a mean over ``runs`` of them."""
    middle = float(np.mean(values))
    reach = stats.t.ppf((1 + how.confidence) / 2, runs - 1) * float(np.std(values, ddof=1)) / np.sqrt(runs)
    return Estimate(middle, middle - reach, middle + reach)


def interquartile_mean(values: np.ndarray, how: Resampling, generator: np.random.Generator) -> Estimate:
    """Return the mean of the middle half of the values (n,) with its bootstrap interval."""
    return _bootstrap(_interquartile_mean, (values,), how, generator)


def mean_difference(
    values: np.ndarray, others: np.ndarray, how: Resampling, generator: np.random.Generator
) -> Estimate:
    """Return the mean of ``values - others``, both (n,) in the same order of seeds; interval paired by seed."""
    return mean(np.subtract(values, others), how, generator)


def ratio_of_means(
    numerators: np.ndarray, denominators: np.ndarray, how: Resampling, generator: np.random.Generator
) -> Estimate:
    """Return the mean of the numerators over the mean of the denominators, both (n,); interval paired by seed.

    This is not the mean of the ratios: a seed counts by the size of its denominator.
    """
    if np.size(denominators) and np.mean(denominators) == 0:
        return UNDEFINED
    return _bootstrap(_ratio, (numerators, denominators), how, generator, paired=True)


def ratio_of_independent_means(
    numerators: np.ndarray, denominators: np.ndarray, how: Resampling, generator: np.random.Generator
) -> Estimate:
    """Return the mean of the numerators (n,) over that of the denominators (m,), each resampled by itself."""
    return _bootstrap(_ratio, (numerators, denominators), how, generator)


def probability_of_improvement(
    values: np.ndarray,
    base: np.ndarray,
    better: Better,
    how: Resampling,
    generator: np.random.Generator,
) -> Estimate:
    """Return P(a run is better than a run of the base) + P(both are equal) / 2, over all cross pairs.

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


def of_mean_curve(
    statistic: Callable[[np.ndarray], float], curves: np.ndarray, how: Resampling, generator: np.random.Generator
) -> Estimate:
    """Return a statistic of the mean of curves (runs, points); a normal interval from resampled runs.

    The statistic may be the outcome of a fit, so it is resampled `FITS` times at most.
    """
    value = float(statistic(curves.mean(axis=0)))
    if not how.resamples and not how.normal:
        return exactly(value)
    runs = len(curves)
    weights = generator.multinomial(runs, np.full(runs, 1 / runs), size=min(FITS, how.resamples or FITS)) / runs
    deviation = float(np.std([statistic(curve) for curve in weights @ curves], ddof=1))
    reach = float(stats.norm.ppf((1 + how.confidence) / 2)) * deviation
    return Estimate(value, value - reach, value + reach)


def share(count: int, total: int, how: Resampling) -> Estimate:
    """Return ``count / total`` with its Wilson interval."""
    if total == 0:
        return UNDEFINED
    if not how.resamples and not how.normal:
        return exactly(count / total)
    if total < MIN_FOR_INTERVAL:
        return Estimate(count / total, np.nan, np.nan)
    interval = stats.binomtest(count, total).proportion_ci(how.confidence, method="wilson")
    return Estimate(count / total, float(interval.low), float(interval.high))


def _mean(values: np.ndarray, axis: int = -1) -> np.ndarray:
    return np.mean(values, axis=axis)


def _interquartile_mean(values: np.ndarray, axis: int = -1) -> np.ndarray:
    """Return `scipy.stats.trim_mean`, to the bit but without its checks, which take most of its time."""
    values = np.moveaxis(values, axis, -1)
    number = values.shape[-1]
    cut = int(TRIMMED_SHARE * number)
    return np.partition(values, (cut, number - cut - 1), axis=-1)[..., cut : number - cut].mean(axis=-1)


def _ratio(numerators: np.ndarray, denominators: np.ndarray, axis: int = -1) -> np.ndarray:
    return np.mean(numerators, axis=axis) / np.mean(denominators, axis=axis)


def _probability_of_being_lower(lower: np.ndarray, upper: np.ndarray, axis: int = -1) -> np.ndarray:
    """Return the share of cross pairs in order, ties half, from how often each rank occurs: no pair is looked at."""
    left, right = (np.moveaxis(np.asarray(ranks), axis, -1) for ranks in (lower, upper))
    bins = int(max(left.max(), right.max())) + 1
    in_left, in_right = _occurrences(left, bins), _occurrences(right, bins)
    above = in_right[..., ::-1].cumsum(axis=-1)[..., ::-1]  # of each rank or a higher one
    wins = (in_left * (2 * above - in_right)).sum(axis=-1)
    return wins / (2 * left.shape[-1] * right.shape[-1])


def _occurrences(ranks: np.ndarray, bins: int) -> np.ndarray:
    """Return how often each of 0, 1, ... occurs in the last axis, int array (..., bins)."""
    rows = ranks.reshape(-1, ranks.shape[-1]).astype(np.int64)
    rows += np.arange(len(rows))[:, np.newaxis] * bins
    return np.bincount(rows.ravel(), minlength=bins * len(rows)).reshape(*ranks.shape[:-1], bins)


def _of_mean(values: np.ndarray) -> Iterator[np.ndarray]:
    yield values - values.mean()


def _of_ratio(numerators: np.ndarray, denominators: np.ndarray) -> Iterator[np.ndarray]:
    yield (numerators - numerators.mean() / denominators.mean() * denominators) / denominators.mean()


def _of_probability(lower: np.ndarray, upper: np.ndarray) -> Iterator[np.ndarray]:
    """Yield each value's share of won comparisons (DeLong, DeLong and Clarke-Pearson 1988), centred."""
    for own, other in ((-lower.astype(int), -upper.astype(int)), (upper.astype(int), lower.astype(int))):
        ordered = np.sort(other)
        won = (np.searchsorted(ordered, own, "left") + np.searchsorted(ordered, own, "right")) / (2 * len(other))
        yield won - won.mean()


INFLUENCES: dict[Callable[..., np.ndarray], Callable[..., Iterator[np.ndarray]]] = {
    _mean: _of_mean,
    _ratio: _of_ratio,
    _probability_of_being_lower: _of_probability,
}
"""How much each value of each sample moves a statistic, for the standard errors of large samples."""


def _large_sample(value: float, influences: list[np.ndarray], how: Resampling) -> Estimate:
    z = stats.norm.ppf((1 + how.confidence) / 2)
    reach = float(z * np.sqrt(sum(influence.var(ddof=1) / len(influence) for influence in influences)))
    return Estimate(value, value - reach, value + reach)


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
    if not how.resamples and not how.normal:
        return exactly(value)
    if smallest < MIN_FOR_INTERVAL:
        return Estimate(value, np.nan, np.nan)
    if how.normal:
        return _large_sample(value, [*INFLUENCES[statistic](*samples)], how)
    if all(np.all(sample == sample[0]) for sample in samples):
        return Estimate(value, value, value)
    # Two samples draw from the stream in turn, batch by batch; one draws the same numbers for any batches.
    batch = max(1, VALUES_AT_ONCE // smallest) if paired or len(samples) == 1 else None
    options = {"confidence_level": how.confidence, "paired": paired, "vectorized": True, "batch": batch}
    with _undefined_intervals():
        result = stats.bootstrap(samples, statistic, n_resamples=how.resamples, method=method, rng=generator, **options)
        low, high = result.confidence_interval
        if not (np.isfinite(low) and np.isfinite(high)):
            result = stats.bootstrap(
                samples, statistic, n_resamples=0, method="percentile", bootstrap_result=result, **options
            )
            low, high = result.confidence_interval
    return Estimate(value, float(low), float(high))


@contextmanager
def _undefined_intervals() -> Iterator[None]:
    """Silence scipy where BCa is undefined and gives NaN, for a block that handles NaN."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", stats.DegenerateDataWarning)
        warnings.filterwarnings("ignore", "invalid value encountered", RuntimeWarning)
        yield


# -- all estimates of a run ----------------------------------------------------------------------------------

Names = tuple[str, str, str]
"""Environment, task and method."""


def summarise(per_seed: pd.DataFrame, how: Resampling) -> pd.DataFrame:
    """Estimate every measure for each environment, task and method.

    Parameters
    ----------
    per_seed : DataFrame
        As `ptl.measures.measures.measure` makes it. Comparisons are left empty where no run of the base is in it.
    how : Resampling

    Returns
    -------
    DataFrame
        Columns `COLUMNS`, in the order in which environments, tasks and methods first appear. Mean, deviation and
        interquartile mean of a measure that runs can miss (the time to threshold) are over the ``n`` seeds that have
        a value, and ``reached`` is their share; in its probability of improvement a seed without a value is worse
        than one with a value.

    Raises
    ------
    UserError
        When a column is missing, a row is duplicated, or a seed of a method has no run of the base.
    """
    _check_per_seed(per_seed)
    rows: list[dict[str, object]] = []
    for (environment, task), frame in per_seed.groupby(["environment", "task"], sort=False):
        by_method = {str(name): part.set_index("seed") for name, part in frame.groupby("method", sort=False)}
        for method, part in by_method.items():
            names = (str(environment), str(task), method)
            labels = dict(zip(("environment", "task", "method"), names, strict=True))
            rows.extend(labels | row for row in _estimates(part, by_method.get(BASE), names, how))
    return pd.DataFrame(rows, columns=list(COLUMNS))


def _check_per_seed(per_seed: pd.DataFrame) -> None:
    for name in PER_SEED_COLUMNS:
        if name not in per_seed:
            raise UserError(f"per-seed table: no column {name!r}; measure the learning files again")
    keys = ["environment", "task", "method", "seed"]
    twice = per_seed[per_seed.duplicated(keys)]
    if len(twice):
        environment, task, method, seed = twice.iloc[0][keys]
        raise UserError(
            f"per-seed table: environment {environment}, task {task}, method {method}, seed {seed} is there twice;"
            " give each learning file once"
        )


def _estimates(
    part: pd.DataFrame, base: pd.DataFrame | None, names: Names, how: Resampling
) -> Iterator[dict[str, object]]:
    """Yield the row of each measure; ``part`` and ``base`` are the runs of the method and of the base by seed."""
    paired = None if base is None else _paired(part, base, names)
    improvements = {}
    if base is not None and names[-1] != BASE:
        compared = {measure.compared_by: BY_NAME[measure.compared_by] for measure in PER_SEED if measure.compared}
        improvements = {name: _improvement(part, base, measure, names, how) for name, measure in compared.items()}
    for measure in SUMMARISED:
        label = {"metric": measure.name, "seeds": len(part)}
        if measure.function is None:
            yield label | _ratio_of_means(part, paired, measure, names, how)
        else:
            row = _spread(part[measure.name].to_numpy(dtype=float, na_value=np.nan), (*names, measure.name), how)
            if measure.can_miss:
                reached = share(row["n"], len(part), how)
                row |= {"reached": reached.value, "reached_low": reached.low, "reached_high": reached.high}
            yield label | row | (improvements.get(measure.compared_by, {}) if measure.compared else {})


def _paired(part: pd.DataFrame, base: pd.DataFrame, names: Names) -> pd.DataFrame:
    unpaired = part.index.difference(base.index)
    if len(unpaired):
        environment, task, method = names
        raise UserError(
            f"per-seed table: environment {environment}, task {task}, method {method}, seed {unpaired[0]} has no run of"
            f" {BASE} to be paired with; learn that seed with {BASE} too"
        )
    return base.loc[part.index]


def _spread(values: np.ndarray, names: tuple[str, ...], how: Resampling) -> dict[str, Any]:
    present = values[~np.isnan(values)]
    middle = mean(present, how, named_generator(*names, "mean"))
    quartiles = interquartile_mean(present, how, named_generator(*names, "iqm"))
    return {
        "mean": middle.value,
        "std": float(np.std(present, ddof=1)) if len(present) > 1 else np.nan,
        "ci_low": middle.low,
        "ci_high": middle.high,
        "n": len(present),
        "iqm": quartiles.value,
        "iqm_low": quartiles.low,
        "iqm_high": quartiles.high,
    }


def _ratio_of_means(
    part: pd.DataFrame, paired: pd.DataFrame | None, measure: Measure, names: Names, how: Resampling
) -> dict[str, object]:
    if paired is None:
        return {"n": 0}
    own, base = (frame[measure.saves].to_numpy(dtype=float) for frame in (part, paired))
    saved = part[measure.difference].to_numpy(dtype=float) if measure.difference else base - own
    ratio = ratio_of_means(measure.factor * saved, own + saved, how, named_generator(*names, measure.name))
    return {"mean": ratio.value, "ci_low": ratio.low, "ci_high": ratio.high, "n": len(part)}


def _improvement(
    part: pd.DataFrame, base: pd.DataFrame, measure: Measure, names: Names, how: Resampling
) -> dict[str, object]:
    worst = np.inf if measure.better == "lower" else -np.inf
    own, other = (frame[measure.name].to_numpy(dtype=float, na_value=worst) for frame in (part, base))
    generator = named_generator(*names, measure.name, "improvement")
    estimate = probability_of_improvement(own, other, measure.better, how, generator)
    return {"improvement": estimate.value, "improvement_low": estimate.low, "improvement_high": estimate.high}
