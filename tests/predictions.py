"""Made-up predictions: every cell has a normal distribution that is known."""

from __future__ import annotations

import numpy as np
import pandas as pd
from scipy import stats

from ptl.measures.scoring import CELL, DISTRIBUTIONS, LEVELS, PREDICTION_COLUMNS, QUANTILES, STATISTICS


def normal_predictions(cells: list[tuple[str, ...]], middle: np.ndarray, spread: np.ndarray) -> pd.DataFrame:
    """Return predictions of mean and sd, of all and of the best settings, whose cells have these distributions."""
    quantiles = middle[:, np.newaxis] + spread[:, np.newaxis] * stats.norm.ppf(LEVELS)
    frames = [
        pd.DataFrame(cells, columns=list(CELL)).assign(
            statistic=statistic,
            distribution=distribution,
            settings=100,
            **dict(zip(QUANTILES, quantiles.T, strict=True)),
        )
        for statistic in STATISTICS
        for distribution in DISTRIBUTIONS
    ]
    return pd.concat(frames, ignore_index=True)[list(PREDICTION_COLUMNS)]
