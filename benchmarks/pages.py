"""The measurements as tables that people read."""

from __future__ import annotations

import os
import platform
from collections.abc import Iterable
from importlib import metadata
from pathlib import Path

import pandas as pd

import ptl
from benchmarks.speed import BASE, EPISODES, SAMPLED_EVERY
from ptl.report.table import Table, text_table, to_markdown
from ptl.text import MISSING, estimate, number, percent

PACKAGES = ("numpy", "h5py", "snakemake", "gymnasium", "jax", "mdplib", "numba")
COLUMNS = ["part", "item", "quantity", "value", "low", "high", "repeats", "source"]

PARTS = {
    "speed": (
        "Steps with Q-update per CPU second",
        "Q-learning of {task}, from Q = 0: {episodes} episodes, the same α, γ and ε for all. One core; the ratio is to"
        " “{base}”.",
        (
            "In each round all learners run one after another, and a ratio compares rates of one round.",
            "Gymnasium and numpy run one episode in {every}, begun with the Q that the kernel has there, because the"
            " whole task would take minutes.",
            "While Q is zero: α = 0, so that every episode has the distribution of the first one. The shortcut takes"
            " two steps in one look-up where Q is zero all around; its steps have the same distribution.",
            "mdplib gives ties to the first action and lets ε fall from 1, so it compares with the rows while Q is"
            " zero: its ε is held at 1.",
        ),
    ),
    "published": ("Rates that others have published", "Not measured here: other hardware, other learners.", ()),
    "limit": (
        "How far from the limit",
        "Measured in the same rounds.",
        (
            "A bare random walk learns and records nothing: each look-up waits for the one before, and its random bits"
            " are drawn beforehand. A learner that takes one step after another cannot be faster.",
        ),
    ),
    "survey": (
        "Figure 8: the subgoals of all pairs of start and goal",
        "All pairs by both methods, the batches of one beside those of the other.",
        (),
    ),
    "startup": (
        "One learning job, from the start of Python to its end",
        "All tasks of {map}; CPU time, user and system, of a process of its own.",
        ("Learning is timed apart, in a process that has everything imported; the rest of the job is the difference.",),
    ),
    "run": (
        "Time of a whole run",
        "A run made for this page; wall time of a job is from its start to its last product.",
        ("The verdicts rest on three runs of each method instead of the study's thousands.",),
    ),
}
"""Title, introduction and notes of each part of the benchmark."""


def machine() -> dict[str, str]:
    """Describe processor, cores, memory, system, Python, packages and load; no name of machine or user."""
    cpu = Path("/proc/cpuinfo")
    models = [line.partition(":")[2].strip() for line in _lines(cpu) if line.startswith("model name")]
    return {
        "processor": next(iter(models), platform.processor() or platform.machine()),
        "cores": str(os.cpu_count()),
        "memory": f"{os.sysconf('SC_PAGE_SIZE') * os.sysconf('SC_PHYS_PAGES') / 2**30:.1f} GiB",
        "system": f"{platform.system()} {platform.machine()}",
        "Python": f"{platform.python_implementation()} {platform.python_version()}",
        "packages": ", ".join([f"ptl {ptl.__version__}", *(f"{name} {metadata.version(name)}" for name in PACKAGES)]),
        "load before": f"{os.getloadavg()[0]:.2f} (1-minute average; 0 is an idle machine)",
    }


def _lines(path: Path) -> list[str]:
    return path.read_text(encoding="utf-8").splitlines() if path.exists() else []


def summarise(measured: pd.DataFrame) -> pd.DataFrame:
    """Return median, minimum, maximum and number of the values of each quantity, columns `COLUMNS`."""
    by = ["part", "item", "quantity"]
    groups = measured.reindex(columns=[*by, "value", "source"]).groupby(by, sort=False)
    summary = groups["value"].agg(value="median", low="min", high="max", repeats="size")
    return summary.assign(source=groups["source"].first()).reset_index()[COLUMNS]


