"""The ledger: every claim with its verdict and the numbers behind it, as CSV, Markdown and a page."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd

from ptl.claims.claim import Judgement
from ptl.claims.evidence import MIN_SEEDS
from ptl.claims.thresholds import MEANINGS
from ptl.claims.verdict import RESOLUTION, Outcome, Part, Verdict
from ptl.report.templating import render
from ptl.text import number, percent

COLUMNS = (
    "id", "claim", "verdict", "verdict_30", "verdict_plain", "evidence", "shown_in", "parts", "parts_held",
)  # fmt: skip
PART_COLUMNS = (
    "id", "reading", "part", "estimate", "low", "high", "unit", "demand", "outcome",
    "estimate_30", "low_30", "high_30", "outcome_30",
)  # fmt: skip

MAX_PARTS = 8
"""Maximum number of parts shown; of a claim with more parts only those that do not hold are shown."""

MAX_MISSED_PARTS = 12
"""Maximum number of parts shown that do not hold, of a claim with many of them."""

SYMBOLS = {Verdict.REPRODUCED: "✓", Verdict.PARTLY: "◐", Verdict.NOT: "✗", Verdict.UNDECIDED: "?"}
MARKS = {Outcome.HOLDS: "✓", Outcome.FAILS: "✗", Outcome.AT_BOUND: "≈", Outcome.OPEN: "○"}
CLASSES = {Verdict.REPRODUCED: "yes", Verdict.PARTLY: "partly", Verdict.NOT: "no", Verdict.UNDECIDED: "open"}

RULE = (
    "A claim consists of parts, each an estimate with its interval. A part holds if the whole interval satisfies the"
    " claim and fails if the whole interval contradicts it. It lies at the bound if the interval reaches to both sides"
    f" of a bound, but no further from it than {percent(RESOLUTION)} of the bound (where that is 0, of the mean that"
    " the estimate is a difference to, and of 1 for shares and ratios); more runs would hardly tell the two apart. It"
    " is open if the interval reaches further. Reproduced: all parts hold; partly reproduced: some; not reproduced:"
    " none holds, and at least one fails or lies at the bound; undecided: all are open, or the run lacks something or"
    f" has fewer than {MIN_SEEDS} seeds. So a part at the bound never helps a claim. Where a claim's words admit a"
    " strict and a plain reading, the verdict follows the strict one, and the plain one has its own verdict beside it."
    " Parts are not corrected for their number, so of many a few may miss by chance. A claim that names no task or"
    " method is about task F and the method ptl."
)


FITTED = (
    "The drawings of maps 1 and 2 and the width of PTL's prior were chosen because they fit these claims, so agreement"
    " is a fit and no prediction; docs/reconstruction.md says what the choice is worth on claims that it had not seen."
)
"""Notes on the published maps and settings that apply to every verdict."""


def run_text(seeds: int, statistics: Any) -> str:
    """Describe a ledger of the runs of the tables alone."""
    return (
        f"Checked on this run: {number(seeds)} seeds; {percent(statistics.confidence)} intervals in brackets"
        f" (bootstrap, {number(statistics.resamples)} resamples, paired by seed where methods are compared; Wilson for"
        " shares of runs)."
    )


def decided_text(results: Sequence[Any], looks: Sequence[int], level: float, few: int, statistics: Any) -> str:
    """Describe a ledger of the runs that decide claims.

    Parameters
    ----------
    results : sequence of Result
        Files of the looks that were taken.
    looks : sequence of int
        Runs at each look that was planned.
    level : float
        Level of the intervals.
    few : int
        Seeds of the tables.
    """
    last: dict[tuple[str, str], int] = {}
    for result in results:
        last[result.job.pair] = max(last.get(result.job.pair, 0), result.job.look)
    counts = [sum(look == taken for taken in last.values()) for look in range(1, len(looks) + 1)]
    taken = ", ".join(f"{number(runs)} ({number(count)})" for runs, count in zip(looks, counts, strict=True) if count)
    error = percent(round(1 - statistics.confidence, 4))
    return (
        f"Verdicts and numbers are from as many runs as they need, others than the {number(few)} of the tables. Runs,"
        f" and in brackets how many of the {number(len(last))} pairs of environment and method took them: {taken}."
        " After each look, only what an open part speaks of gets more runs; the error over all looks is at most"
        f" {error} for each part (union bound). The intervals are those of large samples at"
        f" {percent(round(level, 4))}. First episodes"
        f" are compared with the exact expectation of those without transfer. Beside each verdict is what the"
        f" {number(few)} seeds of the tables say alone ({percent(statistics.confidence)} bootstrap intervals)."
    )


def counts(judgements: Sequence[Judgement]) -> dict[Verdict, int]:
    """Count the claims by verdict, all four in a fixed order."""
    return {verdict: sum(j.verdict is verdict for j in judgements) for verdict in Verdict}


def evidence_lines(judgement: Judgement) -> list[str]:
    """Return the numbers behind a verdict, one line each."""
    lines = [
        _headline(judgement), *map(str, _parts_to_show(judgement)), _rest(judgement), *_plain_lines(judgement),
        *judgement.notes,
    ]  # fmt: skip
    return [line for line in lines if line]


def _plain_lines(judgement: Judgement) -> list[str]:
    """Return the verdict by the plain reading and the parts that do not hold in it."""
    if not judgement.plain:
        return []
    missed = [str(part) for part in judgement.plain if part.outcome is not Outcome.HOLDS]
    return [f"plain reading: {judgement.plain_verdict}, {_tally(judgement.plain)}", *missed]


def _tally(parts: Sequence[Part]) -> str:
    outcomes = [part.outcome for part in parts]
    others = [
        f"{outcomes.count(outcome)} {words}"
        for outcome, words in ((Outcome.FAILS, "fail"), (Outcome.AT_BOUND, "at the bound"), (Outcome.OPEN, "open"))
    ]
    return f"{outcomes.count(Outcome.HOLDS)} of {len(outcomes)} parts hold, {', '.join(others)}"


def _headline(judgement: Judgement) -> str:
    if judgement.reason:
        return judgement.reason
    if len(judgement.parts) <= MAX_PARTS:
        return ""
    return f"{'strict reading: ' if judgement.plain else ''}{_tally(judgement.parts)}"


def _parts_to_show(judgement: Judgement) -> Sequence[Part]:
    if len(judgement.parts) <= MAX_PARTS:
        return judgement.parts
    return _missed(judgement)[:MAX_MISSED_PARTS]


def _missed(judgement: Judgement) -> list[Part]:
    """Return the parts that fail, then those at the bound, then those that are open."""
    missed = [part for part in judgement.parts if part.outcome is not Outcome.HOLDS]
    return sorted(missed, key=lambda part: list(Outcome).index(part.outcome))


def _rest(judgement: Judgement) -> str:
    hidden = len(_missed(judgement)) - MAX_MISSED_PARTS
    return f"and {hidden} more in claims_parts.csv" if len(judgement.parts) > MAX_PARTS and hidden > 0 else ""


# -- CSV ----------------------------------------------------------------------------------------------------


def to_frame(judgements: Sequence[Judgement], few: Sequence[Judgement]) -> pd.DataFrame:
    """Return one row for each claim, columns `COLUMNS`.

    Parameters
    ----------
    judgements, few : sequences of Judgement
        By the runs that decide and by those of the tables, claim by claim.
    """
    rows = [
        (
            j.claim.id, j.claim.statement, str(j.verdict), str(alone.verdict), str(j.plain_verdict or ""),
            "; ".join(evidence_lines(j)), "; ".join(j.claim.shown_in),
            len(j.parts), sum(part.outcome is Outcome.HOLDS for part in j.parts),
        )
        for j, alone in zip(judgements, few, strict=True)
    ]  # fmt: skip
    return pd.DataFrame(rows, columns=list(COLUMNS))


def to_parts_frame(judgements: Sequence[Judgement], few: Sequence[Judgement]) -> pd.DataFrame:
    """Return one row for each part of each claim, columns `PART_COLUMNS`; parameters as of `to_frame`."""
    rows = []
    for j, alone in zip(judgements, few, strict=True):
        same = [*alone.parts, *alone.plain]
        for place, p in enumerate([*j.parts, *j.plain]):
            numbers = (p.estimate.value, p.estimate.low, p.estimate.high)
            reading = "plain" if p.plain else "strict" if j.plain else ""
            row = [j.claim.id, reading, p.text, *numbers, p.unit, p.demand, str(p.outcome)]
            if place < len(same):
                own = same[place]
                row += [own.estimate.value, own.estimate.low, own.estimate.high, str(own.outcome)]
            else:
                row += [np.nan, np.nan, np.nan, str(Outcome.OPEN)]
            rows.append(row)
    return pd.DataFrame(rows, columns=list(PART_COLUMNS))


# -- pages ---------------------------------------------------------------------------------------------------


def to_markdown(judgements: Sequence[Judgement], few: Sequence[Judgement], run: str) -> str:
    """Render the ledger as Markdown: counts (the first line for programs), the table, and the meaning of words.

    Parameters
    ----------
    judgements, few : sequences of Judgement
        As of `to_frame`.
    run : str
        Description of the runs, see `run_text`.
    """
    return render("ledger.md", **_values(judgements, few, run))


def to_html(judgements: Sequence[Judgement], few: Sequence[Judgement], run: str) -> str:
    """Render the ledger as a page without scripts; a verdict is shown by word, sign and colour."""
    title = f"{len(judgements)} claims of the article, checked on this run"
    return render("ledger.html", title=title, **_values(judgements, few, run))


def label(item: str) -> str:
    """Return the name of a table or figure for readers: ``figure09`` is Figure 9."""
    for kind in ("table", "figure"):
        if item.startswith(kind):
            return f"{kind.capitalize()} {int(item.removeprefix(kind))}"
    return f"Figure {item}"


def _values(judgements: Sequence[Judgement], few: Sequence[Judgement], run: str) -> dict[str, Any]:
    return {
        "run": run,
        "counts": [
            {"verdict": str(verdict), "number": count, "symbol": SYMBOLS[verdict], "kind": CLASSES[verdict]}
            for verdict, count in counts(judgements).items()
        ],
        "rows": list(map(_row, judgements, few)),
        "fitted": FITTED,
        "rule": RULE,
        "meanings": MEANINGS,
    }


def _row(judgement: Judgement, alone: Judgement) -> dict[str, Any]:
    claim, verdict = judgement.claim, judgement.verdict
    return {
        "id": claim.id,
        "claim": claim.statement,
        "verdict": str(verdict),
        "symbol": SYMBOLS[verdict],
        "kind": CLASSES[verdict],
        "few": {"verdict": str(alone.verdict), "symbol": SYMBOLS[alone.verdict]},
        "plain": list(map(_part, (part for part in judgement.plain if part.outcome is not Outcome.HOLDS))),
        "plain_headline": next(iter(_plain_lines(judgement)), ""),
        "lines": evidence_lines(judgement),
        "headline": _headline(judgement),
        "parts": list(map(_part, _parts_to_show(judgement))),
        "rest": _rest(judgement),
        "notes": judgement.notes,
        "every_part": list(map(_part, judgement.parts)) if len(judgement.parts) > MAX_PARTS else [],
        "every_plain_part": list(map(_part, judgement.plain)),
        "shown_in": [
            {"label": label(item), "path": f"tables/{item}.md" if item.startswith("table") else f"figures/{item}.png"}
            for item in claim.shown_in
        ],
    }


def _part(part: Part) -> dict[str, str]:
    text, _, demand = str(part).rpartition(" (")
    return {"mark": MARKS[part.outcome], "text": text, "demand": demand.removesuffix(")")}
