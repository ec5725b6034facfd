"""The measurements as pages that people read."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd

from ptl.benchmark.speed import BASE, EPISODES
from ptl.benchmark.startup import PHASES
from ptl.methods import load
from ptl.pages import Page
from ptl.parameters import Parameters

CSV_COLUMNS = ["part", "item", "quantity", "value", "low", "high", "repeats"]


def benchmark_csv(
    machine: Mapping[str, str], speed: pd.DataFrame, startup: pd.DataFrame, run: pd.DataFrame | None
) -> pd.DataFrame:
    """All numbers of the benchmark as one tidy table; the machine's rows have words for a quantity."""
    words = pd.DataFrame([{"item": name, "quantity": text} for name, text in machine.items()])
    parts = {"machine": words, "speed": speed, "start-up": startup, "run": run}
    frames = [frame.assign(part=part) for part, frame in parts.items() if frame is not None]
    return pd.concat([frame.reindex(columns=CSV_COLUMNS) for frame in frames], ignore_index=True)


def benchmark_markdown(
    machine: Mapping[str, str],
    speed: pd.DataFrame,
    startup: pd.DataFrame,
    run: pd.DataFrame | None,
    *,
    place: str,
    letter: str,
    log: str = "",
) -> str:
    """The benchmark as one Markdown page.

    Parameters
    ----------
    place, letter : str
        Map and goal letter of the task that was learned; the jobs learned all tasks of the map.
    log : str
        Which run was taken apart.
    """
    lines = ["# Benchmark", "", "Measured on this machine, all in one run:", ""]
    lines += [f"* {name}: {text}" for name, text in machine.items()]
    pages = [speed_page(speed, place, letter), startup_page(startup, place)]
    sections = ["\n".join(lines) + "\n", *(page.to_markdown() for page in pages)]
    if run is None:
        sections.append(
            "**Where a whole run spends its time**\n\nNo log of a whole run was found: make one with"
            " `snakemake -j2 --forceall` and measure again.\n"
        )
    else:
        sections.append(run_page(run, log).to_markdown())
    return "\n".join(sections)


def speed_page(summary: pd.DataFrame, place: str, letter: str) -> Page:
    """Rates and ratios of all contestants."""
    rows = []
    for item, group in summary.groupby("item", sort=False):
        rate, ratio = (group[group["quantity"] == q].iloc[0] for q in group["quantity"].unique())
        rows.append(
            [
                str(item),
                _steps(rate["value"]),
                f"{_steps(rate['low'])} to {_steps(rate['high'])}",
                _significant(ratio["value"]),
                f"{_significant(ratio['low'])} to {_significant(ratio['high'])}",
            ]
        )
    return Page(
        title="Steps with Q-update per CPU second",
        intro=f"Q-learning of {place}, task {letter}, from scratch: {EPISODES} episodes, same α, γ, ε and law for all.",
        columns=["learner", "million steps/s", "rate, least to greatest", "ratio", "ratio, least to greatest"],
        rows=rows,
        notes=(
            f"Median of {int(summary['repeats'].min())} rounds; in each round all learners run one after another,"
            f" and a ratio compares a round with itself. One core. The ratio is to “{BASE}”.",
            "Gymnasium and mushroom-rl run every twentieth episode of the task, begun with the Q that the kernel"
            " has there; the whole task would take them minutes.",
            "While Q is zero: α = 0, so that every episode follows the law of the first one. The shortcut works"
            " where Q has been zero all around; its steps follow the same law, but two of them cost one look-up.",
            "The tests' reference draws the same random numbers as the kernel and gives the same Q bit for bit;"
            " it is written to be read.",
        ),
    )


def startup_page(summary: pd.DataFrame, place: str) -> Page:
    """Phases of a learning job of every method."""
    rows = []
    for method, group in summary.groupby("item", sort=False):
        values = group.set_index("quantity")
        cells = [f"{1000 * values.loc[f'CPU seconds, {phase}', 'value']:.0f}" for phase in PHASES]
        whole = values.loc["CPU seconds, all"]
        cells.append(f"{whole['value']:.2f} ({whole['low']:.2f} to {whole['high']:.2f})")
        rows.append([load(str(method)).label, *cells, f"{values.loc['peak MiB', 'value']:.0f}"])
    return Page(
        title="One learning job, from the start of Python to its end",
        intro=f"All tasks of {place}, {Parameters().learning.episodes} episodes each; CPU time (user, system) in ms.",
        columns=["method", *PHASES, "all, in seconds", "peak memory, MiB"],
        rows=rows,
        notes=(
            f"Median of {int(summary['repeats'].min())} jobs, each a process of its own; in brackets the least and the"
            " greatest.",
        ),
    )


