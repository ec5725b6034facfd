"""The measurements as pages that people read."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import pandas as pd

from ptl.benchmark.speed import BASE, ENTRIES, EPISODES, SAMPLED_EVERY
from ptl.benchmark.startup import PHASES
from ptl.config import Parameters
from ptl.methods import load
from ptl.report.table import Table, text_table, to_markdown
from ptl.report.templating import render
from ptl.text import MISSING, estimate, number, percent

CSV_COLUMNS = ["part", "item", "quantity", "value", "low", "high", "repeats"]

SIZES = {
    "states": "states of the map",
    "diameter": "states of the map",
    "library": "skills in the library",
    "tasks": "tasks learned",
}
"""Size along which each part of the growth is measured."""

WHOLE = ("states", "count", "bytes")
"""Units of whole numbers."""

UNITS_OF_TIME = (("s", 1.0), ("ms", 1e3), ("µs", 1e6), ("ns", 1e9))


def benchmark_csv(
    machine: Mapping[str, str], speed: pd.DataFrame, startup: pd.DataFrame, run: pd.DataFrame
) -> pd.DataFrame:
    """Return all numbers of the benchmark, columns `CSV_COLUMNS`; rows of the machine have words for a quantity."""
    words = pd.DataFrame([{"item": name, "quantity": text} for name, text in machine.items()])
    parts = {"machine": words, "speed": speed, "start-up": startup, "run": run}
    frames = [frame.assign(part=part) for part, frame in parts.items()]
    return pd.concat([frame.reindex(columns=CSV_COLUMNS) for frame in frames], ignore_index=True)


def benchmark_markdown(
    machine: Mapping[str, str],
    speed: pd.DataFrame,
    startup: pd.DataFrame,
    run: pd.DataFrame,
    *,
    place: str,
    letter: str,
) -> str:
    """Render the benchmark as one Markdown page.

    Parameters
    ----------
    place, letter : str
        Map and goal letter of the task that was learned; the jobs learned all tasks of the map.
    """
    tables = [speed_table(speed, place, letter), startup_table(startup, place), run_table(run)]
    return _markdown("Benchmark", machine, tables)


def scaling_markdown(machine: Mapping[str, str], frame: pd.DataFrame) -> str:
    """Render the growth of the cost as one Markdown page."""
    return _markdown("Growth of the cost", machine, [exponents_table(frame), large_table(frame)])


def _markdown(title: str, machine: Mapping[str, str], tables: Sequence[Table]) -> str:
    return render("measurements.md", title=title, machine=machine, sections=list(map(to_markdown, tables)))


def speed_table(summary: pd.DataFrame, place: str, letter: str) -> Table:
    """Lay out rates and ratios of all learners."""
    rows = []
    for item, group in summary.groupby("item", sort=False):
        rate, ratio = group.to_dict("records")
        thousands = {name: rate[name] / 1000 for name in ("value", "low", "high")}
        rows.append([str(item), *_with_range(thousands), *_with_range(ratio)])
    sampled = ", ".join(entry.label for entry in ENTRIES if entry.workload == "sampled")
    return text_table(
        "Steps with Q-update per CPU second",
        f"Q-learning of {place}, task {letter}, from scratch: {EPISODES} episodes, same α, γ, ε and law for all.",
        ("learner", "thousand steps/s", "rate, least to greatest", "ratio", "ratio, least to greatest"),
        rows,
        (
            f"Median of {int(summary['repeats'].min())} rounds; in each round all learners run one after another,"
            f" and a ratio compares a round with itself. One core. The ratio is to “{BASE}”.",
            f"One episode in {SAMPLED_EVERY} of the task, begun with the Q that the kernel has there, because the whole"
            f" task would take minutes: {sampled}.",
            "While Q is zero: α = 0, so that every episode follows the law of the first one. The shortcut applies"
            " where Q has been zero all around; its steps follow the same law, but two of them cost one look-up.",
        ),
    )


def startup_table(summary: pd.DataFrame, place: str) -> Table:
    """Lay out the phases of a learning job of every method."""
    rows = []
    for method, group in summary.groupby("item", sort=False):
        values = group.set_index("quantity")
        phases = [number(1000 * values.loc[f"CPU seconds, {phase}", "value"]) for phase in PHASES]
        whole = _with_range(values.loc["CPU seconds, all"])
        rows.append([load(str(method)).label, *phases, *whole, number(values.loc["peak MiB", "value"])])
    return text_table(
        "One learning job, from the start of Python to its end",
        f"All tasks of {place}, {Parameters().learning.episodes} episodes each; CPU time (user, system) in ms.",
        ("method", *PHASES, "all, in seconds", "all, least to greatest", "peak memory, MiB"),
        rows,
        (f"Median of {int(summary['repeats'].min())} jobs, each a process of its own.",),
    )


def run_table(summary: pd.DataFrame) -> Table:
    """Lay out the rules of a whole run by the time they took."""
    whole = summary[summary["item"] == "whole run"].set_index("quantity")["value"]
    rules = summary[summary["item"] != "whole run"].pivot(index="item", columns="quantity", values="value")
    rules = rules.sort_values("wall seconds of all jobs", ascending=False, kind="stable")
    rows = []
    for rule, values in rules.iterrows():
        jobs, seconds = values["jobs"], values["wall seconds of all jobs"]
        share = percent(values["share of core time"])
        rows.append((str(rule), number(int(jobs)), number(seconds), number(seconds / jobs), share))
    idle = whole.pop("share of core time without a job")
    rows.append(("no job: planning, waiting, bookkeeping", MISSING, MISSING, MISSING, percent(idle)))
    return text_table(
        "Time of a whole run",
        "A run made for this page. "
        + "; ".join(f"{quantity}: {number(value)}" for quantity, value in whole.items())
        + ".",
        ("rule", "jobs", "wall seconds, all jobs", "wall seconds, a job", "share of core time"),
        rows,
        ("Wall time of a job: from its start to its last product.",),
    )


def exponents_table(frame: pd.DataFrame) -> Table:
    """Lay out the value at both ends and the exponent of every curve."""
    rows = []
    curves = frame[frame["part"] != "large"].groupby(["part", "kind", "quantity"], sort=False)
    for (part, kind, quantity), curve in curves:
        ends = curve.sort_values("size").iloc[[0, -1]].to_dict("records")
        last = ends[-1]
        exponent = estimate(last["exponent"], last["exponent_low"], last["exponent_high"])
        at = [f"{quantity_text(end['value'], str(quantity))} at {number(int(end['size']))}" for end in ends]
        rows.append((str(quantity), SIZES[str(part)], str(kind), *at, exponent))
    headings = ("cost", "size", "map", "smallest", "largest", "exponent p")
    return text_table(
        "Cost against size",
        "Cost ∝ sizeᵖ at large sizes; p with its interval.",
        headings,
        rows,
        (
            "Least squares on logarithms from the size given in the CSV of the figure; below it constant costs hide the"
            " growth. The interval (95%) takes the scatter around the line to be noise. CPU time; least of several"
            " repeats. Memory is that beyond what the process held before.",
            "The length of a first episode is a property of the random walk, not of the code.",
            "The diameter of one closed corridor is the worst case of the exact algorithm: all states are equally far"
            " out, so it has to search from each of them. Rooms and open ground need a few dozen searches.",
        ),
        headings[1:3],
    )


def large_table(frame: pd.DataFrame) -> Table:
    """Lay out the measurements of the large map."""
    part = frame[frame["part"] == "large"]
    side = int(part["size"].iloc[0])
    rows = [(row["quantity"], quantity_text(row["value"], row["quantity"])) for row in part.to_dict("records")]
    return text_table(
        f"A map of {side} × {side} cells",
        "Two tasks under PTL, learned to the end.",
        ("quantity", "value"),
        rows,
    )


def quantity_text(value: float, quantity: str) -> str:
    """Format a value with the unit that ends the name of its quantity; seconds in the unit that suits them."""
    unit = quantity.rpartition(", ")[2]
    if unit == "s":
        suiting = [scale for scale in UNITS_OF_TIME if value * scale[1] >= 1]
        name, factor = suiting[0] if suiting else UNITS_OF_TIME[-1]
        return f"{number(value * factor)} {name}"
    if unit == "MiB":
        return f"{number(value)} MiB"
    return number(int(value) if unit in WHOLE else value)


def _with_range(row: Mapping[str, float] | pd.Series) -> tuple[str, str]:
    return number(row["value"]), f"{number(row['low'])} to {number(row['high'])}"
