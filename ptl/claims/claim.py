"""A claim: the article's statement in our words, and the function that takes it apart and checks it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from ptl.claims.verdict import Part, Verdict, decide
from ptl.evidence import Evidence, Lacking

Check = Callable[[Evidence], Iterator[Part | str]]
"""Yields the parts of a claim, and notes (str) that help to judge it but do not enter the verdict."""


@dataclass(frozen=True)
class Claim:
    """A statement of the article and its check.

    Attributes
    ----------
    id : str
    statement : str
        The claim in our words.
    shown_in : tuple of str
        Tables and figures of the report that show it.
    check : function
    """

    id: str
    statement: str
    shown_in: tuple[str, ...]
    check: Check

    def judge(self, evidence: Evidence) -> Judgement:
        """Compare the claim with the evidence; what the evidence lacks makes it undecided."""
        try:
            found = list(self.check(evidence))
        except Lacking as lack:
            return Judgement(self, Verdict.UNDECIDED, reason=str(lack))
        parts = tuple(item for item in found if isinstance(item, Part))
        notes = tuple(item for item in found if isinstance(item, str))
        verdict = decide(parts)
        reason = "every interval reaches to both sides" if verdict is Verdict.UNDECIDED else ""
        return Judgement(self, verdict, parts, notes, reason)


@dataclass(frozen=True)
class Judgement:
    """The verdict on a claim with what it rests on; ``reason`` says why a claim is undecided."""

    claim: Claim
    verdict: Verdict
    parts: tuple[Part, ...] = ()
    notes: tuple[str, ...] = ()
    reason: str = ""


def claim(id: str, statement: str, shown_in: str) -> Callable[[Check], Claim]:
    """Make a claim out of the check below; ``shown_in`` names tables and figures, separated by spaces."""
    return lambda check: Claim(id, statement, tuple(shown_in.split()), check)
