"""Printed tables against predictions: rank, coverage and continuous ranked probability score of every cell.

A prediction is a distribution given by its quantiles. `read_predictions` reads those of the cells of tables 1 to 6,
`score` compares printed values with them. Nothing is learned here, and no study is needed.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from ptl.errors import UserError
from ptl.files.tables import check_numbers, read_table
from ptl.text import number, percent

CELL = ("table", "environment", "task", "method", "measure")
"""Columns that name a cell of the tables."""

STATISTICS = MEAN, SD = ("mean", "sd")
"""What a cell prints: mean and standard deviation over the runs."""

DISTRIBUTIONS = PRIOR, CONDITIONAL = ("prior", "conditional")
"""Predictions of all settings, and of those in which most claims hold."""

KEYS = (*CELL, "statistic", "distribution")
"""Columns that name a prediction."""

LEVELS = np.arange(1, 100) / 100
"""Levels of the quantiles."""

QUANTILES = tuple(f"q{level:02d}" for level in range(1, 100))
"""Columns of the quantiles, one for each of `LEVELS`."""

PREDICTION_COLUMNS = (*KEYS, "settings", *QUANTILES)
"""Columns of predictions; ``settings`` is the number of settings behind one."""

RANGES = {50: ("q25", "q75"), 90: ("q05", "q95")}
"""Quantiles at the ends of each central range, by its level in percent."""

SCORE_COLUMNS = (
    *KEYS, "printed", "median", "low_50", "high_50", "low_90", "high_90", "rank", "inside_50", "inside_90", "crps",
)  # fmt: skip

CLOSE = 0.05
"""Difference from the nominal coverage up to which the sentences call the coverage as it should be (chosen)."""

MIN_JUDGED = 20
"""Minimum number of printed values for a statement on their coverage (chosen)."""

_WIDTHS = np.full(len(LEVELS), 0.01)
_WIDTHS[[0, -1]] = 0.015  # the first and the last quantile also stand for what is beyond


def read_predictions(path: str | Path) -> pd.DataFrame:
    """Read predictions, columns `PREDICTION_COLUMNS`.

    Raises
    ------
    UserError
        If the file cannot be read or is not a table of predictions.
    """
    frame = read_table(path, PREDICTION_COLUMNS, KEYS)[list(PREDICTION_COLUMNS)]
    check_numbers(frame, path, QUANTILES)
    check_numbers(frame, path, ["settings"], low=1)
    quantiles = frame[list(QUANTILES)].to_numpy(dtype=float)
    faults = {
        "repeats an earlier row": frame.duplicated(list(KEYS)).to_numpy(),
        "has no name in one of its first columns": frame[list(KEYS)].isna().any(axis=1).to_numpy(),
        f"has a statistic other than {' and '.join(STATISTICS)}": ~frame["statistic"].isin(STATISTICS).to_numpy(),
        f"has a distribution other than {' and '.join(DISTRIBUTIONS)}": ~frame["distribution"]
        .isin(DISTRIBUTIONS)
        .to_numpy(),
        "has quantiles that do not rise": (np.diff(quantiles) < 0).any(axis=1),
    }
    for fault, rows in faults.items():
        if rows.any():
            raise UserError(f"{path}: row {rows.argmax() + 1} {fault}; give the predictions as they were published")
    if frame.empty:
        raise UserError(f"{path}: has no prediction; give the predictions as they were published")
    return frame.astype(dict.fromkeys(QUANTILES, float))


def crps(quantiles: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return the continuous ranked probability score of values, twice the mean of the quantile losses.

    It is in the unit of the values; a smaller score is better. A forecast without spread has its absolute error.

    Parameters
    ----------
    quantiles : float array (values, levels)
        At `LEVELS`.
    values : float array (values,)
    """
    above = values[:, np.newaxis] - quantiles
    losses = np.where(above >= 0, LEVELS * above, (LEVELS - 1) * above)
    return 2 * losses @ _WIDTHS


