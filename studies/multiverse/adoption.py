"""Which way to use a skill makes most of the article's sentences hold together, by a rule fixed beforehand.

The rule (chosen before any setting was learned):

1. In every drawn setting, take the share of the claims in `ABOUT_PTL` that hold, each read on tasks B to F together
   where it leaves the task open. The way with the highest mean share is adopted.
2. Ways whose mean is less than two standard errors of the difference below it are not told apart: of these, the one
   that needs fewer choices made by fit, then the first in the order of the study's file, simplest first.

The rule compares ways to use a skill over all that else is unknown, so no drawing or width enters by its fit. Claims
that were added later (E2-unknown, E3-recovery) do not enter.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from ptl.claims.reading import TRANSFER_TASKS
from studies.multiverse.judging import JUDGED
from studies.multiverse.shares import drawn, held

UNKNOWN = "skills.skill_use"

ABOUT_PTL = (
    "E1-all", "E1-jump", "E1-asymptotic", "E1-80", "E1-total", "E1-unknown", "E2-all", "E2-converge", "E3-jump",
    "E3-threshold", "E3-ratio", "E3-few",
)  # fmt: skip
"""Claims on what PTL saves; the others are about subgoals, other methods or the library's growth."""


def way_table(verdicts: pd.DataFrame, changes: Mapping[str, Mapping[str, Any]]) -> pd.DataFrame:
    """Return how many claims hold with each way to use a skill.

    Parameters
    ----------
    changes : mapping
        Unknowns with their values of each setting.

    Returns
    -------
    DataFrame
        Columns way, settings, mean (share of the claims that hold), error (its standard error), half (share of settings
        in which at least half hold), and the share of settings in which each claim of `ABOUT_PTL` holds.
    """
    table = held(drawn(verdicts), TRANSFER_TASKS, [claim for claim in JUDGED if claim.id in ABOUT_PTL])
    ways = pd.Series({setting: changes[str(setting)][UNKNOWN] for setting in table.index})
    rows = []
    for way, part in table.groupby(ways, sort=False):
        share = part.mean(axis=1)
        rows.append(
            {
                "way": way,
                "settings": len(part),
                "mean": share.mean(),
                "error": share.std(ddof=1) / np.sqrt(len(part)),
                "half": (share >= 0.5).mean(),
                **part.mean().to_dict(),
            }
        )
    return pd.DataFrame(rows)


def adopted(ways: pd.DataFrame, order: Sequence[str]) -> tuple[str, list[str]]:
    """Return the way that the rule adopts, and all ways that its mean does not tell apart from the best.

    No way needs a choice by fit of its own, so the order of the study's file decides among these.
    """
    best = ways.loc[ways["mean"].idxmax()]
    errors = np.hypot(ways["error"], best["error"])
    level = ways[best["mean"] - ways["mean"] < 2 * errors]["way"].tolist()
    names = sorted({*level, str(best["way"])}, key=list(order).index)
    return names[0], names
