"""The ledger: every claim with its class, its verdict and the numbers behind them, as CSV, Markdown and a page."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from ptl.claims.claim import Judgement
from ptl.claims.degrees import CLASSES, CONSTRUCTION, EVERY, NONE, PARTLY, SOME, UNDECIDED, Degree
from ptl.claims.evidence import MIN_SEEDS
from ptl.claims.thresholds import MEANINGS
from ptl.claims.verdict import RESOLUTION, Outcome, Part, Verdict
from ptl.report.templating import render
from ptl.text import number, percent

COLUMNS = (
    "id", "claim", "class", "holds_when", "verdict", "verdict_30", "verdict_plain", "evidence", "shown_in", "parts",
    "parts_held",
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
STYLES = {
    EVERY: "every", SOME: "some", PARTLY: "partly", NONE: "none", CONSTRUCTION: "construction", UNDECIDED: "undecided",
}  # fmt: skip
"""Name of each class in style sheets."""

READINGS = (
    "The article's words can often be read in more than one way: on which tasks a sentence holds, how near to a place"
    " counts as at it, how many runs “not significant” speaks of, and whether every single comparison is meant or all"
    " tasks together. Each claim is judged under all its readings, by the means of the runs, and its class says how"
    " far it holds."
)

RULE = (
    "The details judge one reading of each claim, that of task F and of the method PTL where the claim names neither."
    " A claim has several parts; each compares an estimate with what the claim demands. A part holds if its whole"
    " interval meets the demand and fails if none of the interval does. If the interval includes a bound, the part is"
    f" at the bound when neither end is further from it than {percent(RESOLUTION)} of the bound (of the mean that is"
    " compared with where the bound is 0, of 1 for shares and ratios), because more runs would hardly decide it;"
    " otherwise it is open. A claim is reproduced if all its parts hold, partly reproduced if some do, not reproduced"
    " if none holds and at least one fails or is at the bound, and undecided if all are open, if the run lacks what"
    f" the claim needs, or if it has fewer than {MIN_SEEDS} seeds. Where the words admit a strict and a plain reading,"
    " the verdict follows the strict one, and the plain one has a verdict of its own. Parts are not corrected for"
    " their number, so that of many parts a few may fail by chance."
)


FITTED = (
    "How PTL uses a skill within an episode was chosen, by a rule fixed beforehand, because more of these claims come"
    " out with it over all else that the article leaves open, so agreement is to that extent a fit and no prediction;"
    " docs/reconstruction.md describes the choice. The maps and all other settings were chosen before anything was"
    " compared with the article."
)
"""Note on the published settings that applies to every class and verdict."""


@dataclass(frozen=True)
class Entry:
    """What the ledger says of a claim.

    Attributes
    ----------
    judgement : Judgement
        By the runs that decide.
    few : Judgement
        By the runs of the tables.
    degree : Degree
        How far the claim holds over all readings of its words.
    """

    judgement: Judgement
    few: Judgement
    degree: Degree


def run_text(seeds: int, statistics: Any) -> str:
    """Describe a ledger of the runs of the tables alone."""
    return (
        f"Checked on this run: {number(seeds)} seeds; {percent(statistics.confidence)} intervals in brackets"
        f" (bootstrap, {number(statistics.resamples)} resamples; Wilson for shares of runs). The runs of different"
        " methods are independent of each other."
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
        "Classes, verdicts and numbers are from as many runs as they need, others than the"
        f" {number(few)} of the tables. Runs, and in brackets how many of the {number(len(last))} pairs of environment"
        f" and method took them: {taken}. After each look, only what an open part speaks of gets more runs; the error"
        f" over all looks is at most {error} for each part (union bound). The intervals are those of large samples at"
        f" {percent(round(level, 4))}. First episodes are compared with the exact expectation of those without"
        " transfer."
        f" Where the {number(few)} seeds of the tables alone give another verdict"
        f" ({percent(statistics.confidence)} bootstrap intervals), it is shown too."
    )


def class_counts(names: Iterable[str]) -> list[tuple[str, int]]:
    """Count the claims of each class that occurs, in the order of `CLASSES`."""
    found = Counter(names)
    return [(name, found[name]) for name in CLASSES if found[name]]


PHRASES = {
    EVERY: ("holds", "hold", "under every reading of the words"),
    SOME: ("holds", "hold", "under some readings only"),
    PARTLY: ("holds", "hold", "in part"),
    NONE: ("is", "are", "contradicted"),
    CONSTRUCTION: ("holds", "hold", "by construction"),
    UNDECIDED: ("is", "are", "undecided"),
}
"""Verb, for one and for several claims, and rest of a sentence on the claims of each class."""


def counts_text(names: Iterable[str]) -> str:
    """Return how many claims are in each class, as the end of a sentence: 1 holds in part and 2 are contradicted."""
    parts = []
    for name, count in class_counts(names):
        one, several, rest = PHRASES[name]
        parts.append(f"{count} {one if count == 1 else several} {rest}")
    *others, last = parts
    return f"{', '.join(others)} and {last}" if others else last


def class_text(name: str, when: str) -> str:
    """Return the class of a claim with the readings under which it holds, if only some."""
    return f"{name}: {when}" if when else name


def in_words(text: str, names: Mapping[str, str]) -> str:
    """Replace identifiers of methods and environments by their names, which start with a small letter in a sentence."""
    if not names:
        return text
    pattern = "|".join(re.escape(name) for name in sorted(names, key=len, reverse=True))
    return re.sub(rf"\b({pattern})\b", lambda found: _small(names[found[0]]), text)


def _small(name: str) -> str:
    return name if name[:2].isupper() else name[:1].lower() + name[1:]


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


def to_frame(entries: Sequence[Entry]) -> pd.DataFrame:
    """Return one row for each claim, columns `COLUMNS`."""
    rows = []
    for entry in entries:
        j = entry.judgement
        rows.append(
            (
                j.claim.id, j.claim.statement, entry.degree.name, entry.degree.when, str(j.verdict),
                str(entry.few.verdict), str(j.plain_verdict or ""), "; ".join(evidence_lines(j)),
                "; ".join(j.claim.shown_in), len(j.parts), sum(part.outcome is Outcome.HOLDS for part in j.parts),
            )
        )  # fmt: skip
    return pd.DataFrame(rows, columns=list(COLUMNS))


def to_parts_frame(entries: Sequence[Entry]) -> pd.DataFrame:
    """Return one row for each part of each claim, columns `PART_COLUMNS`."""
    rows = []
    for entry in entries:
        j = entry.judgement
        same = [*entry.few.parts, *entry.few.plain]
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


def to_markdown(entries: Sequence[Entry], run: str, names: Mapping[str, str] | None = None) -> str:
    """Render the ledger as Markdown: counts (the first line for programs), the table, and the meaning of words.

    Parameters
    ----------
    entries : sequence of Entry
    run : str
        Description of the runs, see `run_text`.
    names : mapping, optional
        Name for readers of each method and environment.
    """
    return render("ledger.md", **_values(entries, run, names or {}))


def to_html(entries: Sequence[Entry], run: str, names: Mapping[str, str] | None = None) -> str:
    """Render the ledger as a page without scripts; a class is shown by words and colour. Parameters as above."""
    title = f"{len(entries)} claims of the article, checked on this run"
    return render("ledger.html", title=title, **_values(entries, run, names or {}))


def label(item: str) -> str:
    """Return the name of a table or figure for readers: ``figure09`` is Figure 9."""
    for kind in ("table", "figure"):
        if item.startswith(kind):
            return f"{kind.capitalize()} {int(item.removeprefix(kind))}"
    return f"Figure {item.replace('_', ' ')}"


def _values(entries: Sequence[Entry], run: str, names: Mapping[str, str]) -> dict[str, Any]:
    return {
        "run": run,
        "counts": [
            {"name": name, "number": count, "style": STYLES[name], "meaning": CLASSES[name]}
            for name, count in class_counts(entry.degree.name for entry in entries)
        ],
        "rows": [_row(entry, names) for entry in entries],
        "fitted": FITTED,
        "readings": READINGS,
        "rule": RULE,
        "meanings": MEANINGS,
    }


def _row(entry: Entry, names: Mapping[str, str]) -> dict[str, Any]:
    judgement, degree = entry.judgement, entry.degree

    def parts(chosen: Iterable[Part]) -> list[dict[str, str]]:
        return [_part(part, names) for part in chosen]

    return {
        "id": judgement.claim.id,
        "claim": judgement.claim.statement,
        "class": degree.name,
        "when": degree.when,
        "style": STYLES[degree.name],
        "degree": class_text(degree.name, degree.when),
        "verdict": str(judgement.verdict),
        "symbol": SYMBOLS[judgement.verdict],
        "few": {"verdict": str(entry.few.verdict), "symbol": SYMBOLS[entry.few.verdict]},
        "plain": parts(part for part in judgement.plain if part.outcome is not Outcome.HOLDS),
        "plain_headline": next(iter(_plain_lines(judgement)), ""),
        "lines": [in_words(line, names) for line in evidence_lines(judgement)],
        "headline": in_words(_headline(judgement), names),
        "parts": parts(_parts_to_show(judgement)),
        "rest": _rest(judgement),
        "notes": [in_words(note, names) for note in judgement.notes],
        "every_part": parts(judgement.parts) if len(judgement.parts) > MAX_PARTS else [],
        "every_plain_part": parts(judgement.plain),
        "shown_in": [
            {"label": label(item), "path": f"tables/{item}.md" if item.startswith("table") else f"figures/{item}.png"}
            for item in judgement.claim.shown_in
        ],
    }


def _part(part: Part, names: Mapping[str, str]) -> dict[str, str]:
    text, _, demand = str(part).rpartition(" (")
    return {"mark": MARKS[part.outcome], "text": in_words(text, names), "demand": demand.removesuffix(")")}
