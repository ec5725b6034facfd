"""Tables 1 to 6: two for each environment, from the estimates of every measure.

As in the article, one table has jump start, asymptotic performance and time to threshold, the other total performance
and transfer ratio. Mean and standard deviation are the article's form; the interval of the mean and the probability of
improvement are ours.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from ptl.errors import UserError
from ptl.measures.measures import BASE, MEASURES
from ptl.measures.sample_size import MIN_FOR_INTERVAL
from ptl.report import table
from ptl.report.table import Cell, Row, RowGroup, Table
from ptl.report.table_kinds import KINDS, table_title
from ptl.text import MISSING, interval, number, percent, place_of

NOT_REACHED = "not reached"


@dataclass(frozen=True)
class MetricColumn:
    """One metric of a table, with the columns that follow from it.

    Attributes
    ----------
    metric : str
        Metric in metrics.csv.
    heading, unit : str
    better : "lower" or "higher"
    value, low, high : str
        Columns of metrics.csv that hold the estimate and its interval.
    spread : str
        Column of metrics.csv that is written after ±, empty for none.
    against_base : bool
        Whether it is a comparison with the base, for which it is 0 by definition.
    with_share, with_improvement : bool
        Whether the share of seeds that reached the threshold, or the probability of improvement, follows.
    """

    metric: str
    heading: str
    unit: str
    better: str
    value: str = "mean"
    low: str = "ci_low"
    high: str = "ci_high"
    spread: str = "std"
    against_base: bool = False
    with_share: bool = False
    with_improvement: bool = False

    @property
    def parts(self) -> list[table.Column]:
        """Columns of the page."""
        parts = [table.Column(self.heading, self.unit)]
        parts += [table.Column(self.heading, "reached")] * self.with_share
        parts += [table.Column(self.heading, "P")] * self.with_improvement
        return parts


def columns_of(kind: str) -> Iterator[MetricColumn]:
    """Yield a column for each measure of a kind of table; the probability of improvement is shown once a comparison."""
    shown: set[str] = set()
    for measure in MEASURES:
        if measure.table == kind:
            yield MetricColumn(
                measure.name,
                measure.heading,
                measure.unit,
                measure.better,
                spread="std" if measure.function else "",
                against_base=bool(measure.saves),
                with_share=measure.can_miss,
                with_improvement=measure.compared and measure.compared_by not in shown,
            )
            shown.add(measure.compared_by)


COLUMNS = {kind: tuple(columns_of(kind)) for kind in KINDS}
"""Columns of each kind of table: those of its measures. Further columns of metrics.csv are added here."""


def build_tables(
    metrics: pd.DataFrame,
    measures: Any,
    statistics: Any,
    methods: Mapping[str, tuple[str, str]],
    titles: Mapping[str, str],
    reproduction: bool = False,
) -> list[tuple[Table, pd.DataFrame]]:
    """Lay out two tables for each environment.

    Parameters
    ----------
    metrics : DataFrame
        As `ptl.measures.statistics.summarise` makes it.
    measures, statistics : groups of the configuration
        For the notes: window and threshold factor, confidence and resamples.
    methods : mapping
        Method to its label and colour, in the order of rows.
    titles : mapping
        Environment to title, in the order of the tables.
    reproduction : bool
        Whether the run is about the article, whose numbers a reader might take these for.

    Returns
    -------
    list of (Table, DataFrame)
        Each table with its numbers.
    """
    tables: list[tuple[Table, pd.DataFrame]] = []
    for environment, title in titles.items():
        frame = metrics[metrics["environment"] == environment]
        if frame.empty:
            raise UserError(f"metrics.csv: no environment {environment!r}; measure its learning files first")
        for kind in KINDS:
            columns = COLUMNS[kind]
            notes = [*_common_notes(frame, statistics, methods, reproduction), *_kind_notes(kind, measures)]
            if kind == "transfer" and reproduction:
                notes += _control_notes(metrics, environment, statistics)
            groups, numbers = _body(frame, columns, methods)
            parts = [part for column in columns for part in column.parts]
            tables.append(
                (
                    Table(
                        title=table_title(kind, title),
                        intro=notes[0],
                        corner="Method",
                        columns=parts,
                        groups=groups,
                        notes=notes[1:],
                        number=len(tables) + 1,
                        group_heading="Task",
                    ),
                    pd.DataFrame(numbers),
                )
            )
    return tables


def write_tables(tables: Sequence[tuple[Table, pd.DataFrame]], folder: Path) -> None:
    """Write every table as HTML, Markdown, LaTeX and CSV."""
    for model, numbers in tables:
        table.write(model, folder / model.name, numbers, (".html", ".md", ".tex"))


def _body(
    frame: pd.DataFrame, columns: Sequence[MetricColumn], methods: Mapping[str, tuple[str, str]]
) -> tuple[list[RowGroup], list[dict[str, object]]]:
    groups, numbers = [], []
    for position, (task, part) in enumerate(frame.groupby("task", sort=False)):
        estimates = part.set_index(["method", "metric"]).to_dict("index")
        present = [method for method in methods if (method, columns[0].metric) in estimates]
        # In the first task nothing is transferred: a best value there would only be a lucky one.
        best = {c.metric: best_methods(c, {m: estimates[m, c.metric] for m in present}) for c in columns if position}
        rows = []
        for method in present:
            cells: list[Cell] = []
            record: dict[str, object] = {"task": str(task), "method": method}
            for column in columns:
                estimate, is_best = estimates[method, column.metric], method in best.get(column.metric, ())
                cells += _cells(column, estimate, is_best, method == BASE)
                record |= _numbers(column, estimate, is_best)
            label, colour = methods[method]
            rows.append(Row(label, cells, colour))
            numbers.append(record)
        heading = f"Task {task}" if position else f"Task {task}: nothing to transfer yet"
        groups.append(RowGroup(rows, heading, str(task)))
    return groups, numbers


def best_methods(column: MetricColumn, values: Mapping[str, Mapping[str, Any]]) -> set[str]:
    """Return the methods whose number is in bold: the best, and those that read the same; none if all read the same.

    A time to threshold competes only among the methods that reached it in the most seeds: a mean over few lucky seeds
    is not better than one over all.
    """
    present = {method: row for method, row in values.items() if not math.isnan(row[column.value])}
    if column.with_share and present:
        most = max(row["reached"] for row in present.values())
        present = {method: row for method, row in present.items() if row["reached"] == most}
    if not present:
        return set()
    choose = min if column.better == "lower" else max
    best = choose(present.values(), key=lambda row: row[column.value])
    chosen = {method for method, row in present.items() if _read(column, row) == _read(column, best)}
    return set() if len(chosen) == len(values) else chosen


def _read(column: MetricColumn, row: Mapping[str, Any]) -> str:
    """Return the number as it is read in its cell."""
    return number(row[column.value], place_of(row[column.low], row[column.high]))


def _cells(column: MetricColumn, row: Mapping[str, Any], best: bool, is_base: bool) -> Iterator[Cell]:
    n, by_definition = int(row["n"]), is_base and column.against_base
    if by_definition and n:
        yield Cell(number(0.0))
    elif n:
        spread = row[column.spread] if column.spread else math.nan
        text = _read(column, row)
        if not math.isnan(spread):
            text += f" ± {number(spread, place_of(row[column.low], row[column.high]))}"
        yield Cell(text, interval(row[column.low], row[column.high]), best)
    else:
        yield Cell(NOT_REACHED if column.with_share else MISSING, aside=True)
    if column.with_share:
        yield Cell(f"{n} of {int(row['seeds'])}", aside=True)
    if column.with_improvement:
        yield Cell(number(row["improvement"]), aside=True)


def _numbers(column: MetricColumn, row: Mapping[str, Any], best: bool) -> dict[str, object]:
    names = [column.value, *([column.spread] if column.spread else []), column.low, column.high, "n", "seeds"]
    names += ["reached"] * column.with_share
    names += ["improvement", "improvement_low", "improvement_high"] * column.with_improvement
    return {f"{column.metric}_{name}": row[name] for name in names} | {f"{column.metric}_best": best}


def _kind_notes(kind: str, measures: Any) -> list[str]:
    if kind == "transfer":
        return [
            "Jump start: first-episode steps of the base minus those of the method; positive is good. Those of the base"
            " are the exact expectation of a uniform random walk, unless ties of greedy actions are not random. The"
            " percentage is a ratio of means; P compares the first episodes of the runs.",
            f"Asymptotic performance: mean steps of the last {measures.window} episodes.",
            f"Time to threshold: first episode at which the mean of the last {measures.window} is at most"
            f" {number(measures.threshold_factor)} times the shortest path, or the least expected steps where steps"
            " slip. Its mean covers the seeds that reached it, counted under “reached”; bold is given among the methods"
            " that reached it in the most seeds.",
        ]
    return [
        "Total performance: steps over all episodes of the task.",
        "Transfer ratio: (total of the base − total of the method) / total of the base; positive is good. The mean of"
        " the per-seed ratios weighs every seed alike, the ratio of the means every step alike.",
    ]


def _control_notes(metrics: pd.DataFrame, environment: str, statistics: Any) -> Iterator[str]:
    """Say how many jump starts of the first task have an interval without 0, where every one is a chance finding."""
    first = metrics.groupby("environment")["task"].transform("first")
    jumps = metrics[(metrics["task"] == first) & (metrics["metric"] == "jump_start") & (metrics["method"] != BASE)]
    jumps = jumps.dropna(subset=["ci_low", "ci_high"])
    if jumps.empty:
        return
    missed = (jumps["ci_low"] > 0) | (jumps["ci_high"] < 0)
    own = jumps["environment"] == environment
    yield (
        f"Task {first[own.index[own][0]]} is a negative control: nothing is transferred yet, so every first episode has"
        f" the same distribution. {missed[own].sum()} of the {own.sum()} intervals of its jump starts exclude 0, and"
        f" {missed.sum()} of {len(jumps)} in all environments; {percent(1 - statistics.confidence)} would be expected."
        " Intervals of heavy-tailed values from few seeds are too narrow."
    )


def _common_notes(
    frame: pd.DataFrame, statistics: Any, methods: Mapping[str, tuple[str, str]], reproduction: bool
) -> list[str]:
    seeds = sorted({int(n) for n in frame["seeds"]})
    intervals = (
        f"in brackets the {percent(statistics.confidence)} bootstrap interval of the mean (BCa,"
        f" {number(statistics.resamples)} resamples; runs of a method and of the base with the same seed are"
        f" subtracted, but independent; none for fewer than {MIN_FOR_INTERVAL} values)."
        if seeds[-1] >= MIN_FOR_INTERVAL
        else f"no intervals, which take at least {MIN_FOR_INTERVAL} seeds."
    )
    notes = [
        f"Mean ± standard deviation over {' or '.join(map(str, seeds))} seeds{' of this reproduction' * reproduction};"
        f" {intervals} Best value of a column within a task in bold; none in the first task.",
    ]
    if BASE in set(frame["method"]):
        notes.append(
            f"Base: {methods[BASE][0]}. P: probability that a run of the method is better than a run of the base (ties"
            " count half; 0.5 is no difference).",
        )
    else:
        notes.append(f"The base {BASE} is not in this run, so nothing is compared with it.")
    truncated = frame[(frame["metric"] == "truncated") & (frame["mean"] > 0)]
    if len(truncated):
        parts = [
            f"task {r.task}, {methods[r.method][0]}: {number(round(r.mean * r.n))}" for r in truncated.itertuples()
        ]
        notes.append(f"Episodes truncated at the step limit, counted with its length: {'; '.join(parts)}.")
    notes.append("Computed from metrics.csv (from per_seed.csv).")
    return notes
