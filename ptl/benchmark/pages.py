"""The measurements as pages that people read."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import pandas as pd

from ptl.benchmark.run import NOTE
from ptl.benchmark.scaling import size_at
from ptl.benchmark.speed import BASE, ENTRIES, EPISODES, LIMITS, SAMPLED_EVERY
from ptl.benchmark.startup import PHASES
from ptl.benchmark.surveys import EVERY_STEP, METHODS, TREES
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


TEN_MINUTES = 600.0
"""CPU seconds; the page says at which size each part of the larger worlds passes them."""


def benchmark_csv(machine: Mapping[str, str], **parts: pd.DataFrame) -> pd.DataFrame:
    """Return all numbers of the benchmark, columns `CSV_COLUMNS`; rows of the machine have words for a quantity."""
    words = pd.DataFrame([{"item": name, "quantity": text} for name, text in machine.items()])
    frames = [frame.assign(part=part) for part, frame in {"machine": words, **parts}.items()]
    return pd.concat([frame.reindex(columns=CSV_COLUMNS) for frame in frames], ignore_index=True)


def benchmark_markdown(
    machine: Mapping[str, str],
    speed: pd.DataFrame,
    limit: pd.DataFrame,
    survey: pd.DataFrame,
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
    tables = [
        speed_table(speed, place, letter),
        limit_table(limit),
        survey_table(survey),
        startup_table(startup, place),
        run_table(run),
    ]
    return _markdown("Benchmark", machine, tables)


def scaling_markdown(machine: Mapping[str, str], frame: pd.DataFrame) -> str:
    """Render the growth of the cost as one Markdown page."""
    tables = [exponents_table(frame), large_table(frame), larger_table(frame), ten_minutes_table(frame)]
    return _markdown("Growth of the cost", machine, tables)


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
            "mdplib breaks ties differently and lets ε fall from 1, so it shares the law of the others only where all"
            " actions are random: with its ε held at 1, while Q is zero.",
        ),
    )


def limit_table(summary: pd.DataFrame) -> Table:
    """Lay out what bounds the kernel, and how near it comes."""
    values = summary.set_index(["item", "quantity"])
    rates = [(entry.label, values.loc[(entry.label, "per CPU second")]) for entry in LIMITS]
    rows = [(label, *_with_range(rate[["value", "low", "high"]] / 1e6)) for label, rate in rates]
    for entry in ENTRIES:
        if entry.limit:
            share = values.loc[(entry.label, f"share of {entry.limit}")]
            limits = f"{percent(share['low'])} to {percent(share['high'])}"
            rows.append((f"{entry.label}: share of {entry.limit}", percent(share["value"]), limits))
    return text_table(
        "How far from the limit",
        "Millions per CPU second, measured in the same rounds.",
        ("limit or learner", "value", "least to greatest"),
        rows,
        (
            "A bare random walk learns nothing and remembers nothing: each look-up waits for the one before, and its"
            " random bits are drawn beforehand. A learner of this kind cannot be faster.",
            "Random words are drawn one by one through numpy's C interface. A step of the kernel takes half a word, and"
            " with the shortcut a thirty-second of one.",
        ),
    )


def survey_table(summary: pd.DataFrame) -> Table:
    """Lay out what the survey of figure 8 takes by both methods, map by map."""
    values = summary.set_index(["item", "quantity"])["value"]
    names = [name.removeprefix("core seconds") for name in values[TREES].index if name.startswith("core seconds")]
    rows = []
    for ending in names:
        seconds = [values[method, f"core seconds{ending}"] for method in METHODS]
        steps = [number(values[method, f"steps{ending}"] / 1e9) for method in METHODS]
        pairs = number(int(values[TREES, f"pairs{ending}"]))
        ratio = number(seconds[0] / seconds[1])
        rows.append((ending.removeprefix(", ") or "all maps", pairs, *map(number, seconds), ratio, *steps))
    return text_table(
        "Figure 8: the subgoals of all pairs of start and goal",
        "All pairs by both methods, the batches of one beside those of the other.",
        (
            "map",
            "pairs",
            "core seconds, every step simulated",
            "core seconds, with trees",
            "ratio",
            "billion steps, every step simulated",
            "billion steps, with trees",
        ),
        rows,
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
        ("Wall time of a job: from its start to its last product.", NOTE),
    )


def exponents_table(frame: pd.DataFrame) -> Table:
    """Lay out the value at both ends and the exponent of every curve."""
    rows = []
    curves = frame[frame["part"].isin(SIZES)].groupby(["part", "kind", "quantity"], sort=False)
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


def larger_table(frame: pd.DataFrame) -> Table:
    """Lay out the survey of subgoals and a life on larger and larger maps."""
    part = frame[frame["part"].isin(["survey", "life"])]
    rows = []
    for (kind, size), group in part.groupby(["kind", "size"], sort=False):
        value = group.set_index("quantity")["value"]
        row = [f"{kind}, {number(int(size))} states"]
        for method in METHODS:
            error = f"{100 * value[f'{method}, relative standard error']:.0f}%"
            timed = percent(value[f"{method}, pairs timed, count"] / (size * (size - 1)))
            row += [f"{number(value[f'{method}, s'])} (± {error})", timed, number(value[f"{method}, memory, MiB"])]
        row.append(number(value[f"{EVERY_STEP}, s"] / value[f"{TREES}, s"]))
        rows.append((*row, number(value["life of ten tasks, s"]), number(value["life of ten tasks, memory, MiB"])))
    heads = [f"{method}: {head}" for method in METHODS for head in ("core seconds", "pairs timed", "memory, MiB")]
    return text_table(
        "Larger worlds",
        "Figure 8's survey of all pairs of start and goal by both methods, and a life of ten random tasks under PTL.",
        ("map", *heads, "ratio of the surveys", "life of ten tasks: core seconds", "life of ten tasks: memory, MiB"),
        rows,
        (
            "The seconds of a survey are extrapolated from the share of all pairs that was timed, drawn at random; in"
            " brackets the standard error that comes from the sample. A life is the mean of several; its episodes have"
            " no step limit.",
            "Memory is that beyond what the process held before.",
        ),
    )


def ten_minutes_table(frame: pd.DataFrame) -> Table:
    """Lay out the size of the map at which each part of the larger worlds takes ten minutes of one core."""
    part = frame[frame["quantity"].isin([f"{EVERY_STEP}, s", f"{TREES}, s", "life of ten tasks, s"])]
    part = part[part["part"].isin(["survey", "life"])]
    rows = []
    for (quantity, kind), curve in part.groupby(["quantity", "kind"], sort=False):
        size, within = size_at(curve, TEN_MINUTES)
        first = curve.iloc[0]
        exponent = estimate(first["exponent"], first["exponent_low"], first["exponent_high"])
        how = "between measured sizes" if within else "extrapolated"
        rounded = number(int(float(f"{size:.2g}")))
        rows.append((str(quantity).removesuffix(", s"), str(kind), rounded, how, exponent))
    headings = ("what", "map", "states at ten minutes", "how found", "exponent p")
    return text_table(
        "Where ten minutes are passed",
        "Size of the map at which the work takes ten minutes of one core.",
        headings,
        rows,
        (
            "Between measured sizes by a straight line on logarithms; extrapolated by the power law fitted to the"
            " larger sizes.",
        ),
        (headings[1], headings[3]),
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
