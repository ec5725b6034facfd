"""Comparison of the article's statements with the run's numbers, from the ledger."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd

from ptl.claims.verdict import Outcome
from ptl.report.ledger import FITTED, class_text, in_words
from ptl.report.table import Table, text_table
from ptl.text import estimate

MAX_COMPARISONS = 6
"""Maximum number of comparisons shown for one claim; those that do not hold come first."""

ORDER = [str(outcome) for outcome in (Outcome.FAILS, Outcome.AT_BOUND, Outcome.OPEN, Outcome.HOLDS)]


def differences_table(claims: pd.DataFrame, parts: pd.DataFrame, names: Mapping[str, str] | None = None) -> Table:
    """Lay out the article's statement, the run's numbers, the class and the verdicts for every claim.

    Parameters
    ----------
    claims : DataFrame
        Ledger: columns id, claim, class, holds_when, verdict, verdict_30, verdict_plain, evidence.
    parts : DataFrame
        Parts of the ledger: columns id, part, estimate, low, high, unit, demand, outcome.
    names : mapping, optional
        Name for readers of each method and environment.
    """
    rows = []
    for claim in claims.to_dict("records"):
        own = parts[parts["id"] == claim["id"]].assign(order=lambda frame: frame["outcome"].map(ORDER.index))
        own = own.sort_values("order", kind="stable").head(MAX_COMPARISONS)
        numbers = "\n".join(map(_part_text, own.to_dict("records"))) or claim["evidence"]
        verdict = claim["verdict"]
        if claim["verdict_plain"]:
            verdict += f"\n(plain reading: {claim['verdict_plain']})"
        degree = class_text(claim["class"], claim["holds_when"])
        texts = (claim["claim"], in_words(numbers, names or {}), degree, verdict, claim["verdict_30"])
        rows.append((claim["id"], *texts))
    headings = (
        "claim",
        "the article says",
        "this run gives",
        "class",
        "verdict by one reading",
        "on the tables' seeds",
    )
    return text_table(
        "The article and this run",
        "The article's statements (in our words) beside the numbers of this run, with intervals in brackets. Of claims"
        f" with many comparisons {MAX_COMPARISONS} are shown, those that do not hold first; claims_parts.csv has all of"
        " them.",
        headings,
        rows,
        [
            "The article's tables and figures are lost, so only statements of its running text can be compared.",
            FITTED,
        ],
        headings[1:],
    )


def _part_text(part: dict) -> str:
    unit = "" if pd.isna(part["unit"]) else part["unit"]
    return f"{part['part']}: {estimate(part['estimate'], part['low'], part['high'], unit)} ({part['outcome']})"
