"""The ledger: counts, evidence and pages made from verdicts."""

from __future__ import annotations

import re
from dataclasses import replace
from html.parser import HTMLParser

import pytest
from made_up_run import GROUPS, UNKNOWN, MadeUpRun

from ptl.report import ledger
from ptl.study import claims
from ptl.study.claims.verdict import Verdict


def judge(evidence):
    return {judged.claim.id: judged for judged in claims.judge(evidence)}


@pytest.fixture(scope="module")
def verdicts():
    return judge(MadeUpRun().evidence())


RUN = (12, GROUPS.statistics)


def test_frame_has_a_row_for_each_claim(verdicts):
    frame = ledger.to_frame(list(verdicts.values()))
    assert tuple(frame.columns) == ledger.COLUMNS
    assert frame["id"].tolist() == list(verdicts)
    assert (frame["evidence"] != "").all()
    parts = ledger.to_parts_frame(list(verdicts.values()))
    assert parts.groupby("id").size().to_dict() == frame.set_index("id")["parts"].to_dict()


def test_evidence_names_the_parts_that_miss():
    run = MadeUpRun()
    run.change("env1", UNKNOWN, 0, 10**6, tasks="C")
    headline, *lines = ledger.evidence_lines(judge(run.evidence())["E1-all"])
    assert re.match(r"7\d of 75 parts hold, \d+ fail, \d+ open", headline)
    assert lines[0].startswith("task C, ptl_unknown_goal, jump start: −98")
    assert all("task C" in line for line in lines)


def test_markdown_starts_with_counts_for_programs(verdicts):
    lines = ledger.to_markdown(list(verdicts.values()), *RUN).splitlines()
    n = len(verdicts)
    assert lines[0] == f"<!-- claims: {n}; reproduced: {n}; partly reproduced: 0; not reproduced: 0; undecided: 0 -->"
    rows = [line for line in lines if line.startswith("| **")]
    assert len(rows) == n
    assert {len(re.findall(r"(?<!\\)\|", row)) for row in rows} == {6}


class WellFormed(HTMLParser):
    """Refuses tags that are closed in another order than they were opened in."""

    def __init__(self, page):
        super().__init__()
        self.open, self.words, self.rows = [], [], []
        self.feed(page)
        assert not self.open

    def handle_starttag(self, tag, attributes):
        if tag not in ("meta", "br"):
            self.open.append(tag)
        if tag == "tr":
            self.rows.append(dict(attributes).get("id"))

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.words.append(data)


def test_page_is_well_formed_and_says_verdicts_in_words(verdicts):
    judged = list(verdicts.values())
    judged[0] = replace(judged[0], verdict=Verdict.NOT, notes=("<b> & co",))
    page = WellFormed(ledger.to_html(judged, *RUN))
    assert page.rows == [None, *verdicts]
    assert "not reproduced" in page.words
    assert "<b> & co" in page.words
    assert "src=" not in ledger.to_html(judged, *RUN)
