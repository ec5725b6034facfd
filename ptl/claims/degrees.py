"""Degrees: under which readings of its words a claim holds.

A verdict under one reading says little if another reading, just as good, gives another one. So every claim is judged
under all of its readings, and its class says how far it holds.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any

from ptl.claims.claim import Claim, Judgement
from ptl.claims.evidence import Evidence
from ptl.claims.reading import Reading, tasks_text
from ptl.claims.verdict import Outcome, Part, Verdict, decide
from ptl.measures.statistics import Resampling

EVERY, SOME, PARTLY, NONE, CONSTRUCTION, UNDECIDED = (
    "under every reading", "under some readings", "in part", "contradicted", "by construction", "undecided",
)  # fmt: skip
CLASSES = {
    EVERY: "all of it holds, however its words are read",
    SOME: "all of it holds under some readings of its words, and not under others",
    PARTLY: "some of its parts hold, but under no reading all of them",
    NONE: "none of its parts holds under any reading",
    CONSTRUCTION: "it holds whatever is learned, by a choice of this reconstruction or by definition",
    UNDECIDED: "the runs do not decide it",
}
"""Classes of claims and their meaning, from the strongest on; "by construction" says nothing about the method."""

STRICT, PLAIN = "strict", "plain"


@dataclass(frozen=True)
class Outcomes:
    """What came out under one reading: all parts hold (None: undecided), or some do.

    Attributes
    ----------
    reading : Reading
    words : str
        Whether the words are taken strictly or plainly.
    holds : bool or None
    some : bool
    """

    reading: Reading
    words: str
    holds: bool | None
    some: bool

    @classmethod
    def of(cls, reading: Reading, words: str, parts: tuple[Part, ...]) -> Outcomes:
        """Summarise the parts of a judgement."""
        verdict = decide(parts)
        holds = None if verdict is Verdict.UNDECIDED else verdict is Verdict.REPRODUCED
        return cls(reading, words, holds, any(part.outcome is Outcome.HOLDS for part in parts))


@dataclass(frozen=True)
class Degree:
    """How far a claim holds.

    Attributes
    ----------
    name : str
        One of `CLASSES`.
    when : str
        If it depends on the reading: the readings under which all of it holds.
    """

    name: str
    when: str = ""

    def __str__(self) -> str:
        return f"{self.name}: {self.when}" if self.when else self.name


def judge_all_readings(claim: Claim, evidence: Evidence) -> Iterator[tuple[Reading, Judgement]]:
    """Yield the judgement on a claim under each of its readings."""
    for reading in claim.readings():
        yield reading, claim.judge(evidence.under(reading))


def outcomes_of(judgements: Iterable[tuple[Reading, Judgement]]) -> list[Outcomes]:
    """Return what came out under each reading, with strict and with plain words."""
    found = []
    for reading, judgement in judgements:
        found.append(Outcomes.of(reading, STRICT, judgement.parts))
        if judgement.plain:
            found.append(Outcomes.of(reading, PLAIN, judgement.plain))
    return found


def degree_of(claim: Claim, outcomes: list[Outcomes]) -> Degree:
    """Return the degree of a claim from what came out under each of its readings."""
    if claim.by_construction:
        return Degree(CONSTRUCTION, claim.by_construction)
    decided = [outcome for outcome in outcomes if outcome.holds is not None]
    if not decided:
        return Degree(UNDECIDED)
    hits = [outcome for outcome in decided if outcome.holds]
    if len(hits) == len(outcomes):
        return Degree(EVERY)
    if not hits:
        return Degree(PARTLY if any(outcome.some for outcome in outcomes) else NONE)
    return Degree(SOME, "; ".join(_when(claim, outcomes, hits)))


def degrees_of(claims: Iterable[Claim], evidence: Evidence) -> list[Degree]:
    """Return the degree of each claim by the means of the runs, as if there were no more to come."""
    means = replace(evidence, how=Resampling(evidence.how.confidence, 0))
    return [degree_of(claim, outcomes_of(judge_all_readings(claim, means))) for claim in claims]


def _when(claim: Claim, outcomes: list[Outcomes], hits: list[Outcomes]) -> Iterator[str]:
    """Yield for each thing that the words leave open the values with which the claim can hold."""
    for name in claim.open_to:
        values = list(dict.fromkeys(getattr(outcome.reading, name) for outcome in outcomes))
        good = [value for value in values if any(getattr(outcome.reading, name) == value for outcome in hits)]
        if len(good) < len(values):
            yield _PHRASES[name](good)
    words = {outcome.words for outcome in hits}
    if len(words) < len({outcome.words for outcome in outcomes}):
        yield f"in {words.pop()} words"


def _on_tasks(values: list[str]) -> str:
    single = sorted(value for value in values if len(value) == 1)
    texts = [f"task{'s' if len(single) > 1 else ''} {', '.join(single)}"] if single else []
    return "on " + " and ".join(texts + [tasks_text(value) for value in values if len(value) > 1])


def _within(values: list[int]) -> str:
    least = min(values)
    return "on the very place" if least == 0 else f"within {least} step{'s' if least > 1 else ''} of the place"


def _at_runs(values: list[int | None]) -> str:
    [runs] = values
    return "in the limit of many runs" if runs is None else f"at {runs} runs"


_PHRASES: dict[str, Callable[[list[Any]], str]] = {"tasks": _on_tasks, "tolerance": _within, "runs": _at_runs}
