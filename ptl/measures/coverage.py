"""Whether intervals of few runs keep their level: samples of as many runs, drawn from many more."""

from __future__ import annotations

import numpy as np
import pandas as pd

from ptl.measures.statistics import Resampling, mean_intervals, named_generator

SAMPLES, RESAMPLES = 500, 400
"""Samples drawn for each mean, and bootstrap resamples of each."""

METRICS = ("first_episode", "asymptotic", "total_steps")
"""Measures whose means are looked at: the steps that all others are made of."""

COLUMNS = ("environment", "task", "method", "metric", "mean", "runs", "coverage")


def coverage(values: np.ndarray, runs: int, confidence: float, generator: np.random.Generator) -> float:
    """Return the share of samples whose interval contains the mean of all values.

    Parameters
    ----------
    values : array (n,)
        One value of each of many runs, taken for all there are.
    runs : int
        Size of a sample, drawn with replacement.
    confidence : float
        Level of the intervals.
    """
    samples = generator.choice(np.asarray(values, dtype=float), size=(SAMPLES, runs))
    low, high = mean_intervals(samples, Resampling(confidence, RESAMPLES), generator)
    return float(np.mean((low <= np.mean(values)) & (np.mean(values) <= high)))


def coverage_table(per_seed: pd.DataFrame, runs: int, confidence: float) -> pd.DataFrame:
    """Return the coverage of every mean, a table with `COLUMNS`.

    Parameters
    ----------
    per_seed : DataFrame
        Many runs, as `ptl.measures.measures.measure` makes it.
    runs : int
        Runs of the tables.
    """
    rows = []
    for names, frame in per_seed.groupby(["environment", "task", "method"], sort=False):
        for metric in METRICS:
            values = frame[metric].to_numpy(dtype=float)
            generator = named_generator(*names, metric, "coverage")
            rows.append((*names, metric, values.mean(), len(values), coverage(values, runs, confidence, generator)))
    return pd.DataFrame(rows, columns=list(COLUMNS))
