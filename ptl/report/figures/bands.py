"""Mean over runs with a pointwise bootstrap interval, for drawing bands around curves."""

from __future__ import annotations

import numpy as np

from ptl.measures.sample_size import MIN_FOR_INTERVAL

STREAM = 20190501
"""Seed of the resampling; a figure is the same every time it is drawn."""


def mean_band(values: np.ndarray, confidence: float, resamples: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the mean over runs and the ends of its percentile bootstrap interval, point by point.

    Whole runs are resampled, the same ones for all points. (Tables use the BCa interval; the percentile interval is
    enough for a band and is cheap for thousands of points. Our choice.)

    Parameters
    ----------
    values : array, shape (runs, points)
    confidence : float
        Level of the interval, between 0 and 1.
    resamples : int
        Number of bootstrap resamples.

    Returns
    -------
    mean, low, high : float arrays, shape (points,)
        With fewer than `MIN_FOR_INTERVAL` runs the interval does not exist and its ends are NaN.
    """
    values = np.asarray(values, dtype=float)
    runs = len(values)
    mean = values.mean(axis=0)
    if runs < MIN_FOR_INTERVAL:
        nothing = np.full_like(mean, np.nan)
        return mean, nothing, nothing
    low, high = interval(resampling_weights(runs, resamples) @ values, confidence)
    return mean, low, high


def resampling_weights(runs: int, resamples: int) -> np.ndarray:
    """Return the share of every run in every resample, array (resamples, runs); rows add up to 1."""
    generator = np.random.default_rng(STREAM)
    return generator.multinomial(runs, np.full(runs, 1 / runs), size=resamples) / runs


def interval(resampled: np.ndarray, confidence: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the ends of the central interval along axis 0."""
    tail = (1 - confidence) / 2
    low, high = np.quantile(resampled, [tail, 1 - tail], axis=0)
    return low, high