def run_page(summary: pd.DataFrame, log: str) -> Page:
    """Rules of a whole run by the time they took."""
    whole = summary[summary["item"] == "whole run"].set_index("quantity")["value"]
    rules = summary[summary["item"] != "whole run"].pivot(index="item", columns="quantity", values="value")
    rules = rules.sort_values("wall seconds of all jobs", ascending=False, kind="stable")
    rows = []
    for rule, values in rules.iterrows():
        jobs, seconds = values["jobs"], values["wall seconds of all jobs"]
        share = f"{100 * values['share of core time']:.1f} %"
        rows.append([str(rule), f"{jobs:.0f}", f"{seconds:.0f}", f"{seconds / jobs:.2f}", share])
    rows.append(
        [
            "no job: reading the workflow, planning, waiting, writing down",
            "",
            "",
            "",
            f"{100 * whole['share of core time without a job']:.1f} %",
        ]
    )
    return Page(
        title="Where a whole run spends its time",
        intro=f"{log}: {whole['wall seconds']:.0f} s on {whole['cores']:.0f} cores, of which"
        f" {whole['wall seconds before the first job']:.0f} s passed before the first job.",
        columns=["rule", "jobs", "wall seconds, all jobs", "a job", "share of core time"],
        rows=rows,
        notes=(
            "From Snakemake's own log, whose clock has whole seconds: sums over many jobs are right on average, a"
            " single short job is not. A job that ends while Snakemake is busy counts as running until it is noticed.",
        ),
    )


def scaling_markdown(machine: Mapping[str, str], frame: pd.DataFrame) -> str:
    """Growth of the cost as one Markdown page."""
    lines = ["# Growth of the cost", "", "Measured on this machine, all in one run:", ""]
    lines += [f"* {name}: {text}" for name, text in machine.items()]
    sections = ["\n".join(lines) + "\n", exponents_page(frame).to_markdown(), large_page(frame).to_markdown()]
    return "\n".join(sections)


PARTS = {
    "states": "states of the map",
    "diameter": "states of the map",
    "library": "skills in the library",
    "tasks": "tasks learned",
}


def exponents_page(frame: pd.DataFrame) -> Page:
    """Value at both ends and exponent of every curve."""
    rows = []
    for (part, kind, quantity), curve in frame[frame["part"] != "large"].groupby(
        ["part", "kind", "quantity"], sort=False
    ):
        curve = curve.sort_values("size")
        first, last = curve.iloc[0], curve.iloc[-1]
        rows.append(
            [
                str(quantity),
                PARTS[str(part)],
                str(kind),
                f"{_quantity(first, quantity)} at {first['size']:.0f}",
                f"{_quantity(last, quantity)} at {last['size']:.0f}",
                _exponent(last),
            ]
        )
    return Page(
        title="What grows with what",
        intro="cost ∝ sizeᵖ at large sizes; p with its 95 % interval.",
        columns=["cost", "size", "map", "smallest", "largest", "exponent p"],
        rows=rows,
        notes=(
            "Least squares on logarithms from the size on that the figure's CSV names; below it constant costs hide"
            " the growth. The interval takes the scatter around the line to be noise. CPU time; least of several"
            " repeats. Memory is that beyond what the process held before.",
            "The length of a first episode is a property of the random walk, not of the code.",
            "The diameter of one closed corridor is the worst case of the exact algorithm: all states are equally far"
            " out, so it has to search from each of them. Rooms and open ground need a few dozen searches.",
        ),
        text_columns=frozenset({1, 2}),
    )


def large_page(frame: pd.DataFrame) -> Page:
    """The large map that was learned to its end."""
    part = frame[frame["part"] == "large"]
    side = int(part["size"].iloc[0])
    return Page(
        title=f"A map of {side} × {side} cells",
        intro="Two tasks of 200 episodes under PTL, learned to the end.",
        columns=["what", "value"],
        rows=[[str(row["quantity"]), _quantity(row, row["quantity"])] for _, row in part.iterrows()],
    )


def _exponent(row: pd.Series) -> str:
    if np.isnan(row["exponent"]):
        return ""
    text = f"{row['exponent']:.2f}"
    if not np.isnan(row["exponent_low"]):
        text += f" ({row['exponent_low']:.2f} to {row['exponent_high']:.2f})"
    return text.replace("-0.00", "0.00").replace("-", "−")


def _quantity(row: pd.Series, quantity: str) -> str:
    """A value with its unit; seconds in the unit that suits them."""
    value = float(row["value"])
    unit = quantity.rpartition(", ")[2]
    if unit == "s":
        for name, factor in (("s", 1.0), ("ms", 1e3), ("µs", 1e6), ("ns", 1e9)):
            if value * factor >= 1 or name == "ns":
                return f"{_significant(value * factor)} {name}"
    if unit == "MiB":
        return f"{_significant(value)} MiB"
    return f"{value:,.0f}".replace(",", " ")


def _steps(value: float) -> str:
    return _significant(value / 1e6)


def _significant(value: float) -> str:
    """Three significant digits, or all digits of a larger whole number."""
    if value == 0:
        return "0"
    return f"{value:.0f}" if abs(value) >= 100 else f"{value:.{max(0, 2 - int(np.floor(np.log10(abs(value)))))}f}"
