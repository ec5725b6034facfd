"""The first page of the report: the question, the verdicts, and the main result."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd

from ptl.report.templating import render
from ptl.study.claims.verdict import Verdict
from ptl.study.measures import BASE
from ptl.study.sample_size import note
from ptl.text import estimate


def compose(
    claims: pd.DataFrame,
    metrics: pd.DataFrame,
    titles: Mapping[str, str],
    tasks: Mapping[str, str],
    labels: Mapping[str, str],
) -> str:
    """Compose the page as reStructuredText.

    Parameters
    ----------
    claims : DataFrame
        Columns id, verdict, verdict_30.
    metrics : DataFrame
        The table of estimates.
    titles, tasks : mapping
        Title and tasks of each environment. One with a single task is left out of the main table, because nothing is
        transferred in a first task.
    labels : mapping
        Name of each method as readers see it.
    """
    counts, few = (claims[column].value_counts() for column in ("verdict", "verdict_30"))
    last_tasks = {name: letters[-1] for name, letters in tasks.items() if len(letters) > 1}
    seeds = int(metrics["seeds"].max())
    chosen = metrics[metrics["metric"] == "transfer_ratio"].set_index(["environment", "task", "method"])
    return render(
        "front_page.rst",
        claims=len(claims),
        counts=[(counts[verdict], verdict) for verdict in map(str, Verdict) if verdict in counts],
        few=[(few[verdict], verdict) for verdict in map(str, Verdict) if verdict in few],
        failing=list(claims.loc[claims["verdict"] == str(Verdict.NOT), "id"]),
        seeds=seeds,
        with_interval=note(seeds, "its interval"),
        heads=[f"{titles[name]}, task {task}" for name, task in last_tasks.items()],
        rows=[
            (label, [_ratio(chosen, (name, task, method)) for name, task in last_tasks.items()])
            for method, label in labels.items()
            if method != BASE
        ],
    )


def _ratio(chosen: pd.DataFrame, place: tuple[str, str, str]) -> str:
    if place not in chosen.index:
        return "not in this run"
    row = chosen.loc[place]
    return "no base in this run" if pd.isna(row["mean"]) else estimate(row["mean"], row["ci_low"], row["ci_high"])
