"""The table of coverage: how far the intervals of tables 1 to 6 can be trusted."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd

from ptl.measures.coverage import METRICS
from ptl.measures.measures import BY_NAME
from ptl.report.table import Cell, Column, Row, RowGroup, Table
from ptl.text import number, percent

TOLERATED = 0.05
"""A coverage this far below the level is marked; with well-behaved values 30 runs miss it by half as much."""


def coverage_page(
    coverage: pd.DataFrame,
    runs: int,
    confidence: float,
    looks: Mapping[str, tuple[str, str]],
    titles: Mapping[str, str],
) -> Table:
    """Lay out the coverage of every mean.

    Parameters
    ----------
    coverage : DataFrame
        As `ptl.measures.coverage.coverage_table` makes it.
    runs : int
        Runs of the tables.
    looks, titles : mapping
        Label and colour of each method, title of each environment.
    """
    groups = []
    for (environment, task), part in coverage.groupby(["environment", "task"], sort=False):
        cells = part.set_index(["method", "metric"])
        rows = []
        for method in dict.fromkeys(part["method"]):
            own = [cells.loc[(method, metric)] for metric in METRICS]
            texts = [
                Cell(
                    percent(row["coverage"]) + " *" * bool(row["coverage"] < confidence - TOLERATED),
                    f"{number(row['mean'])} over {number(row['runs'])}",
                )
                for row in own
            ]
            rows.append(Row(looks[str(method)][0], texts, looks[str(method)][1]))
        groups.append(RowGroup(rows, f"{titles[str(environment)]}, task {task}", f"{environment} {task}"))
    low = coverage["coverage"] < confidence - TOLERATED
    worst = coverage.loc[coverage["coverage"].idxmin()]
    place = f"{titles[worst['environment']]}, task {worst['task']}, {looks[worst['method']][0]}"
    counts = ", ".join(
        f"{low[coverage['metric'] == metric].sum()} of {(coverage['metric'] == metric).sum()} of"
        f" {BY_NAME[metric].heading.lower()}"
        for metric in METRICS
    )
    return Table(
        title=f"Coverage of the intervals of {runs} runs",
        intro=f"Share of samples of {runs} runs, drawn from the many that decide the claims, whose"
        f" {percent(confidence)} interval contains the mean of all; in small type this mean and the number of runs. Far"
        f" below the level, marked *: {counts}.",
        corner="Method",
        columns=[Column(BY_NAME[metric].heading, "coverage") for metric in METRICS],
        groups=groups,
        notes=[
            f"Least: {percent(worst['coverage'])}, {BY_NAME[worst['metric']].heading.lower()} of {place}. Where a few"
            f" episodes in hundreds of runs make up much of a mean, most samples of {runs} have none of them, and no"
            " interval from the sample can tell. The claims are therefore judged on many runs, and here are their"
            " means.",
        ],
        group_heading="Task",
    )
