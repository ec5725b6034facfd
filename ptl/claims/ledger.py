"""The ledger: every claim with its verdict and the numbers behind it, as CSV, Markdown and a page."""

from __future__ import annotations

import html
from collections.abc import Sequence
from dataclasses import dataclass

import pandas as pd

from ptl.claims.claim import Judgement
from ptl.claims.thresholds import MEANINGS
from ptl.claims.verdict import Outcome, Part, Verdict
from ptl.evidence import SEEDS_NEEDED
from ptl.tables import STYLE

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
    "A claim consists of parts, each an estimate with its interval. A part holds if the whole interval lies"
    " where the claim says, fails if it lies wholly elsewhere, and is open if it reaches to both sides."
    " Reproduced: all parts hold; partly: some; not reproduced: none holds and at least one fails; undecided:"
    f" all are open, or the run lacks something or has fewer than {SEEDS_NEEDED} seeds. Parts are not"
    " corrected for their number, so of many a few may miss by chance. Task F and the method ptl are meant"
    " where a claim names no other."
)


@dataclass(frozen=True)
class Run:
    """What a ledger says of the run that it judges."""

    seeds: int
    confidence: float
    resamples: int

    def __str__(self) -> str:
        return (
            f"{self.seeds} seeds; {100 * self.confidence:g} % intervals in brackets (bootstrap,"
            f" {self.resamples:,} resamples, paired by seed where methods are compared; Wilson for shares of"
            " runs)"
        )


def counts(judgements: Sequence[Judgement]) -> dict[Verdict, int]:
    """Number of claims by verdict, all four in a fixed order."""
    return {verdict: sum(j.verdict is verdict for j in judgements) for verdict in Verdict}


def summary(judgements: Sequence[Judgement]) -> str:
    """One line of counts."""
    return ", ".join(f"{number} {verdict}" for verdict, number in counts(judgements).items())


def evidence_text(judgement: Judgement) -> str:
    """The numbers behind a verdict in one paragraph."""
    sentences = [
        _headline(judgement),
        *map(str, _parts_to_show(judgement)),
        _rest(judgement),
        *judgement.notes,
    ]
    return "; ".join(sentence for sentence in sentences if sentence)


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
    """Parts that fail, then those that are open."""
    missed = [part for part in judgement.parts if part.outcome is not Outcome.HOLDS]
    return sorted(missed, key=lambda part: part.outcome is Outcome.OPEN)


def _rest(judgement: Judgement) -> str:
    hidden = len(_missed(judgement)) - LISTED
    return f"and {hidden} more in claims_parts.csv" if len(judgement.parts) > SHOWN_PARTS and hidden > 0 else ""


# -- CSV ----------------------------------------------------------------------------------------------------


def to_frame(judgements: Sequence[Judgement]) -> pd.DataFrame:
    """One row for each claim, columns `COLUMNS`."""
    rows = [
        (
            j.claim.id, j.claim.statement, str(j.verdict), evidence_text(j), "; ".join(j.claim.shown_in),
            len(j.parts), sum(part.outcome is Outcome.HOLDS for part in j.parts),
        )
        for j in judgements
    ]  # fmt: skip
    return pd.DataFrame(rows, columns=list(COLUMNS))


def to_parts_frame(judgements: Sequence[Judgement]) -> pd.DataFrame:
    """One row for each part of each claim, columns `PART_COLUMNS`."""
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


# -- Markdown -----------------------------------------------------------------------------------------------


def to_markdown(judgements: Sequence[Judgement], run: Run) -> str:
    """Counts first (the first line for programs), then the table, then what words mean."""
    machine = "; ".join(f"{verdict}: {number}" for verdict, number in counts(judgements).items())
    lines = [
        f"<!-- claims: {len(judgements)}; {machine} -->",
        f"**{len(judgements)} claims of the article: {summary(judgements)}.**",
        "",
        f"Checked on this run: {run}.",
        "",
        "| id | claim | verdict | evidence | shown in |",
        "| --- | --- | --- | --- | --- |",
    ]
    for j in judgements:
        cells = [
            f"**{j.claim.id}**",
            j.claim.statement,
            f"{SYMBOLS[j.verdict]} {j.verdict}",
            _escape(evidence_text(j)).replace("; ", "<br>"),
            ", ".join(f"[{label(item)}]({_link(item)})" for item in j.claim.shown_in),
        ]
        lines.append("| " + " | ".join(cells) + " |")
    lines += ["", RULE, "", "What words mean here (our choice):", ""]
    lines += [f"* {word}: {meaning}" for word, meaning in MEANINGS]
    return "\n".join(lines) + "\n"


def _escape(text: str) -> str:
    for character in "\\|*_<>[]":
        text = text.replace(character, f"\\{character}")
    return text


def label(item: str) -> str:
    """Name of a table or figure for readers: ``figure09`` is Figure 9."""
    for kind in ("table", "figure"):
        if item.startswith(kind):
            return f"{kind.capitalize()} {int(item.removeprefix(kind))}"
    return f"Figure {item}"


def _link(item: str) -> str:
    return f"tables/{item}.md" if item.startswith("table") else f"figures/{item}.png"


# -- page ----------------------------------------------------------------------------------------------------

