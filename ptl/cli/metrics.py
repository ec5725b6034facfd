"""``ptl metrics``: print the measures of a run."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ptl.cli._columns import laid_out

if TYPE_CHECKING:
    import pandas as pd

NAMES = ("environment", "task", "method", "metric")
"""Columns that identify a row."""

INTERVAL = ("mean", "ci_low", "ci_high")
"""Columns of the estimate; empty if no seed has a value."""


@click.command()
@click.argument("run", required=False)
@click.option("--environment", "-e", multiple=True, help="Only this environment; may be repeated.")
@click.option("--task", "-t", multiple=True, help="Only this task, or 'all'; the last of each environment if left out.")
@click.option("--method", "-m", multiple=True, help="Only this method; may be repeated.")
@click.option("--measure", "-x", multiple=True, help="Only this measure, as metrics.csv calls it; may be repeated.")
def command(
    run: str | None,
    environment: tuple[str, ...],
    task: tuple[str, ...],
    method: tuple[str, ...],
    measure: tuple[str, ...],
) -> None:
    """Print the measures of RUN as a table for each environment and task: mean and interval.

    RUN is the name of a run or a metrics.csv; left out, the run of this folder, or the published one of several.
    """
    from ptl.measures.sample_size import MIN_FOR_INTERVAL

    path = _path_of(run)
    metrics = _estimates(path)
    frame = metrics
    for column, wanted in (("environment", environment), ("method", method), ("metric", measure)):
        frame = _only(frame, column, wanted, path)
    if not task:
        last = metrics.groupby("environment", sort=False)["task"].last()
        frame = frame[frame["task"] == frame["environment"].map(last)]
    elif "all" not in task:
        frame = _only(frame, "task", task, path)
    for (place, letter), part in frame.groupby(["environment", "task"], sort=False):
        first = metrics.loc[metrics["environment"] == place, "task"].iloc[0]
        note = ": nothing to transfer yet" if letter == first else ""
        seeds = int(part["seeds"].max())
        shown = "mean [interval]" if seeds >= MIN_FOR_INTERVAL else "mean"
        click.echo(f"{place}, task {letter}{note} ({seeds} seed{'s' if seeds > 1 else ''}: {shown})")
        width = shutil.get_terminal_size().columns
        click.echo("\n".join(laid_out(_columns(part, explicit=bool(measure)), width)) + "\n")


def _path_of(run: str | None) -> Path:
    from ptl.errors import UserError

    if run is not None:
        path = Path(run) if run.endswith(".csv") else Path("reports") / run / "tables/metrics.csv"
        if not path.is_file():
            there = ", ".join(sorted(path.parts[1] for path in Path("reports").glob("*/tables/metrics.csv")))
            raise UserError(f"{path}: no such file; runs with measures: {there or 'none'}")
        return path
    tables = {path.parts[1]: path for path in Path("reports").glob("*/tables/metrics.csv")}
    if len(tables) == 1 or "published" in tables:
        return tables.get("published") or next(iter(tables.values()))
    raise UserError(
        f"reports/*/tables/metrics.csv: {len(tables)} runs; name one of {', '.join(sorted(tables)) or 'none'}"
    )


def _estimates(path: Path) -> pd.DataFrame:
    """Read a table of estimates, control characters in its names as escapes; refuse other tables."""
    from ptl.errors import UserError, printable
    from ptl.files.tables import check_numbers, read_table

    table = read_table(path, (*NAMES, *INTERVAL, "n", "seeds"))
    check_numbers(table, path, INTERVAL, missing=True)
    check_numbers(table, path, ("n",), low=0)
    check_numbers(table, path, ("seeds",), low=1)
    faults = {
        "has the estimate of an earlier row": table.duplicated([*NAMES]),
        "has an interval that ends before it begins": table["ci_low"] > table["ci_high"],
        "has a mean of no values, or values without a mean": (table["n"] > 0) == table["mean"].isna(),
    }
    for fault, rows in faults.items():
        if rows.any():
            raise UserError(f"{path}: row {rows.argmax() + 1} {fault}; name another table or correct it")
    return table.assign(**{name: table[name].fillna("").map(printable) for name in NAMES})


def _only(frame: pd.DataFrame, column: str, wanted: tuple[str, ...], path: Path) -> pd.DataFrame:
    from ptl.errors import UserError

    known = list(dict.fromkeys(frame[column]))
    for name in wanted:
        if name not in known:
            raise UserError(f"{path}: no {column} {name!r}; there are {', '.join(known)}")
    return frame[frame[column].isin(wanted)] if wanted else frame


def _columns(part: pd.DataFrame, *, explicit: bool) -> list[list[str]]:
    """Return the table column by column, each with its two headings first; the labels of rows come first."""
    from ptl.measures.measures import MEASURES

    rows = part.set_index(["method", "metric"]).to_dict("index")
    methods = list(dict.fromkeys(part["method"]))
    columns = [["", "", *methods]]
    for measure in MEASURES:
        own = [rows.get((method, measure.name)) for method in methods]
        quiet = not explicit and measure.name == "truncated" and not any(row and row["mean"] for row in own)
        if any(own) and not quiet:
            columns.append([measure.heading, measure.unit, *(_cell(row, measure.can_miss) for row in own)])
    return columns


def _cell(row: dict | None, can_miss: bool) -> str:
    from ptl.text import MISSING, estimate

    if row is None or not row["n"]:
        return "not reached" if row and can_miss else MISSING
    missed = can_miss and row["n"] < row["seeds"]
    share = f" ({int(row['n'])} of {int(row['seeds'])})" if missed else ""
    return estimate(row["mean"], row["ci_low"], row["ci_high"]) + share
