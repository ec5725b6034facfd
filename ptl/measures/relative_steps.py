"""Total steps of each method relative to those without transfer, on each task and on all later tasks together."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd

from ptl.measures.measures import BASE
from ptl.measures.statistics import Resampling, named_generator, ratio_of_independent_means
from ptl.text import estimate

COLUMNS = ("environment", "tasks", "method", "ratio", "low", "high", "seeds", "base_seeds", "confidence")


def relative_steps(per_seed: pd.DataFrame, tasks: Mapping[str, str], how: Resampling) -> pd.DataFrame:
    """Estimate the mean total steps of each method over those of the base.

    The runs of two methods are independent, so their means are resampled independently.

    Parameters
    ----------
    per_seed : DataFrame
        Columns environment, task, method, seed and total_steps.
    tasks : mapping
        Letters of the tasks of each environment in the order of learning. The first has nothing to transfer and is left
        out, as are environments without other tasks.
    how : Resampling

    Returns
    -------
    DataFrame
        Columns `COLUMNS`. First all tasks together ("BCDEF", where there are several; steps are added up seed by
        seed), then each; methods that lack one of them are left out there.
    """
    totals = per_seed.pivot(index=["environment", "method", "seed"], columns="task", values="total_steps")
    compared = [method for method in dict.fromkeys(per_seed["method"]) if method != BASE]
    rows = []
    for environment, letters in tasks.items():
        later = letters[1:]
        for chosen in dict.fromkeys([later, *later]) if later else ():
            sums = {
                str(method): part[list(chosen)].astype(float).sum(axis=1, skipna=False).dropna().to_numpy()
                for method, part in totals.loc[environment].groupby("method")
            }
            base = sums.get(BASE, [])
            for method in compared:
                own = sums.get(method, [])
                if len(own) and len(base):
                    generator = named_generator(environment, chosen, method, "relative_steps")
                    found = ratio_of_independent_means(own, base, how, generator)
                    numbers = (found.value, found.low, found.high, len(own), len(base), how.confidence)
                    rows.append((environment, chosen, method, *numbers))
    return pd.DataFrame(rows, columns=list(COLUMNS))


def saved_percent(row: Mapping[str, float]) -> tuple[float, float, float]:
    """Return the steps saved in % of the base, with the ends of the interval, from a row of `relative_steps`."""
    value, high, low = (100 * (1 - row[name]) for name in ("ratio", "low", "high"))
    return value, low, high


def saved_text(row: Mapping[str, float]) -> str:
    """Return the steps saved in % of the base; of a method with more than twice its steps, how many times as many."""
    if row["ratio"] > 2:
        return estimate(row["ratio"], row["low"], row["high"], "times as many")
    return estimate(*saved_percent(row), "%")
