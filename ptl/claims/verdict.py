"""From parts to a verdict: the one rule that all claims share.

A claim consists of parts. A part compares one estimate with what the claim demands, by its interval:

* it *holds* if the whole interval agrees with the claim;
* it *fails* if the whole interval is elsewhere;
* it is *at the bound* if the interval extends to both sides of a bound, but nowhere further from it than the
  resolution, `RESOLUTION` of the part's scale: more runs would hardly distinguish the value from the bound;
* it is *open* if the interval extends further; more runs could decide it.

The scale is the bound itself, or where the bound is 0 the mean of what the estimate is a difference to (1 for shares
and ratios).

A part that denies significance ("whose deviation is too high") is the exception: it fails if the whole
interval is above 0, and holds otherwise.

The verdict:

* **reproduced** if every part holds;
* **partly reproduced** if some parts hold and others do not;
* **not reproduced** if no part holds and at least one fails or is at the bound;
* **undecided** if all parts are open, or the evidence that the claim needs is missing or from fewer than ten seeds.

So a part at the bound never counts for a claim: with it a claim is at most partly reproduced.

Where a claim's words admit two readings, it has parts of both: those of the *strict* reading, which alone enter the
verdict, and those of the *plain* one, which give a second verdict.

A claim with a number ("improves by more than 90%") has two parts, the direction and the size, so that the
right direction with another size is "partly reproduced". Parts are not corrected for their number: with many
parts, a few may miss by chance, and the ledger names them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

from ptl import text as texts
from ptl.measures.statistics import Estimate
from ptl.text import number

RESOLUTION = 0.2
"""Share of a part's scale that counts as negligible: a fifth, as for "not improved" (our choice)."""


class Outcome(StrEnum):
    """Result of one part."""

    HOLDS = "holds"
    FAILS = "fails"
    AT_BOUND = "at the bound"
    OPEN = "open"


class Verdict(StrEnum):
    """Result of a claim, from the most favourable on."""

    REPRODUCED = "reproduced"
    PARTLY = "partly reproduced"
    NOT = "not reproduced"
    UNDECIDED = "undecided"


@dataclass(frozen=True)
class Part:
    """One comparison.

    Attributes
    ----------
    text : str
        Name of the estimate.
    estimate : Estimate
    demand : str
        Range of the estimate that the claim demands.
    outcome : Outcome
    unit : str
    plain : bool
        Whether it belongs to the plain reading of a claim that has a strict one too.
    uses : set of (str, str)
        Environments and methods whose runs enter it.
    """

    text: str
    estimate: Estimate
    demand: str
    outcome: Outcome
    unit: str = ""
    plain: bool = False
    uses: frozenset[tuple[str, str]] = frozenset()

    def __str__(self) -> str:
        e = self.estimate
        return f"{self.text}: {texts.estimate(e.value, e.low, e.high, self.unit)} ({self.demand}: {self.outcome})"


def above(text: str, estimate: Estimate, bound: float, unit: str = "", scale: float = 1.0) -> Part:
    """Return the part that claims that the estimate is greater than a bound; ``scale`` counts where that is 0."""
    return Part(text, estimate, f"> {number(bound)}", _inside(estimate, bound, math.inf, scale), unit)


def below(text: str, estimate: Estimate, bound: float, unit: str = "", scale: float = 1.0) -> Part:
    """Return the part that claims that the estimate is less than a bound; ``scale`` counts where that is 0."""
    return Part(text, estimate, f"< {number(bound)}", _inside(estimate, -math.inf, bound, scale), unit)


def between(text: str, estimate: Estimate, low: float, high: float, unit: str = "") -> Part:
    """Return the part that claims that the estimate is between two bounds."""
    return Part(text, estimate, f"{number(low)} to {number(high)}", _inside(estimate, low, high), unit)


def not_significant(text: str, estimate: Estimate, unit: str = "") -> Part:
    """Return the part that denies that a difference is significantly positive; open only without an interval."""
    outcome = Outcome.FAILS if estimate.low > 0 else Outcome.HOLDS
    if math.isnan(estimate.low):
        outcome = Outcome.OPEN
    return Part(text, estimate, "not significantly > 0", outcome, unit)


def _inside(estimate: Estimate, low: float, high: float, scale: float = 1.0) -> Outcome:
    if math.isnan(estimate.low) or math.isnan(estimate.high):
        return Outcome.OPEN
    if low < estimate.low and estimate.high < high:
        return Outcome.HOLDS
    if estimate.high <= low or estimate.low >= high:
        return Outcome.FAILS
    crossed = [bound for bound in (low, high) if estimate.low <= bound <= estimate.high]
    if any(max(estimate.high - bound, bound - estimate.low) <= RESOLUTION * (abs(bound) or scale) for bound in crossed):
        return Outcome.AT_BOUND
    return Outcome.OPEN


def in_plain_reading(part: Part) -> Part:
    """Return the part as one of the plain reading of its claim."""
    return replace(part, plain=True)


def decide(parts: Sequence[Part]) -> Verdict:
    """Return the verdict on a claim from all its parts, by the rule above."""
    outcomes = {part.outcome for part in parts}
    if outcomes == {Outcome.HOLDS}:
        return Verdict.REPRODUCED
    if Outcome.HOLDS in outcomes:
        return Verdict.PARTLY
    return Verdict.NOT if outcomes & {Outcome.FAILS, Outcome.AT_BOUND} else Verdict.UNDECIDED
