"""The article's claims on the skill library: its growth, and what it costs."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd
from scipy import stats

from ptl import statistics
from ptl.claims import comparisons as c
from ptl.claims.claim import claim
from ptl.claims.thresholds import FAR, GROWTH_TASKS, LINEAR_EXPONENT, OVERHEAD
from ptl.claims.verdict import Part, above, below
from ptl.evidence import SEEDS_NEEDED, Evidence, Lacking
from ptl.statistics import Estimate, named_generator

BYTES_PER_ENTRY, BYTES_PER_SUBGOAL = 1, 4
"""A policy holds one byte for each state; a subgoal is a number of four bytes."""

SIZES_NEEDED = 4
"""Sizes of a library that a power law is fitted to, at least."""


@claim(
    "growth",
    "The library grows linearly for about seven tasks and then markedly slower.",
    shown_in="figure14",
)
def growth(evidence: Evidence) -> Iterator[Part | str]:
    """Slopes of every run by least squares of a line that bends at seven tasks, as figure 14 draws it."""
    sizes = evidence.table("growth").pivot_table(index="run", columns="tasks", values="library_size")
    if sizes.isna().any(axis=None) or len(sizes) < SEEDS_NEEDED:
        raise Lacking(f"growth: {len(sizes)} whole runs, fewer than the {SEEDS_NEEDED} that a verdict needs")
    tasks, size = sizes.columns.to_numpy(float), sizes.to_numpy(float)
    half = GROWTH_TASKS // 2 + 1
    if not {0, half, GROWTH_TASKS} <= set(tasks) or tasks.max() < 2 * GROWTH_TASKS:
        raise Lacking(f"growth: lives of {tasks.max():g} tasks do not show what comes after {GROWTH_TASKS}")
    design = np.column_stack(
        [np.ones_like(tasks), np.minimum(tasks, GROWTH_TASKS), np.maximum(tasks - GROWTH_TASKS, 0)]
    )
    _, before, after = np.linalg.pinv(design) @ size.T
    at_half, at_bend = sizes[half].to_numpy(float), sizes[GROWTH_TASKS].to_numpy(float)
    early, late = at_half / half, (at_bend - at_half) / (GROWTH_TASKS - half)

    yield above(
        f"rate in tasks {half + 1}-{GROWTH_TASKS} over rate in tasks 1-{half} (linear: not markedly slower)",
        statistics.ratio_of_means(late, early, evidence.how, named_generator("growth", "linear")), 1 / FAR,
    )  # fmt: skip
    yield below(
        f"slope after {GROWTH_TASKS} tasks over slope before (markedly slower)",
        statistics.ratio_of_means(after, before, evidence.how, named_generator("growth", "slower")), 1 / FAR,
    )  # fmt: skip
    yield f"skills a task by the slope over the first {GROWTH_TASKS} tasks: {c.number(before.mean())}"
    yield (
        f"mean size {c.number(at_bend.mean())} after {GROWTH_TASKS} tasks and {c.number(size[:, -1].mean())}"
        f" after {tasks.max():g}, over {len(size)} runs"
    )


@claim(
    "selection-cost",
    "Skill selection is one loop over the skills: its time grows no faster than the library.",
    shown_in="library_cost",
)
def selection_cost(evidence: Evidence) -> Iterator[Part | str]:
    """By construction a draw weighs every skill once (`ptl.selection`); the times must not say otherwise.

    The time has a constant part, so the exponent is taken over the upper half of the sizes, and must only not
    exceed that of linear growth. The interval is that of least squares over these sizes.
    """
    cost = evidence.table("selection_cost").groupby("skills", as_index=False)["seconds"].median()
    upper = cost[cost["skills"] >= cost["skills"].median()]
    if len(upper) < SIZES_NEEDED:
        raise Lacking(f"selection cost: {len(cost)} library sizes, too few to fit a law")
    line = stats.linregress(cost["skills"], cost["seconds"] * 1e6)
    power = stats.linregress(np.log(upper["skills"]), np.log(upper["seconds"]))
    yield below("exponent over the upper half of the sizes", _slope(power, len(upper), evidence), LINEAR_EXPONENT)
    yield (
        f"a straight line over {len(cost)} sizes has {c.number(line.slope)} µs a skill and explains"
        f" {line.rvalue**2:.1%} of the variance"
    )


def _slope(fit: Any, points: int, evidence: Evidence) -> Estimate:
    reach = stats.t.ppf((1 + evidence.how.confidence) / 2, points - 2) * fit.stderr
    return Estimate(fit.slope, fit.slope - reach, fit.slope + reach)


@claim("space", "The size of the library is bounded by states times states.", shown_in="library_cost")
def space(evidence: Evidence) -> Iterator[Part | str]:
    """A skill is one entry for each state, and no two skills share a subgoal: counted, so no interval."""
    stored = evidence.table("subgoals")
    stored = stored[stored["subgoal"] >= 0]
    libraries = stored.groupby(["environment", "method", "seed"])["subgoal"]
    if not len(libraries):
        raise Lacking("no library holds a skill")
    sizes = libraries.size().reset_index(name="skills")
    sizes["states"] = [evidence.world(name).n_states for name in sizes["environment"]]
    doubles = int((libraries.size() - libraries.nunique()).sum())
    largest = float((sizes["skills"] / sizes["states"]).max())
    yield below("largest library of the run in skills a state", _exact(largest), 1.0)
    yield below("skills that share a subgoal with another one of their library", _exact(doubles), 1.0)
    yield below(
        "stored bytes over what one entry for each state and skill takes",
        _exact(_overhead(evidence)),
        OVERHEAD,
    )
    yield f"{len(sizes)} libraries of up to {sizes['skills'].max()} skills"


def _overhead(evidence: Evidence) -> float:
    """Largest share of the bytes stored in those expected; more would mean that something else grows."""
    table: pd.DataFrame = evidence.table("library_bytes")
    expected = table["skills"] * (table["states"] * BYTES_PER_ENTRY + BYTES_PER_SUBGOAL)
    return float((table["bytes"] / expected).max())


def _exact(value: float) -> Estimate:
    return Estimate(value, value, value)


CLAIMS = (growth, selection_cost, space)
