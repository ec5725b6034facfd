"""Measures of lifelong learning: what is kept of an old task, and what a life gains over a single-task expert.

Definitions of backward transfer and relative performance follow New et al., Lifelong Learning Metrics,
arXiv:2201.08278, and its package l2metrics. There, performance is larger if better. Here it is the inverse of the
number of steps (our choice), so that a ratio of performances is the inverse ratio of steps:

* **Backward transfer**, as a ratio: performance on a task when it is evaluated after other tasks / its performance at
  the end of its own training, the mean over the last tenth. l2metrics evaluates without learning; our methods cannot
  be stopped from learning, so that the first episode of the task that comes again is the evaluation (our choice).
* **Relative performance**: performance over the first training of a task / that of a single-task expert over as many
  episodes, mean over the tasks. The expert is `NO_TRANSFER`, which learns each task of the same map from nothing.

Besides them, with the reproduction's meaning: **jump start** and **transfer ratio**, the share of the expert's steps
that is saved in first episodes, and in all episodes, of the tasks after the first; and **relearning**, the steps of
all episodes of the first task / those when it comes again. Means over tasks are geometric too.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from ptl.measures.statistics import Estimate, Resampling
from ptl.report.table import Table
from studies.beyond.design import ARTICLE
from studies.beyond.figures import Look
from studies.beyond.maps import MAIN, RETURNING
from studies.beyond.page import EVERY, NOTE, times, wide_table
from studies.beyond.summary import BASE, NO_TRANSFER, Means

HEADINGS = {
    "jump_start": "Jump start",
    "transfer_ratio": "Transfer ratio",
    "backward_transfer": "Backward transfer",
    "relearning": "Relearning",
    "relative_performance": "Relative performance",
}
"""Label of each measure."""

COLUMNS = ("family", "method", "measure", "value", "low", "high")


def measures(tasks: pd.DataFrame, families: Sequence[str], how: Resampling) -> pd.DataFrame:
    """Return all measures of the methods that were sent back to the first task.

    Parameters
    ----------
    tasks : DataFrame
        Rows of `studies.beyond.collect.per_task`, of worlds that neither slip nor change.
    families : sequence of str
        Families over which the mean is taken, each counting alike.

    Returns
    -------
    DataFrame
        Columns family (`EVERY` for the mean over families), method, measure, value, low, high.
    """
    own = tasks[tasks["per_task"] == 0]
    again, main = own[own["sequence"] == RETURNING], own[own["sequence"].isin([MAIN, ARTICLE])]
    main = main[main["method"].isin(again["method"].unique())]
    first, last = again[again["task"] == 1], again[again["task"] == again.groupby("family")["task"].transform("max")]
    later = main[main["task"] > 1]
    rows: list[tuple[Any, ...]] = []
    for name, means in (
        ("backward_transfer", _means(_ratios(first, "last_episodes", last, "first_episode"), how)),
        ("relearning", _means(_ratios(first, "steps", last, "steps"), how)),
    ):
        for family, group in _groups(means, families).items():
            found = {method: means.cost(group, method) for method in means.methods(group)}
            rows += [(family, method, name, one.value, one.low, one.high) for method, one in found.items()]
    for name, means in (
        ("jump_start", _means(_geometric(later, "first_episode"), how)),
        ("transfer_ratio", _means(_lives(later)["steps"].sum(), how)),
        ("relative_performance", _means(_geometric(main, "steps"), how)),
    ):
        for family, group in _groups(means, families).items():
            present = means.methods(group)
            for method in present if NO_TRANSFER in present else ():
                one = means.ratio(group, method, NO_TRANSFER)
                ends = (one.value, one.high, one.low)  # the more steps, the less performance
                values = [1 / end if name == "relative_performance" else 1 - end for end in ends]
                rows.append((family, method, name, *values))
    return pd.DataFrame(rows, columns=list(COLUMNS))


def _groups(means: Means, families: Iterable[str]) -> dict[str, list[str]]:
    """Return families over which a mean is taken, by name: each one, and all of those named."""
    every = [family for family in families if family in means.families]
    return {**({EVERY: every} if every else {}), **{family: [family] for family in means.families}}


def _lives(tasks: pd.DataFrame) -> Any:
    return tasks.groupby(["family", "method", "map", "seed"], sort=False)


def _geometric(tasks: pd.DataFrame, column: str) -> pd.Series:
    """Return the geometric mean of a column over the tasks of each life."""
    logs = tasks.assign(log=np.log(tasks[column].astype(float)))
    return np.exp(_lives(logs)["log"].mean())


def _ratios(one: pd.DataFrame, column: str, other: pd.DataFrame, other_column: str) -> pd.Series:
    """Return the ratio of columns of two tasks of each life."""
    return _lives(one)[column].first().astype(float) / _lives(other)[other_column].first()


def _means(values: pd.Series, how: Resampling) -> Means:
    """Return geometric means of a number of each life, and their resamples."""
    return Means(values.rename("total_steps").reset_index().assign(optimum=1.0), how)


# -- the page ------------------------------------------------------------------------------------------------


def table(frame: pd.DataFrame, looks: Mapping[str, Look]) -> Table:
    """Lay out the measures of each method over all families of generated maps."""
    notes = (
        NOTE,
        "Jump start and transfer ratio: share of the steps of no transfer that is saved in the first episodes, and in"
        " all episodes, of the tasks after the first; below 0 more are needed.",
        "Backward transfer: steps of the last tenth of the episodes on the first task ÷ steps of the first episode when"
        " it comes again after all others. At 1 nothing is lost. Relearning: steps of all its episodes ÷ those when it"
        " comes again.",
        "Relative performance: steps of no transfer, which learns each task from nothing, ÷ steps of the method, mean"
        " over all tasks. Above 1 a method is better than this single-task expert.",
        "Backward transfer and relative performance as l2metrics defines them (New et al., arXiv:2201.08278), with"
        " performance = 1 ÷ steps; there the evaluation of an old task has no learning, here it is an episode of it.",
    )
    return wide_table(
        frame[frame["family"] == EVERY], looks, HEADINGS, "measure", "value", ("low", "high"),
        "Measures of lifelong learning",
        "Over all families of generated maps; each family: lifelong.csv.", notes,
    )  # fmt: skip


def sentence(frame: pd.DataFrame, looks: Mapping[str, Look]) -> str:
    """Say in plain words who remembers the first task, and what a library gains over an expert; empty without PTL."""
    own = frame[frame["family"] == EVERY].set_index(["measure", "method"])
    if ("backward_transfer", BASE) not in own.index:
        return ""
    back = own.loc["backward_transfer"]
    kept = [name for name in looks if name in back.index and back.loc[name, "high"] >= 1]
    listed = ", ".join(f"“{looks[name].label}”" for name in kept)
    text = f"Sent back to the first task, not clearly worse than when they left it: {listed or 'no method'}"
    lost = back.loc[BASE]
    more = Estimate(1 / lost["value"], 1 / lost["high"], 1 / lost["low"])
    text += f"; PTL’s first episode there takes {times(more)} times the steps of its last ones before"
    if ("relative_performance", BASE) in own.index:
        gain = Estimate(*own.loc[("relative_performance", BASE), ["value", "low", "high"]])
        text += f", and over all tasks an expert that learns each from nothing takes {times(gain)} times PTL’s steps"
    return f"{text}."
