"""What the README says of the second study."""

from __future__ import annotations

from pathlib import Path

from ptl.files.csv import read_csv
from ptl.text import number
from ptl.world.mazes import FAMILIES

MODEL = "rmax_memory"
"""The learner with a kept model."""


def against_a_model(published: Path) -> str:
    """Return what the learner with a model costs beside PTL, in a sentence on one line."""
    ratios = read_csv(published.parent / "beyond/ratios.csv")
    own = ratios[(ratios["method"] == MODEL) & ratios["family"].isin(FAMILIES)]["ratio"]
    low, high = number(round(own.min(), 2)), number(round(own.max(), 2))
    return (
        f"**And beside other methods?** On the {len(own)} families of generated maps of the"
        " [second study](studies/beyond/README.md), a learner that remembers every transition and plans with them"
        f" (R-max with a kept model) takes {low} to {high} times as many steps as PTL. Where such a memory is"
        " allowed, a skill library is not the best that can be done on maps of this size."
    )


PARTS = {"second study": against_a_model}
