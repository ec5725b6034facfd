"""The gain of policy reuse in Fernandez and Veloso's experiment as a table, with their values."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pandas as pd

from ptl.measures.sample_size import MIN_FOR_INTERVAL
from ptl.measures.statistics import Resampling, mean, named_generator
from ptl.report.table import Table, text_table
from ptl.text import MISSING, interval, number, percent
from studies.fv_check.experiment import MAX_STEPS, NEW_TASK, STREAM
from studies.fv_check.jobs import Gains

DIFFERENCES = (
    "The source's agent moves in continuous space with noise on its position; ours moves from cell to cell without"
    " noise.",
    "Published values are read off a figure of the source (about ±0.01).",
    "The policies of the library are learned in the same setting by plain Q-learning (ε-greedy, ε = 0.1) over"
    " {library_trials} trials, anew for every seed (our choice); their mean gain in their own tasks, as a"
    " share of the optimum, is in the column “library quality”.",
    "Where a past policy's values are all equal (never informed) the new policy acts (our choice).",
    "A start is drawn uniformly from all cells but the goal (our choice).",
    "Plain Q-learning is our method “no transfer” with ε = 0.1; the source's explores by other schedules.",
)
"""Known differences from the source, printed under the table."""


def gain_frame(gains: Iterable[Gains], how: Resampling) -> pd.DataFrame:
    """Compute the mean gain over all trials, one row a library.

    Columns name, library, trials, seeds, gain, ci_low, ci_high, std, published, difference, library_quality (mean over
    seeds and policies).
    """
    rows = []
    for item in gains:
        final = item.gain.mean(axis=1)
        estimate = mean(final, how, named_generator(STREAM, item.library.name, "gain"))
        published = np.nan if item.library.published is None else item.library.published
        rows.append(
            {
                "name": item.library.name,
                "library": item.library.label,
                "trials": item.gain.shape[1],
                "seeds": len(final),
                "gain": estimate.value,
                "ci_low": estimate.low,
                "ci_high": estimate.high,
                "std": final.std(ddof=1) if len(final) > 1 else np.nan,
                "published": published,
                "difference": estimate.value - published,
                "library_quality": item.quality.mean() if item.quality.size else np.nan,
            }
        )
    return pd.DataFrame(rows)


def agreement(frame: pd.DataFrame) -> str:
    """Return how our gains compare with the published ones, computed from the frame."""
    beside = frame.dropna(subset=["published"])
    pairs = [f"{row.library}: {number(row.gain)} against {number(row.published)}" for row in beside.itertuples()]
    within = int(beside["published"].between(beside["ci_low"], beside["ci_high"]).sum())
    inside = f"{within} of {len(beside)} published values lie in our interval"
    if beside["ci_low"].isna().any():
        inside = f"With fewer than {MIN_FOR_INTERVAL} seeds there is no interval that could hold a published value"
    least = "the same" if beside["gain"].idxmin() == beside["published"].idxmin() else "another"
    sentences = [
        f"Ours against published: {'; '.join(pairs)}.",
        f"{inside}; the library that gains least is {least}.",
    ]
    if within < len(beside):
        sentences.append("So this check does not show that our policy reuse behaves as its authors' does.")
    return " ".join(sentences)


def gain_table(frame: pd.DataFrame, confidence: float, library_trials: int) -> Table:
    """Lay out the frame of `gain_frame`.

    Parameters
    ----------
    library_trials : int
        Trials in which each policy of a library was learned.
    """
    first = frame.iloc[0]
    rows = [
        (
            row.library,
            number(row.gain),
            interval(row.ci_low, row.ci_high) or MISSING,
            number(row.published),
            number(row.library_quality),
        )
        for row in frame.itertuples()
    ]
    return text_table(
        "Policy reuse in the experiment of Fernandez and Veloso",
        f"Mean gain W over {number(first['trials'])} trials on their task Ω (goal {NEW_TASK} of environment 3), mean of"
        f" {first['seeds']} seeds; random starts, at most {MAX_STEPS} steps a trial. The learner is that of the main"
        " comparison.",
        ("library", "gain", f"{percent(confidence)} interval", "published", "library quality"),
        rows,
        (
            agreement(frame),
            "Known differences from the source:",
            *(text.format(library_trials=number(library_trials)) for text in DIFFERENCES),
        ),
    )
