"""The article's claims, each a small check of the run's own results beside its statement.

`comparisons` holds the measures and comparisons that checks are made of, `thresholds` what vague words mean,
`verdict` the one rule from parts to a verdict, `ledger` the pages. Add a claim by writing its check in the
file of its subject.
"""

from __future__ import annotations

from ptl.claims import curves, env1, env2, env3, library
from ptl.claims.claim import Claim, Judgement
from ptl.evidence import Evidence

CLAIMS: tuple[Claim, ...] = (*env1.CLAIMS, *env2.CLAIMS, *env3.CLAIMS, *curves.CLAIMS, *library.CLAIMS)
"""All claims in the order of the ledger."""


def judge(evidence: Evidence) -> list[Judgement]:
    """The verdict on every claim, in the order of `CLAIMS`."""
    return [claim.judge(evidence) for claim in CLAIMS]
