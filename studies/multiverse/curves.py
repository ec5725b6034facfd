"""The headline estimates in every drawn setting, and the unknowns that they depend on."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from scipy import stats

from ptl.claims.comparisons import PTL
from ptl.claims.reading import LAST_TASK, TRANSFER_TASKS
from ptl.measures.measures import BASE
from ptl.world.drawing import KINDS
from studies.multiverse.design import EVERY, Unknown

HEADLINES = ("jump_start", "transfer_ratio", "threshold_episode")
"""Estimates with a specification curve: % of the first episode saved, % of all steps saved, episodes to threshold."""

SAVED = {"jump_start": "first_episode", "transfer_ratio": "total_steps"}
Z = stats.norm.ppf(0.975)

CLAIMED: dict[tuple[str, str], tuple[float, float]] = {
    ("jump_start", "env1"): (80, 90),
    ("transfer_ratio", "env1"): (90, 100),
    ("jump_start", "env3"): (-np.inf, 20),
    ("transfer_ratio", "env3"): (50, 100),
    ("threshold_episode", "env1"): (60, 100),
}
"""Range of an estimate that the article states, as the claims read it (`ptl.claims.thresholds`)."""


def curve_frame(estimates: pd.DataFrame) -> pd.DataFrame:
    """Return the headline estimates of PTL in every setting.

    Savings are ratios of means in % of the base; their intervals are those of the delta method.

    Returns
    -------
    DataFrame
        Columns setting, environment, tasks (F and BCDEF), headline, value, low, high.
    """
    table = estimates[estimates["method"].isin((PTL, BASE)) & estimates["tasks"].isin((LAST_TASK, TRANSFER_TASKS))]
    wide = table.pivot(
        index=["setting", "environment", "tasks"], columns=["method", "measure"], values=["mean", "sd", "seeds"]
    )
    parts = []
    for headline in HEADLINES:
        if headline in SAVED:
            own, base = (_mean_and_error(wide, method, SAVED[headline]) for method in (PTL, BASE))
            ratio = own[0] / base[0]
            value = 100 * (1 - ratio)
            error = 100 * ratio * np.hypot(own[1] / own[0], base[1] / base[0])
        else:
            value, error = _mean_and_error(wide, PTL, headline)
            number = wide.index.get_level_values("tasks").str.len()
            value, error = value / number, error / number
        frame = pd.DataFrame(
            {"headline": headline, "value": value, "low": value - Z * error, "high": value + Z * error}
        )
        parts.append(frame.dropna().reset_index())
    return pd.concat(parts, ignore_index=True)


def _mean_and_error(wide: pd.DataFrame, method: str, measure: str) -> tuple[pd.Series, pd.Series]:
    mean, deviation, seeds = (wide[name, method, measure] for name in ("mean", "sd", "seeds"))
    return mean, deviation / np.sqrt(seeds)


def association_table(
    frame: pd.DataFrame, changes: Mapping[str, Mapping[str, Any]], unknowns: Mapping[str, Unknown]
) -> pd.DataFrame:
    """Return how strongly each estimate depends on each unknown.

    Ranked unknowns: Spearman's correlation; others: the square root of Kruskal and Wallis's share of variance of ranks.

    Returns
    -------
    DataFrame
        Columns environment, tasks, headline, unknown, association, p_value; strongest first.
    """
    rows = []
    for names, part in frame.groupby(["environment", "tasks", "headline"], sort=False):
        for name, unknown in unknowns.items():
            if not _enters(name, str(names[0])):
                continue
            values = [changes[setting][name] for setting in part["setting"]]
            rows.append((*names, name, *_association(values, part["value"].to_numpy(), unknown)))
    table = pd.DataFrame(rows, columns=["environment", "tasks", "headline", "unknown", "association", "p_value"])
    strength = table["association"].abs()
    order = table.assign(strength=strength).sort_values("strength", ascending=False, kind="stable").index
    return table.loc[order].sort_values(["environment", "tasks", "headline"], kind="stable").reset_index(drop=True)


def _enters(unknown: str, environment: str) -> bool:
    """Return whether an unknown can matter in an environment: drawings of other maps cannot."""
    first, second = unknown.split(".")[:2]
    return second not in KINDS or first in (environment, EVERY)


def _association(values: list[Any], score: np.ndarray, unknown: Unknown) -> tuple[float, float]:
    if unknown.numeric:
        result = stats.spearmanr(values, score)
        return float(result.statistic), float(result.pvalue)
    samples = [score[[value == option for value in values]] for option in unknown.options]
    samples = [sample for sample in samples if len(sample)]
    if len(samples) < 2:
        return 0.0, 1.0
    result = stats.kruskal(*samples)
    return float(np.sqrt(min(1.0, result.statistic / (len(score) - 1)))), float(result.pvalue)


MOST_LEVELS = 6
"""Maximum number of values of an unknown that are told apart."""


def levels(values: list[Any], unknown: Unknown) -> tuple[list[str], np.ndarray]:
    """Return the levels of an unknown and each setting's, int (settings,): its values, or thirds of them if many."""
    few = sorted(set(values)) if unknown.numeric else list(unknown.options)
    if len(few) <= MOST_LEVELS or not unknown.numeric:
        return [_text(value) for value in few], np.array([few.index(value) for value in values])
    numbers = np.array(values, dtype=float)
    return ["low", "middle", "high"], np.searchsorted(np.quantile(numbers, [1 / 3, 2 / 3]), numbers, side="left")


def _text(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return ", ".join(map(str, value)) if isinstance(value, list | tuple) else str(value).replace("_", " ")
