"""A claim: the article's statement in our words, and the function that checks it part by part."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

from ptl.claims.evidence import Evidence, MissingEvidence
from ptl.claims.reading import Reading, readings
from ptl.claims.verdict import Part, Verdict, decide

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
    open_to : tuple of str
        Fields of `ptl.claims.reading.Reading` that the statement leaves open.
    by_construction : str
        Why the claim holds whatever is learned, if it does.
    """

    id: str
    statement: str
    shown_in: tuple[str, ...]
    check: Check
    open_to: tuple[str, ...] = ()
    by_construction: str = ""

    def readings(self) -> Iterator[Reading]:
        """Yield the readings under which the statement can be judged."""
        yield from readings(self.open_to)

    def judge(self, evidence: Evidence) -> Judgement:
        """Return the verdict on the claim; it is undecided if evidence is missing."""
        try:
            items = list(self._items(evidence))
        except MissingEvidence as lack:
            return Judgement(self, Verdict.UNDECIDED, reason=str(lack))
        parts = tuple(item for item in items if isinstance(item, Part) and not item.plain)
        plain = tuple(item for item in items if isinstance(item, Part) and item.plain)
        notes = tuple(item for item in items if isinstance(item, str))
        return Judgement(self, decide(parts), parts, notes, plain=plain)

    def _items(self, evidence: Evidence) -> Iterator[Part | str]:
        """Yield the parts and notes; a part uses the runs asked for since the one before, and before the first.

        A part for which nothing was asked for was made from the runs of the one before.
        """
        first: frozenset[tuple[str, str]] | None = None
        used: frozenset[tuple[str, str]] = frozenset()
        evidence.used.clear()
        for item in self.check(evidence):
            used = frozenset(evidence.used) or used
            first = used if first is None else first
            yield replace(item, uses=first | used) if isinstance(item, Part) else item
            evidence.used.clear()


@dataclass(frozen=True)
class Judgement:
    """The verdict on a claim with its parts and notes; ``reason`` names the missing evidence.

    ``parts`` and ``verdict`` follow the strict reading of the claim, ``plain`` and ``plain_verdict`` the plain one, if
    its words admit both.
    """

    claim: Claim
    verdict: Verdict
    parts: tuple[Part, ...] = ()
    notes: tuple[str, ...] = ()
    reason: str = ""
    plain: tuple[Part, ...] = ()

    @property
    def plain_verdict(self) -> Verdict | None:
        """The verdict by the plain reading, None if the claim has one reading only."""
        return decide(self.plain) if self.plain else None


def claim(
    id: str, statement: str, shown_in: str, open_to: str = "", by_construction: str = ""
) -> Callable[[Check], Claim]:
    """Return a decorator that makes a claim of its check; ``shown_in`` and ``open_to`` are names in one text."""
    return lambda check: Claim(id, statement, tuple(shown_in.split()), check, tuple(open_to.split()), by_construction)
