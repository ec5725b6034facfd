"""The ledger: every claim with its verdict and the numbers behind it, as CSV, Markdown and a page."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pandas as pd

from ptl.report.templating import render
from ptl.study.claims.claim import Judgement
from ptl.study.claims.thresholds import MEANINGS
from ptl.study.claims.verdict import Outcome, Part, Verdict
from ptl.study.evidence import SEEDS_NEEDED
from ptl.text import number, percent

COLUMNS = ("id", "claim", "verdict", "evidence", "shown_in", "parts", "parts_held")
PART_COLUMNS = ("id", "part", "estimate", "low", "high", "unit", "demand", "outcome")

SHOWN_PARTS = 8
"""Parts that are written out; of a claim with more of them only those that do not hold."""

LISTED = 12
"""Parts that do not hold and are written out of a claim with many of them."""

SYMBOLS = {Verdict.REPRODUCED: "✓", Verdict.PARTLY: "◐", Verdict.NOT: "✗", Verdict.UNDECIDED: "?"}
MARKS = {Outcome.HOLDS: "✓", Outcome.FAILS: "✗", Outcome.OPEN: "○"}
CLASSES = {Verdict.REPRODUCED: "yes", Verdict.PARTLY: "partly", Verdict.NOT: "no", Verdict.UNDECIDED: "open"}

RULE = (
    "A claim consists of parts, each an estimate with its interval. A part holds if the whole interval satisfies the"
    " claim, fails if the whole interval contradicts it, and is open otherwise. Reproduced: all parts hold; partly"
    " reproduced: some; not reproduced: none holds and at least one fails; undecided: all are open, or the run lacks"
    f" something or has fewer than {SEEDS_NEEDED} seeds. Parts are not corrected for their number, so of many a few may"
    " miss by chance. A claim that names no task or method is about task F and the method ptl."
)


def run_text(seeds: int, statistics: Any) -> str:
    """Describe the run that a ledger judges."""
    return (
        f"Checked on this run: {number(seeds)} seeds; {percent(statistics.confidence)} intervals in brackets"
        f" (bootstrap, {number(statistics.resamples)} resamples, paired by seed where methods are compared; Wilson for"
        " shares of runs)."
    )


def counts(judgements: Sequence[Judgement]) -> dict[Verdict, int]:
    """Count the claims by verdict, all four in a fixed order."""
    return {verdict: sum(j.verdict is verdict for j in judgements) for verdict in Verdict}


def evidence_lines(judgement: Judgement) -> list[str]:
    """Return the numbers behind a verdict, one line each."""
    lines = [_headline(judgement), *map(str, _parts_to_show(judgement)), _rest(judgement), *judgement.notes]
    return [line for line in lines if line]


def _headline(judgement: Judgement) -> str:
    if judgement.reason:
        return judgement.reason
    if len(judgement.parts) <= SHOWN_PARTS:
        return ""
    held = [part.outcome for part in judgement.parts]
    return (
        f"{held.count(Outcome.HOLDS)} of {len(held)} parts hold, {held.count(Outcome.FAILS)} fail,"
        f" {held.count(Outcome.OPEN)} open"
    )


def _parts_to_show(judgement: Judgement) -> Sequence[Part]:
    if len(judgement.parts) <= SHOWN_PARTS:
        return judgement.parts
    return _missed(judgement)[:LISTED]


def _missed(judgement: Judgement) -> list[Part]:
    """Return the parts that fail, then those that are open."""
    missed = [part for part in judgement.parts if part.outcome is not Outcome.HOLDS]
    return sorted(missed, key=lambda part: part.outcome is Outcome.OPEN)


def _rest(judgement: Judgement) -> str:
    hidden = len(_missed(judgement)) - LISTED
    return f"and {hidden} more in claims_parts.csv" if len(judgement.parts) > SHOWN_PARTS and hidden > 0 else ""


# -- CSV ----------------------------------------------------------------------------------------------------


def to_frame(judgements: Sequence[Judgement]) -> pd.DataFrame:
    """Return one row for each claim, columns `COLUMNS`."""
    rows = [
        (
            j.claim.id, j.claim.statement, str(j.verdict), "; ".join(evidence_lines(j)), "; ".join(j.claim.shown_in),
            len(j.parts), sum(part.outcome is Outcome.HOLDS for part in j.parts),
        )
        for j in judgements
    ]  # fmt: skip
    return pd.DataFrame(rows, columns=list(COLUMNS))


def to_parts_frame(judgements: Sequence[Judgement]) -> pd.DataFrame:
    """Return one row for each part of each claim, columns `PART_COLUMNS`."""
    rows = [
        (
            j.claim.id,
            p.text,
            p.estimate.value,
            p.estimate.low,
            p.estimate.high,
            p.unit,
            p.demand,
            str(p.outcome),
        )
        for j in judgements
        for p in j.parts
    ]
    return pd.DataFrame(rows, columns=list(PART_COLUMNS))


# -- pages ---------------------------------------------------------------------------------------------------


def to_markdown(judgements: Sequence[Judgement], seeds: int, statistics: Any) -> str:
    """Render the ledger as Markdown: counts (the first line for programs), the table, and the meaning of words."""
    return render("ledger.md", **_values(judgements, seeds, statistics))


def to_html(judgements: Sequence[Judgement], seeds: int, statistics: Any) -> str:
    """Render the ledger as a page without scripts; a verdict is shown by word, sign and colour."""
    title = f"{len(judgements)} claims of the article, checked on this run"
    return render("ledger.html", title=title, **_values(judgements, seeds, statistics))


def label(item: str) -> str:
    """Return the name of a table or figure for readers: ``figure09`` is Figure 9."""
    for kind in ("table", "figure"):
        if item.startswith(kind):
            return f"{kind.capitalize()} {int(item.removeprefix(kind))}"
    return f"Figure {item}"


def _values(judgements: Sequence[Judgement], seeds: int, statistics: Any) -> dict[str, Any]:
    return {
        "run": run_text(seeds, statistics),
        "counts": [
            {"verdict": str(verdict), "number": count, "symbol": SYMBOLS[verdict], "kind": CLASSES[verdict]}
            for verdict, count in counts(judgements).items()
        ],
        "rows": list(map(_row, judgements)),
        "rule": RULE,
        "meanings": MEANINGS,
    }


def _row(judgement: Judgement) -> dict[str, Any]:
    claim, verdict = judgement.claim, judgement.verdict
    return {
        "id": claim.id,
        "claim": claim.statement,
        "verdict": str(verdict),
        "symbol": SYMBOLS[verdict],
        "kind": CLASSES[verdict],
        "lines": evidence_lines(judgement),
        "headline": _headline(judgement),
        "parts": list(map(_part, _parts_to_show(judgement))),
        "rest": _rest(judgement),
        "notes": judgement.notes,
        "every_part": list(map(_part, judgement.parts)) if len(judgement.parts) > SHOWN_PARTS else [],
        "shown_in": [
            {"label": label(item), "path": f"tables/{item}.md" if item.startswith("table") else f"figures/{item}.png"}
            for item in claim.shown_in
        ],
    }


def _part(part: Part) -> dict[str, str]:
    text, _, demand = str(part).rpartition(" (")
    return {"mark": MARKS[part.outcome], "text": text, "demand": demand.removesuffix(")")}