def ranks(quantiles: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return the probability of a smaller value, from 0.005 to 0.995; values among equal quantiles have their middle.

    Parameters are as in `crps`.
    """
    below = (quantiles < values[:, np.newaxis]).sum(axis=1)
    up_to = (quantiles <= values[:, np.newaxis]).sum(axis=1)
    return ((below + up_to) / 2 + 0.5) / (len(LEVELS) + 1)


def score(printed: pd.DataFrame, predictions: pd.DataFrame) -> pd.DataFrame:
    """Compare printed values with their predictions.

    Parameters
    ----------
    printed : DataFrame
        Columns `CELL`, mean, sd; missing values are left out. See `ptl.measures.printed.read_printed`.
    predictions : DataFrame
        Columns `PREDICTION_COLUMNS`.

    Returns
    -------
    DataFrame
        Columns `SCORE_COLUMNS`, in the order of the predictions. The ends of a range are inside of it.
    """
    values = printed.melt(list(CELL), list(STATISTICS), "statistic", "printed").dropna(subset="printed")
    frame = predictions.merge(values, on=[*CELL, "statistic"], how="inner")
    quantiles, value = frame[list(QUANTILES)].to_numpy(dtype=float), frame["printed"].to_numpy(dtype=float)
    columns: dict[str, object] = {"printed": value, "median": frame["q50"]}
    for level, (low, high) in RANGES.items():
        columns |= {f"low_{level}": frame[low], f"high_{level}": frame[high]}
        columns[f"inside_{level}"] = ((frame[low] <= value) & (value <= frame[high])).astype(int)
    columns |= {"rank": ranks(quantiles, value), "crps": crps(quantiles, value)}
    return frame[list(KEYS)].assign(**columns)[list(SCORE_COLUMNS)]


def coverage(scores: pd.DataFrame) -> pd.DataFrame:
    """Return how many printed values are inside their ranges.

    Returns
    -------
    DataFrame
        Columns distribution, statistic, nominal (level of the range), cells, inside, coverage.
    """
    rows = []
    for distribution in DISTRIBUTIONS:
        for statistic in STATISTICS:
            own = scores[(scores["distribution"] == distribution) & (scores["statistic"] == statistic)]
            for level in RANGES:
                if len(own):
                    inside = int(own[f"inside_{level}"].sum())
                    rows.append((distribution, statistic, level / 100, len(own), inside, inside / len(own)))
    return pd.DataFrame(rows, columns=["distribution", "statistic", "nominal", "cells", "inside", "coverage"])


def sentences(scores: pd.DataFrame) -> tuple[str, str]:
    """Return what the scores say in two sentences, about means if any are printed, else about deviations."""
    statistic = MEAN if (scores["statistic"] == MEAN).any() else SD
    name = {MEAN: "means", SD: "standard deviations"}[statistic]
    own = scores[scores["statistic"] == statistic]
    prior, conditional = (own[own["distribution"] == distribution] for distribution in DISTRIBUTIONS)
    inside = float(prior["inside_90"].mean())
    if len(prior) < MIN_JUDGED:
        meaning = f"too few values to judge the settings by (from {MIN_JUDGED} on)"
    elif abs(inside - 0.9) <= CLOSE:
        meaning = "about as many as it should: the settings account for the spread of the printed values"
    elif inside < 0.9:
        meaning = "fewer than it should: the settings leave out something that the article did, or are too much alike"
    else:
        meaning = "more than it should: the settings differ more than is needed for the printed values"
    share = percent(round(inside, 2))
    first = f"The 90% range over all settings contains {share} of {len(prior)} printed {name}, {meaning}."
    both = prior.merge(conditional, on=list(CELL), suffixes=("", "_conditional"))
    closer = int((both["crps_conditional"] < both["crps"]).sum())
    above = int((conditional["printed"] > conditional["median"]).sum())
    second = (
        f"The settings in which most claims hold predict {closer} of {len(both)} printed {name} better (smaller CRPS)"
        f" than all settings do; {above} of {len(conditional)} are above their median, {number(len(conditional) / 2)}"
        " would be even."
    )
    return first, second


def template_rows(predictions: pd.DataFrame) -> Sequence[tuple[str, ...]]:
    """Return the names of all predicted cells in their order, each once."""
    return [tuple(row) for row in predictions[list(CELL)].drop_duplicates().itertuples(index=False)]
