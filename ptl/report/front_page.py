"""The first page: the question, the claims and the main result, for Snakemake's report and as a separate page."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import groupby
from typing import Any

import pandas as pd

from ptl.claims.degrees import CLASSES, UNDECIDED
from ptl.measures.measures import BASE
from ptl.measures.relative_steps import saved_text
from ptl.measures.sample_size import note
from ptl.report.ledger import FITTED, READINGS, STYLES, class_counts, counts_text
from ptl.report.templating import render


def compose(
    claims: pd.DataFrame | None,
    steps: pd.DataFrame | None,
    seeds: int,
    titles: Mapping[str, str],
    labels: Mapping[str, str],
    run: str,
) -> str:
    """Compose the page as reStructuredText.

    Parameters
    ----------
    claims : DataFrame or None
        Columns id, claim, class, holds_when; None for a run that is not about the article.
    steps : DataFrame or None
        As of `ptl.measures.relative_steps.relative_steps`; None for a run in which nothing is compared.
    seeds : int
        Seeds of the tables.
    titles : mapping
        Title of each environment.
    labels : mapping
        Name of each method as readers see it.
    run : str
        Name of the run, which is the title of a run that is not about the article.
    """
    return render("front_page.rst", run=run, **_facts(claims, steps, seeds, titles, labels))


def compose_page(
    claims: pd.DataFrame | None,
    steps: pd.DataFrame | None,
    seeds: int,
    titles: Mapping[str, str],
    labels: Mapping[str, str],
    run: str,
    figures: Mapping[str, tuple[str, str, bool]],
    tables: Mapping[str, str],
    caption: str = "",
) -> str:
    """Compose ``index.html``, which shows the products in its folder: the first page, all figures, links to the tables.

    Parameters
    ----------
    claims, steps, seeds, titles, labels, run
        See `compose`.
    figures : mapping
        Title and caption of each figure, by the name of its files, and whether it is small; in the order of the page.
    tables : mapping
        Title of each table, by the name of its files.
    caption : str
        Caption of the picture ``front``.
    """
    rows = [] if claims is None else claims.to_dict("records")
    rows.sort(key=lambda row: list(CLASSES).index(row["class"]))
    return render(
        "index.html",
        title="Partial transfer learning: a reproduction" if rows else run,
        claims=[{**row, "style": STYLES[row["class"]]} for row in rows],
        figures=[
            (small, [(name, title, text) for name, (title, text, _) in part])
            for small, part in groupby(figures.items(), key=lambda item: item[1][2])
        ],
        tables=list(tables.items()),
        caption=caption,
        **_facts(claims, steps, seeds, titles, labels),
    )


def _facts(
    claims: pd.DataFrame | None,
    steps: pd.DataFrame | None,
    seeds: int,
    titles: Mapping[str, str],
    labels: Mapping[str, str],
) -> dict[str, Any]:
    """Return the contents of both forms of the page."""
    names = [] if claims is None else list(claims["class"])
    heads, rows = [], []
    if steps is not None:
        shown = steps.drop_duplicates(["environment", "tasks"]).groupby("environment", sort=False)["tasks"]
        cases = [(name, tasks) for name, own in shown for tasks in dict.fromkeys((own.iloc[0], own.iloc[-1]))]
        found = {(row["environment"], row["tasks"], row["method"]): row for row in steps.to_dict("records")}
        heads = [f"{titles[name]}, {_tasks(tasks)}" for name, tasks in cases]
        rows = [
            (label, [_saved(found.get((name, tasks, method))) for name, tasks in cases])
            for method, label in labels.items()
            if method != BASE
        ]
    return {
        "article": claims is not None,
        "places": list(titles.values()),
        "total": len(names),
        "fitted": FITTED,
        "readings": READINGS,
        "counted": counts_text(names) if names else "",
        "undecided": names.count(UNDECIDED),
        "counts": [
            {"name": name, "number": count, "style": STYLES[name], "meaning": CLASSES[name]}
            for name, count in class_counts(names)
        ],
        "seeds": seeds,
        "with_interval": note(seeds, "its interval"),
        "heads": heads,
        "rows": rows,
    }


def _tasks(tasks: str) -> str:
    return f"{tasks[0]} to {tasks[-1]} together" if len(tasks) > 1 else f"{tasks} (last task)"


def _saved(row: Mapping[str, Any] | None) -> str:
    return "not in this run" if row is None else saved_text(row)
