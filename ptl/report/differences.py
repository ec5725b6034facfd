"""The article's statements beside the run's numbers, from the ledger and the robustness study."""

from __future__ import annotations

import pandas as pd

from ptl.report.ledger import FITTED
from ptl.report.table import Table, text_table
from ptl.study.claims.verdict import Outcome
from ptl.text import MISSING, estimate, percent

SHOWN = 6
"""Comparisons that are written out of one claim; those that do not hold come first."""

ORDER = [str(outcome) for outcome in (Outcome.FAILS, Outcome.AT_BOUND, Outcome.OPEN, Outcome.HOLDS)]


def differences_table(claims: pd.DataFrame, parts: pd.DataFrame, shares: pd.DataFrame | None = None) -> Table:
    """Lay out what the article says, what the run gives, and the verdicts, for every claim.

    Parameters
    ----------
    claims : DataFrame
        Ledger: columns id, claim, verdict, verdict_30, verdict_plain, evidence.
    parts : DataFrame
        Parts of the ledger: columns id, part, estimate, low, high, unit, demand, outcome.
    shares : DataFrame, optional
        Robustness study: columns claim, one_at_a_time_reproduced, latin_hypercube_reproduced, hangs_on.
    """
    study = {} if shares is None else shares.set_index("claim").to_dict("index")
    rows = []
    for claim in claims.to_dict("records"):
        own = parts[parts["id"] == claim["id"]].assign(order=lambda frame: frame["outcome"].map(ORDER.index))
        own = own.sort_values("order", kind="stable").head(SHOWN)
        numbers = "\n".join(map(_part_text, own.to_dict("records"))) or claim["evidence"]
        verdict = claim["verdict"]
        if claim["verdict_plain"]:
            verdict += f"\n(plain reading: {claim['verdict_plain']})"
        rows.append(
            (claim["id"], claim["claim"], numbers, verdict, claim["verdict_30"], *_robustness(study, claim["id"]))
        )
    headings = (
        "claim",
        "the article says",
        "this run gives",
        "verdict",
        "on the tables' seeds",
        "reproduced in",
        "most affected by",
    )
    return text_table(
        "The article and this run",
        "The article's statements (in our words) beside the numbers of this run, with intervals in brackets. Of claims"
        f" with many comparisons {SHOWN} are shown, those that do not hold first; claims_parts.csv has all of them.",
        headings,
        rows,
        [
            "The article's tables and figures are lost, so only statements of its running text can be compared.",
            FITTED,
            "Reproduced in: share of the settings of the robustness study, with one unknown moved and with all moved at"
            " once; most affected by: the unknown that moves the claim most there. With few seeds a setting many parts"
            " stay open.",
        ],
        headings[1:],
    )


def _robustness(study: dict, claim: str) -> tuple[str, str]:
    if claim not in study:
        return MISSING, MISSING
    row = study[claim]
    shares = (row["one_at_a_time_reproduced"], row["latin_hypercube_reproduced"])
    hangs_on = row["hangs_on"]
    shown = " / ".join(MISSING if pd.isna(share) else percent(round(share, 2)) for share in shares)
    return shown, hangs_on if isinstance(hangs_on, str) and hangs_on else MISSING


def _part_text(part: dict) -> str:
    unit = "" if pd.isna(part["unit"]) else part["unit"]
    return f"{part['part']}: {estimate(part['estimate'], part['low'], part['high'], unit)} ({part['outcome']})"
