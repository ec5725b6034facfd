"""The article's claims on the skill library: its growth and its cost."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy import stats

from ptl.claims.claim import claim
from ptl.claims.evidence import MIN_SEEDS, Evidence, MissingEvidence
from ptl.claims.thresholds import ABOUT, FAR, LINEAR_EXPONENT, OVERHEAD
from ptl.claims.verdict import Part, above, below, between
from ptl.measures import statistics
from ptl.measures.growth import best_bend, fit_saturation, fit_two_slopes, squared_error
from ptl.measures.statistics import Estimate, exactly, named_generator
from ptl.text import number, percent

BYTES_PER_ENTRY, BYTES_PER_SUBGOAL = 1, 4
"""A policy takes one byte for each state, a subgoal four bytes."""

MIN_SIZES = 4
"""Minimum number of library sizes for the fit of a power law."""


@claim(
    "growth",
    "The library grows linearly for about seven tasks and then markedly slower.",
    shown_in="figure14",
)
def growth(evidence: Evidence) -> Iterator[Part | str]:
    """Compare the slopes of every run, by the fit of figure 14, and the rates in both halves before its bend.

    A line with a bend must also fit better than a curve without one, and with its bend where the article has it.
    """
    size = evidence.needed("growth")
    if len(size) < MIN_SEEDS:
        raise MissingEvidence(f"growth: {len(size)} runs, fewer than the {MIN_SEEDS} that a verdict needs")
    bend, last = evidence.breakpoint, size.shape[1] - 1
    if bend < 2 or last < 2 * bend:
        raise MissingEvidence(f"growth: lives of {last} tasks do not show a bend after {bend} (growth.breakpoint)")
    half = (bend + 1) // 2
    line = fit_two_slopes(size, bend)
    early, late = size[:, half] / half, (size[:, bend] - size[:, half]) / (bend - half)

    yield above(
        f"rate in tasks {half + 1}-{bend} over rate in tasks 1-{half} (linear: not markedly slower)",
        statistics.ratio_of_means(late, early, evidence.how, named_generator("growth", "linear")),
        1 / FAR,
    )
    yield below(
        f"slope after {bend} tasks over slope before (markedly slower)",
        statistics.ratio_of_means(line.after, line.before, evidence.how, named_generator("growth", "slower")),
        1 / FAR,
    )
    yield between(
        f"bend at which two slopes fit best (about {bend})",
        statistics.of_mean_curve(best_bend, size, evidence.how, named_generator("growth", "bend")),
        bend * (1 - ABOUT),
        bend * (1 + ABOUT),
        "tasks",
    )
    yield above(
        "squared error of a saturating curve, without a bend, over that of two slopes",
        statistics.of_mean_curve(_rivalry, size, evidence.how, named_generator("growth", "saturation")),
        1.0,
    )
    yield f"skills a task by the slope over the first {bend} tasks: {number(line.before.mean())}"
    yield (
        f"mean size {number(size[:, bend].mean())} after {bend} tasks and {number(size[:, -1].mean())} after {last},"
        f" over {len(size)} runs"
    )


def _rivalry(size: np.ndarray) -> float:
    """Return how much worse a saturating curve fits than two slopes with a free bend."""
    two_slopes = fit_two_slopes(size, best_bend(size))
    return squared_error(size, fit_saturation(size)) / max(squared_error(size, two_slopes), 1e-9)


@claim(
    "selection-cost",
    "Skill selection is one loop over the skills: its cost grows no faster than the library.",
    shown_in="library_cost",
    by_construction="the loop whose operations are counted is ours",
)
def selection_cost(evidence: Evidence) -> Iterator[Part | str]:
    """Fit a power law to the operations counted in the upper half of the sizes.

    The cost has a constant part, hence the upper half. The interval is that of least squares over these sizes.
    """
    cost = evidence.needed("selection_cost")
    upper = cost[cost["skills"] >= cost["skills"].median()]
    if len(upper) < MIN_SIZES:
        raise MissingEvidence(f"selection cost: {len(cost)} library sizes, too few to fit a law")
    power = stats.linregress(np.log(upper["skills"]), np.log(upper["operations"]))
    reach = stats.t.ppf((1 + evidence.how.confidence) / 2, len(upper) - 2) * power.stderr
    exponent = Estimate(power.slope, power.slope - reach, power.slope + reach)
    yield below("exponent over the upper half of the sizes", exponent, LINEAR_EXPONENT)
    line = stats.linregress(cost["skills"], cost["operations"])
    yield (
        f"a straight line over {len(cost)} sizes has {number(line.slope)} operations a skill and explains"
        f" {percent(line.rvalue**2)} of the variance"
    )


@claim(
    "space",
    "The size of the library is bounded by states times states.",
    shown_in="library_cost",
    by_construction="a library has at most one skill for each state",
)
def space(evidence: Evidence) -> Iterator[Part | str]:
    """Count the skills of every library, those that share a subgoal, and stored bytes; there is no interval."""
    stored = evidence.needed("subgoals")
    libraries = stored[stored["subgoal"] >= 0].groupby(["environment", "method", "seed"])["subgoal"]
    if not len(libraries):
        raise MissingEvidence("no library holds a skill")
    sizes = libraries.size().reset_index(name="skills")
    sizes["states"] = [evidence.world(name).n_states for name in sizes["environment"]]
    doubles = int((libraries.size() - libraries.nunique()).sum())
    largest = float((sizes["skills"] / sizes["states"]).max())
    # more bytes than this would mean that something else grows
    storage = evidence.needed("library_bytes")
    expected = storage["skills"] * (storage["states"] * BYTES_PER_ENTRY + BYTES_PER_SUBGOAL)
    overhead = float((storage["bytes"] / expected).max())
    yield below("largest library of the run in skills a state", exactly(largest), 1.0)
    yield below("skills that share a subgoal with another one of their library", exactly(doubles), 1.0)
    yield below("stored bytes over one entry for each state and skill", exactly(overhead), OVERHEAD)
    yield f"{len(sizes)} libraries of up to {sizes['skills'].max()} skills"