PAGE_STYLE = """
:root { --yes: #0072b2; --partly: #b87a00; --no: #c04a00; --open: #6b7480; }
@media (prefers-color-scheme: dark) {
  :root { --yes: #56b4e9; --partly: #e69f00; --no: #f0804a; --open: #9aa4b0; } }
main { max-width: 78rem; margin: 0 auto; }
h1 { font-size: 1.35rem; line-height: 1.3; margin: 0 0 .5rem; text-wrap: balance; }
p { max-width: 90ch; }
.counts { display: flex; flex-wrap: wrap; gap: .6rem; list-style: none; margin: 1rem 0; padding: 0; }
.counts li { border: 1px solid var(--rule); border-left: .35rem solid var(--kind); border-radius: .3rem;
  padding: .35rem .8rem; }
.counts b { font-size: 1.3rem; margin-right: .35rem; }
.yes { --kind: var(--yes); } .partly { --kind: var(--partly); }
.no { --kind: var(--no); } .open { --kind: var(--open); }
table { width: 100%; }
th, td { text-align: left; white-space: normal; padding: .6rem .8rem; }
thead tr:first-child th { text-align: left; padding-bottom: .4rem; border-bottom: 1px solid var(--strong);
  font-size: 1em; color: var(--ink); font-weight: 600; }
tbody th[scope=row] { position: static; font-weight: 600; white-space: nowrap;
  border-left: .35rem solid var(--kind); }
td.claim { min-width: 14rem; max-width: 20rem; }
td.evidence { width: 55%; }
td.verdict { white-space: nowrap; font-weight: 600; }
td.verdict span { color: var(--kind); display: inline-block; width: 1.2em; font-size: 1.1em; }
td.evidence ul { margin: 0; padding: 0; list-style: none; }
td.evidence li { padding-left: 1.5em; text-indent: -1.5em; }
td.evidence li::before { content: attr(data-mark); display: inline-block; width: 1.5em; text-indent: 0;
  font-weight: 600; }
td.evidence li.note, td.evidence .demand { color: var(--soft); font-size: .92em; }
td.evidence p { margin: 0 0 .3rem; }
details summary { cursor: pointer; color: var(--soft); margin-top: .3rem; }
td.shown { white-space: nowrap; }
dl { display: grid; grid-template-columns: fit-content(22rem) 1fr; gap: .25rem 1.2rem; font-size: .92em; }
dt { font-weight: 600; } dd { margin: 0; }
.soft { color: var(--soft); font-size: .92em; }
@media (max-width: 50rem) {
  table, tbody, tr, td, tbody th[scope=row] { display: block; }
  thead { display: none; }
  tbody tr { padding: .7rem 0; border-left: .35rem solid var(--kind); }
  tbody th[scope=row] { border-left: 0; }
  th, td { padding: .15rem .8rem; }
  td.claim, td.evidence { width: auto; max-width: none; }
  dl { display: block; } dd { margin: 0 0 .5rem; }
}
""".strip()


def to_html(judgements: Sequence[Judgement], run: Run) -> str:
    """A page of its own, without scripts or other files; verdicts by word, sign and colour."""
    boxes = "".join(
        f'<li class="{CLASSES[verdict]}"><b>{number}</b>{SYMBOLS[verdict]} {verdict}</li>'
        for verdict, number in counts(judgements).items()
    )
    meanings = "".join(f"<dt>{html.escape(word)}</dt><dd>{html.escape(text)}</dd>" for word, text in MEANINGS)
    lines = [
        "<!DOCTYPE html>",
        '<html lang="en">',
        "<head>",
        '<meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        "<title>Claims of the article, checked</title>",
        f"<style>\n{STYLE}\n{PAGE_STYLE}\n</style>",
        "</head>",
        "<body>",
        "<main>",
        f"<h1>{len(judgements)} claims of the article, checked on this run</h1>",
        f'<p class="soft">{html.escape(str(run))}.</p>',
        f'<ul class="counts">{boxes}</ul>',
        "<table>",
        '<thead><tr><th scope="col">Id</th><th scope="col">Claim</th><th scope="col">Verdict</th>'
        '<th scope="col">Evidence</th><th scope="col">Shown in</th></tr></thead>',
        "<tbody>",
        *map(_row, judgements),
        "</tbody>",
        "</table>",
        "<h2>How a verdict is made</h2>",
        f"<p>{html.escape(RULE)}</p>",
        "<h2>What words mean here (our choice)</h2>",
        f"<dl>{meanings}</dl>",
        "</main>",
        "</body>",
        "</html>",
    ]
    return "\n".join(lines) + "\n"


def _row(judgement: Judgement) -> str:
    claim, verdict = judgement.claim, judgement.verdict
    return (
        f'<tr id="{claim.id}" class="{CLASSES[verdict]}"><th scope="row">{claim.id}</th>'
        f'<td class="claim">{html.escape(claim.statement)}</td>'
        f'<td class="verdict"><span aria-hidden="true">{SYMBOLS[verdict]}</span>{verdict}</td>'
        f'<td class="evidence">{_evidence_html(judgement)}</td>'
        f'<td class="shown">{"<br>".join(map(label, claim.shown_in))}</td></tr>'
    )


def _evidence_html(judgement: Judgement) -> str:
    headline = _headline(judgement)
    text = f"<p>{html.escape(headline[0].upper() + headline[1:])}.</p>" if headline else ""
    shown = [*map(_part_html, _parts_to_show(judgement))]
    rest = _rest(judgement)
    shown += [f'<li class="note" data-mark="">{rest}</li>'] * bool(rest)
    shown += [f'<li class="note" data-mark="·">{html.escape(note)}</li>' for note in judgement.notes]
    text += f"<ul>{''.join(shown)}</ul>" if shown else ""
    if len(judgement.parts) > SHOWN_PARTS:
        every = "".join(map(_part_html, judgement.parts))
        text += f"<details><summary>all {len(judgement.parts)} parts</summary><ul>{every}</ul></details>"
    return text


def _part_html(part: Part) -> str:
    text = str(part)
    body, _, demand = text.rpartition(" (")
    return (
        f'<li data-mark="{MARKS[part.outcome]}">{html.escape(body)}'
        f' <span class="demand">({html.escape(demand)}</span></li>'
    )