def benchmark_csv(computer: dict[str, str], summary: pd.DataFrame) -> pd.DataFrame:
    """Return all numbers, columns `COLUMNS`; rows of the machine have words for a quantity."""
    words = pd.DataFrame([("machine", *row) for row in computer.items()], columns=COLUMNS[:3])
    return pd.concat([words, summary], ignore_index=True).reindex(columns=COLUMNS)


def benchmark_page(computer: dict[str, str], summary: pd.DataFrame, place: str, letter: str) -> str:
    """Render the parts of the benchmark as one Markdown page."""
    words = {
        "task": f"{place}, task {letter}",
        "map": place,
        "episodes": EPISODES,
        "every": SAMPLED_EVERY,
        "base": BASE,
    }
    tables = []
    for part, (title, intro, notes) in PARTS.items():
        rows = summary[summary["part"] == part]
        sources = [f"{item}: {source}." for item, source in rows[["item", "source"]].dropna().to_numpy()]
        if rows["repeats"].max() > 1:
            sources.append(f"Median of {rows['repeats'].max()} repeats, in brackets minimum and maximum.")
        below = [note.format(**words) for note in notes] + sources
        quantities = list(rows["quantity"].unique())
        cells = rows.set_index(["item", "quantity"])
        body = [
            (
                item,
                *(
                    _cell(name, cells.loc[item, name]) if (item, name) in cells.index else MISSING
                    for name in quantities
                ),
            )
            for item in rows["item"].unique()
        ]
        tables.append(text_table(title, intro.format(**words), ("", *quantities), body, below))
    return _page("Benchmark", computer, tables)


def scaling_page(computer: dict[str, str], frame: pd.DataFrame) -> str:
    """Render the growth of cost as one Markdown page."""
    rows = []
    for (part, kind, quantity), curve in frame.groupby(["part", "kind", "quantity"], sort=False):
        ends = curve.sort_values("size").iloc[[0, -1]].to_dict("records")
        at = [f"{_text(str(quantity), end['value'])} at {number(int(end['size']))}" for end in ends]
        exponent = MISSING
        if str(quantity).endswith(", s"):
            exponent = estimate(*(ends[-1][name] for name in ("exponent", "exponent_low", "exponent_high")))
        rows.append((str(quantity), str(part), str(kind), *at, exponent))
    headings = ("cost", "size", "map", "smallest", "largest", "exponent p")
    notes = (
        "Least squares on logarithms from the size given in the CSV file on; below it constant costs hide the growth."
        " The interval (95%) takes the scatter around the line to be noise. CPU time, one core.",
        "A survey of all pairs is scaled up from a sample of them, whose relative standard error is given. A life of"
        " ten tasks is the mean of several, without step limit.",
    )
    table = text_table("Cost against size", "Cost ∝ sizeᵖ at large sizes.", headings, rows, notes, headings[1:3])
    return _page("Growth of the cost", computer, [table])


def _page(title: str, computer: dict[str, str], tables: Iterable[Table]) -> str:
    facts = "".join(f"* {name}: {text}\n" for name, text in computer.items())
    head = f"# {title}\n\nMeasured on this machine, all in one run:\n\n{facts.replace('_', chr(92) + '_')}"
    return "\n".join([head, *map(to_markdown, tables)])


def _cell(quantity: str, row: pd.Series) -> str:
    """Format a value, with minimum and maximum where it was measured several times."""
    value, low, high = (_text(quantity, row[name]) for name in ("value", "low", "high"))
    return value if low == high else f"{value} ({low} to {high})"


def _text(quantity: str, value: float) -> str:
    if quantity.startswith("share of"):
        return percent(value)
    if quantity.endswith(", s"):
        name, factor = next(((n, f) for n, f in (("s", 1), ("ms", 1e3), ("µs", 1e6)) if value * f >= 1), ("ns", 1e9))
        return f"{number(value * factor)} {name}"
    return number(int(value) if quantity in ("jobs", "cores", "pairs") else value)
