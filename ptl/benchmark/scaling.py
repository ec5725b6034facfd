"""How the cost grows with the states of a map, the skills of a library and the tasks of a life."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from scipy import stats

from ptl.benchmark.surveys import EVERY_STEP, TREES

COLUMNS = ["part", "kind", "size", "quantity", "value", "exponent", "exponent_low", "exponent_high", "fitted_from"]


@dataclass(frozen=True)
class Plan:
    """Sizes to measure.

    Attributes
    ----------
    states, ring, skills : sequences of int
        States of chains of rooms and of random rooms, states of rings, skills of a library.
    tasks : int
        Tasks of the one life.
    large : int
        Cells each way of the map that is learned to the end.
    library_states : int
        States of the map on which the library is measured.
    larger : sequence of int
        States of random rooms and mazes on which the survey of subgoals and lives of ten tasks are measured.
    starts, goals, lives : int
        What is measured there is a sample: starts of the survey with every step simulated, goals of the survey with
        trees, and lives, each divided by the number of states, but 3 at least.
    fit_states, fit_larger, fit_skills, fit_tasks : int
        Exponents are fitted from these sizes on; below them constant costs hide the growth.
    """

    states: Sequence[int] = (100, 300, 1000, 3000, 10_000, 30_000, 100_000)
    ring: Sequence[int] = (1000, 2000, 3900)
    skills: Sequence[int] = (1, 3, 10, 30, 100, 200, 500, 1000)
    tasks: int = 1000
    large: int = 300
    library_states: int = 2000
    larger: Sequence[int] = (300, 1000, 3000, 10_000)
    starts: int = 60_000
    goals: int = 40_000
    lives: int = 30_000
    fit_states: int = 1000
    fit_larger: int = 900
    fit_skills: int = 100
    fit_tasks: int = 10


def measure(map_path: Path, plan: Plan, say: Callable[[str], None] = lambda _: None) -> pd.DataFrame:
    """Make all measurements of a plan, each in a process of its own.

    Parameters
    ----------
    map_path : path
        Map of the life of many tasks.
    say : callable
        Told what is being measured.

    Returns
    -------
    DataFrame
        Columns `COLUMNS`: ``part`` (states, diameter, library, tasks, large, survey, life), ``kind`` of map, ``size``,
        ``quantity`` with its unit, ``value``, and the exponent of the power law that was fitted with its 95% interval,
        empty where none is.
    """
    jobs: list[tuple[str, str, int, list[str]]] = []
    for kind in ("chain", "rooms"):
        jobs += [("states", kind, size, [kind, str(size)]) for size in plan.states]
    jobs += [("diameter", "ring", size, ["ring", str(size)]) for size in plan.ring]
    jobs += [("library", "rooms", size, [str(size), str(plan.library_states)]) for size in plan.skills]
    jobs.append(("tasks", map_path.stem, plan.tasks, [str(map_path), str(plan.tasks)]))
    jobs.append(("large", "rooms", plan.large, [str(plan.large)]))
    for kind in ("rooms", "maze"):
        for size in plan.larger:
            starts, goals, lives = (str(max(3, effort // size)) for effort in (plan.starts, plan.goals, plan.lives))
            jobs += [
                ("survey", kind, size, [kind, str(size), EVERY_STEP, starts]),
                ("survey", kind, size, [kind, str(size), TREES, goals]),
                ("life", kind, size, [kind, str(size), lives]),
            ]
    rows = []
    for part, kind, size, arguments in jobs:
        say(f"{part} {kind} {size}")
        records = probe(part, *arguments)
        known = {record["quantity"]: record["value"] for record in records}
        for record in records:
            if record["quantity"] == "states" and part != "large":
                continue
            # maps come in steps, so a size is what it turned out to be
            real_size = record.get("size", size if part == "large" else known.get("states", size))
            row = {"quantity": record["quantity"], "value": record["value"]}
            rows.append({"part": part, "kind": kind, "size": real_size, **row})
    return with_exponents(pd.DataFrame(rows), plan)


def probe(kind: str, *arguments: str) -> list[dict]:
    """Run `ptl.benchmark.probes` in a process of its own."""
    command = [sys.executable, "-m", "ptl.benchmark.probes", kind, *arguments]
    done = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True)
    return json.loads(done.stdout)


def with_exponents(measured: pd.DataFrame, plan: Plan) -> pd.DataFrame:
    """Add the exponent of each curve to its rows."""
    first = {
        "states": plan.fit_states,
        "diameter": plan.fit_states,
        "library": plan.fit_skills,
        "tasks": plan.fit_tasks,
        "survey": plan.fit_larger,
        "life": plan.fit_larger,
    }
    parts = []
    for (part, _, _), curve in measured.groupby(["part", "kind", "quantity"], sort=False):
        high_end = curve[curve["size"] >= first.get(part, np.inf)]
        curve = curve.assign(exponent=np.nan, exponent_low=np.nan, exponent_high=np.nan, fitted_from=np.nan)
        if len(high_end) >= 2 and (high_end["value"] > 0).all():
            exponent, low, high = power_law(high_end["size"].to_numpy(), high_end["value"].to_numpy())
            curve = curve.assign(
                exponent=exponent, exponent_low=low, exponent_high=high, fitted_from=high_end["size"].min()
            )
        parts.append(curve)
    return pd.concat(parts, ignore_index=True)[COLUMNS]


def power_law(sizes: np.ndarray, values: np.ndarray, confidence: float = 0.95) -> tuple[float, float, float]:
    """Exponent of the power law through positive values with its interval.

    Least squares on logarithms; the interval is Student's, which takes the scatter around the line to be noise. With
    two points there is no scatter and the interval is empty (nan).
    """
    fit = stats.linregress(np.log(sizes), np.log(values))
    if len(sizes) < 3:
        return float(fit.slope), np.nan, np.nan
    half = stats.t.ppf((1 + confidence) / 2, len(sizes) - 2) * fit.stderr
    return float(fit.slope), float(fit.slope - half), float(fit.slope + half)


def size_at(curve: pd.DataFrame, value: float) -> tuple[float, bool]:
    """Return the size at which a growing cost passes a value, and whether that lies within the measured sizes.

    Between two measured sizes by a straight line on logarithms; outside by the power law with the curve's exponent
    through the mean of the logarithms it was fitted to.

    Parameters
    ----------
    curve : DataFrame
        Rows of one quantity from `with_exponents`.
    """
    curve = curve.sort_values("size")
    sizes, values = np.log(curve["size"].to_numpy(float)), np.log(curve["value"].to_numpy(float))
    if values[0] <= np.log(value) <= values[-1]:
        return float(np.exp(np.interp(np.log(value), values, sizes))), True
    fitted = curve["size"].to_numpy() >= curve["fitted_from"].iloc[0]
    ahead = (np.log(value) - values[fitted].mean()) / curve["exponent"].iloc[0]
    return float(np.exp(sizes[fitted].mean() + ahead)), False
