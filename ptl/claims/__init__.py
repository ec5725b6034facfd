"""The article's claims, each checked against the results of a run.

`comparisons` holds the measures and comparisons that checks are made of, `thresholds` the meaning of vague words,
`verdict` the one rule from parts to a verdict. To add a claim, write its check, decorated with `claim`, in the module
of its subject.
"""

from __future__ import annotations

from ptl.claims import curves, env1, env2, env3, library
from ptl.claims.claim import Claim, Judgement
from ptl.claims.evidence import Evidence

CLAIMS: tuple[Claim, ...] = tuple(
    item for module in (env1, env2, env3, curves, library) for item in vars(module).values() if isinstance(item, Claim)
)
"""All claims in the order of the ledger: by module, then as they are defined."""


def judge(evidence: Evidence) -> list[Judgement]:
    """Return the verdict on every claim, in the order of `CLAIMS`."""
    return [claim.judge(evidence) for claim in CLAIMS]
