"""The article's claims on learning curves, over several environments."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ptl.claims import comparisons as c
from ptl.claims.claim import claim
from ptl.claims.evidence import Evidence, MissingEvidence
from ptl.claims.thresholds import MAJORITY, SPIKE
from ptl.claims.verdict import Part, above, in_plain_reading
from ptl.measures import statistics
from ptl.measures.statistics import named_generator

ENVIRONMENTS = ("env1", "env2", "env3")
"""The article's environments."""


def blocks(curve: np.ndarray, length: int) -> np.ndarray:
    """Return the mean steps in each block of episodes, float array (seeds, blocks); a shorter rest is left out."""
    whole = curve.shape[1] // length * length
    return curve[:, :whole].reshape(len(curve), -1, length).mean(axis=2)


def spikes(curve: np.ndarray, length: int) -> np.ndarray:
    """Count the episodes of each seed that are far longer than the ``length`` before, int array (seeds,)."""
    if curve.shape[1] <= length:
        raise MissingEvidence(f"no episode comes after the first {length} (measures.window)")
    before = np.lib.stride_tricks.sliding_window_view(curve[:, :-1], length, axis=1)
    return np.count_nonzero(curve[:, length:] >= SPIKE * np.median(before, axis=2), axis=1)


@claim(
    "curves",
    "In environments 1 and 2 the learning curve of PTL on task F lies below that of every other method.",
    shown_in="figure12",
)
def below_all_others(evidence: Evidence) -> Iterator[Part | str]:
    """Yield one part for each environment, other method and block of episodes; by the plain reading, for the whole."""
    for environment in ("env1", "env2"):
        for other in c.OTHERS:
            own, theirs = evidence.curves(environment, (c.PTL, other), c.LAST_TASK)
            their_blocks = blocks(theirs, evidence.window)
            saved = their_blocks - blocks(own, evidence.window)
            for index, values in enumerate(saved.T):
                first, last = index * evidence.window + 1, (index + 1) * evidence.window
                generator = named_generator(environment, other, c.PTL, "curves", index)
                estimate = statistics.mean(values, evidence.how, generator)
                scale = float(their_blocks[:, index].mean())
                text = f"{environment}, episodes {first}-{last}, {other} minus ptl"
                yield above(text, estimate, 0.0, "steps", scale)
            whole = c.saves(evidence, environment, c.PTL, other, "total_steps", c.LAST_TASK)
            yield in_plain_reading(replace(whole, text=f"{environment}, all episodes, {other} minus {c.PTL}"))
            below = int((theirs.mean(axis=0) > own.mean(axis=0)).sum())
            yield f"{environment}: the mean is below that of {other} in {below} of {own.shape[1]} episodes"


@claim(
    "reuse-spikes",
    "Policy reuse degrades in some episodes: most runs have spikes, and they are more than those of learning"
    " without transfer.",
    shown_in="figure12",
)
def reuse_spikes(evidence: Evidence) -> Iterator[Part]:
    """Compare task F of each environment; a spike is relative to the episodes just before it."""
    for environment in ENVIRONMENTS:
        curves = evidence.curves(environment, (c.REUSE, c.BASE), c.LAST_TASK)
        reuse, base = (spikes(curve, evidence.window) for curve in curves)
        yield above(f"{environment}, share of runs of {c.REUSE} with a spike", c.share(evidence, reuse > 0), MAJORITY)
        generator = named_generator(environment, c.REUSE, "spikes")
        more = statistics.mean_difference(reuse, base, evidence.how, generator)
        yield above(f"{environment}, spikes a run, {c.REUSE} minus {c.BASE}", more, 0.0)
