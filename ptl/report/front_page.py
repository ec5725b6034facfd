"""The first page: the question, the verdicts and the main result, for Snakemake's report and as a separate page."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pandas as pd

from ptl.claims.verdict import Verdict
from ptl.measures.measures import BASE
from ptl.measures.sample_size import note
from ptl.report.ledger import CLASSES, FITTED
from ptl.report.templating import render
from ptl.text import estimate


def compose(
    claims: pd.DataFrame | None,
    metrics: pd.DataFrame,
    titles: Mapping[str, str],
    tasks: Mapping[str, str],
    labels: Mapping[str, str],
) -> str:
    """Compose the page as reStructuredText.

    Parameters
    ----------
    claims : DataFrame or None
        Columns id, verdict, verdict_30; None for a run that is not about the article.
    metrics : DataFrame
        The table of estimates.
    titles, tasks : mapping
        Title and tasks of each environment. One with a single task is left out of the main table, because nothing is
        transferred in a first task.
    labels : mapping
        Name of each method as readers see it.
    """
    return render("front_page.rst", **_facts(claims, metrics, titles, tasks, labels))


def compose_page(
    claims: pd.DataFrame | None,
    metrics: pd.DataFrame,
    titles: Mapping[str, str],
    tasks: Mapping[str, str],
    labels: Mapping[str, str],
    figures: Mapping[str, tuple[str, str]],
    tables: Mapping[str, str],
) -> str:
    """Compose ``index.html``, which shows the products in its folder: the first page, all figures, links to the tables.

    Parameters
    ----------
    claims, metrics, titles, tasks, labels
        See `compose`.
    figures : mapping
        Title and caption of each figure, by the name of its files.
    tables : mapping
        Title of each table, by the name of its files.
    """
    rows = [] if claims is None else claims.to_dict("records")
    kinds = {str(verdict): kind for verdict, kind in CLASSES.items()}
    return render(
        "index.html",
        title="Partial transfer learning" + (": a reproduction" if rows else " study"),
        claims=[{**row, "kind": kinds[row["verdict"]]} for row in rows],
        figures=[(name, title, caption) for name, (title, caption) in figures.items()],
        tables=list(tables.items()),
        **_facts(claims, metrics, titles, tasks, labels),
    )


def _facts(
    claims: pd.DataFrame | None,
    metrics: pd.DataFrame,
    titles: Mapping[str, str],
    tasks: Mapping[str, str],
    labels: Mapping[str, str],
) -> dict[str, Any]:
    """Return the contents of both forms of the page."""
    article = claims is not None
    if claims is None:
        claims = pd.DataFrame(columns=["id", "verdict", "verdict_30"])
    counts, few = (claims[column].value_counts() for column in ("verdict", "verdict_30"))
    last_tasks = {name: letters[-1] for name, letters in tasks.items() if len(letters) > 1}
    seeds = int(metrics["seeds"].max())
    chosen = metrics[metrics["metric"] == "transfer_ratio"].set_index(["environment", "task", "method"])
    return {
        "article": article,
        "places": list(titles.values()),
        "total": len(claims),
        "fitted": FITTED,
        "counts": [(counts[verdict], verdict) for verdict in map(str, Verdict) if verdict in counts],
        "few": [(few[verdict], verdict) for verdict in map(str, Verdict) if verdict in few],
        "failing": list(claims.loc[claims["verdict"] == str(Verdict.NOT), "id"]),
        "seeds": seeds,
        "with_interval": note(seeds, "its interval"),
        "heads": [f"{titles[name]}, task {task}" for name, task in last_tasks.items()],
        "rows": [
            (label, [_ratio(chosen, (name, task, method)) for name, task in last_tasks.items()])
            for method, label in labels.items()
            if method != BASE
        ],
    }


def _ratio(chosen: pd.DataFrame, place: tuple[str, str, str]) -> str:
    if place not in chosen.index:
        return "not in this run"
    row = chosen.loc[place]
    return "no base in this run" if pd.isna(row["mean"]) else estimate(row["mean"], row["ci_low"], row["ci_high"])
