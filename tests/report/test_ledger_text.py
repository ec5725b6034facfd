"""The ledger as files to read: one form for a value, and that every text is text."""

from __future__ import annotations

import re
from types import SimpleNamespace

from test_table import HOSTILE, read

from ptl.claims.claim import Claim, Judgement
from ptl.claims.degrees import SOME, Degree
from ptl.claims.verdict import Outcome, Part, Verdict
from ptl.measures.statistics import Estimate
from ptl.report import ledger

RUN = ledger.run_text(30, SimpleNamespace(confidence=0.95, resamples=2000))


def part(text: str = "steps", outcome: Outcome = Outcome.HOLDS) -> Part:
    return Part(text, Estimate(15261.3, 5238.0, 24907.0), "> 0", outcome, "steps")


def judgement(parts: list[Part], statement: str = "PTL is faster", note: str = "a note") -> Judgement:
    claim = Claim("E1-x", statement, ("table1", "figure09"), lambda evidence: iter(()))
    return Judgement(claim, Verdict.PARTLY, tuple(parts), (note,))


def entry(judged: Judgement, when: str = "on task F") -> ledger.Entry:
    return ledger.Entry(judged, judged, Degree(SOME, when))


def test_every_file_reads_a_value_alike():
    rows = [entry(judgement([part()]))]
    text = "steps: 15,000 [5,000, 25,000] steps"
    assert ledger.to_frame(rows)["evidence"].tolist() == [f"{text} (> 0: holds); a note"]
    assert f'{text} <span class="demand">(&gt; 0: holds)</span>' in ledger.to_html(rows, RUN)
    assert text.replace("[", r"\[").replace("]", r"\]") in ledger.to_markdown(rows, RUN)
    numbers = ledger.to_parts_frame(rows)[["estimate", "low", "high"]]
    assert numbers.to_numpy().tolist() == [[15261.3, 5238.0, 24907.0]]


def test_of_many_parts_those_that_do_not_hold_are_written_out():
    parts = [part(f"part {i}") for i in range(ledger.MAX_PARTS)]
    parts += [part("open one", Outcome.OPEN), part("failing one", Outcome.FAILS)]
    headline, first, second, note = ledger.evidence_lines(judgement(parts))
    assert headline == "8 of 10 parts hold, 1 fail, 0 at the bound, 1 open"
    assert first.startswith("failing one:") and second.startswith("open one:") and note == "a note"
    page = ledger.to_html([entry(judgement(parts))], RUN)
    assert "all 10 parts" in page and page.count("part 3:") == 1


def test_text_never_becomes_markup():
    rows = [entry(judgement([part(HOSTILE)], HOSTILE, HOSTILE), HOSTILE)]
    assert "script" not in read(ledger.to_html(rows, RUN)).tags
    lines = [line for line in ledger.to_markdown(rows, RUN).splitlines() if line.startswith("| **")]
    assert {len(re.findall(r"(?<!\\)\|", line)) for line in lines} == {6}
    assert "<script>" not in re.sub(r"\\.", "", lines[-1])
