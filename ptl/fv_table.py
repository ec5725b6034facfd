"""The gain of policy reuse in Fernandez and Veloso's experiment as a table, beside their values."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pandas as pd

from ptl.fv_experiment import LIBRARY_TRIALS, MAX_STEPS, NEW_TASK, Gains
from ptl.pages import Page
from ptl.statistics import Resampling, mean, named_generator

DIFFERENCES = (
    "The source's agent moves in continuous space with noise on its position; ours moves from cell to cell"
    " without any. An independent prototype of ours without noise gave 0.22, 0.31 and 0.32 for the three"
    " libraries.",
    "Published values are read off a figure of the source (about ±0.01).",
    "The policies of the library are learned in the same setting by plain Q-learning (ε-greedy, ε = 0.1)"
    f" over {LIBRARY_TRIALS} trials, anew for every seed (our choice); their mean gain in their own tasks, as"
    " a share of the optimum, is in the column “library quality”.",
    "Where a past policy's values are all equal (never informed) the new policy acts (our choice).",
    "A start is drawn uniformly from all cells but the goal (our choice).",
    "Plain Q-learning is our method “no transfer” with ε = 0.1; the source's explores by other schedules.",
)
"""Known differences from the source, printed under figure and table."""


def gain_table(gains: Iterable[Gains], how: Resampling) -> pd.DataFrame:
    """Mean gain over all trials, one row an arm.

    Columns arm, library, trials, seeds, gain, ci_low, ci_high, std, published, difference, library_quality
    (mean over seeds and policies).
    """
    rows = []
    for item in gains:
        final = item.gain.mean(axis=1)
        estimate = mean(final, how, named_generator("fernandez_veloso", item.arm.name, "gain"))
        published = np.nan if item.arm.published is None else item.arm.published
        rows.append(
            {
                "arm": item.arm.name,
                "library": item.arm.label,
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


def gain_page(table: pd.DataFrame, confidence: float) -> Page:
    """The table of `gain_table` as a page."""
    rows = []
    for row in table.itertuples():
        interval = "–" if np.isnan(row.ci_low) else f"{row.ci_low:.3f} to {row.ci_high:.3f}"
        published = "–" if np.isnan(row.published) else f"{row.published:.3g}"
        quality = "–" if np.isnan(row.library_quality) else f"{row.library_quality:.2f}"
        rows.append((row.library, f"{row.gain:.3f}", interval, published, quality))
    first = table.iloc[0]
    return Page(
        "Policy reuse in the experiment of Fernandez and Veloso",
        f"Mean gain W over {first['trials']} trials on their task Ω (goal {NEW_TASK} of environment 3),"
        f" mean of {first['seeds']} seeds; random starts, at most {MAX_STEPS} steps a trial. The learner"
        " is the one of the main comparison.",
        ("library", "gain", f"{100 * confidence:g} % interval", "published", "library quality"),
        rows,
        ("Known differences from the source:", *DIFFERENCES),
    )
