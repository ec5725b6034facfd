"""The ledger: counts, evidence and pages made from verdicts."""

from __future__ import annotations

import re
from dataclasses import replace
from html.parser import HTMLParser

import pytest
from made_up_run import GROUPS, UNKNOWN, MadeUpRun

from ptl import claims
from ptl.claims.verdict import Verdict
from ptl.report import ledger


def judge(evidence):
    return {judged.claim.id: judged for judged in claims.judge(evidence)}


@pytest.fixture(scope="module")
def verdicts():
    return judge(MadeUpRun().evidence())


RUN = ledger.run_text(12, GROUPS.statistics)


def test_frame_has_a_row_for_each_claim(verdicts):
    judged = list(verdicts.values())
    few = [replace(judged[0], verdict=Verdict.NOT), *judged[1:]]
    frame = ledger.to_frame(judged, few)
    assert tuple(frame.columns) == ledger.COLUMNS
    assert frame["id"].tolist() == list(verdicts)
    assert (frame["evidence"] != "").all()
    assert frame["verdict_30"].tolist() == ["not reproduced", *frame["verdict"][1:]]
    assert set(frame.loc[frame["verdict_plain"] != "", "id"]) == {"E1-all", "E2-all", "curves"}
    parts = ledger.to_parts_frame(judged, few)
    assert tuple(parts.columns) == ledger.PART_COLUMNS
    strict = parts[parts["reading"] != "plain"]
    assert strict.groupby("id").size().to_dict() == frame.set_index("id")["parts"].to_dict()
    assert parts[parts["reading"] == "plain"].groupby("id").size().to_dict() == {
        "E1-all": 15,
        "E2-all": 15,
        "curves": 6,
    }


def test_a_part_shows_what_the_tables_seeds_say(verdicts):
    run = MadeUpRun()
    run.change("env1", UNKNOWN, 0, 10**6, tasks="C")
    frame = ledger.to_parts_frame(list(verdicts.values()), claims.judge(run.evidence()))
    [row] = frame[frame["part"] == "task C, ptl_unknown_goal, jump start"].query("id == 'E1-all'").to_dict("records")
    assert (row["outcome"], row["outcome_30"]) == ("holds", "fails")
    assert row["estimate_30"] < 0 < row["estimate"]


def test_evidence_names_the_parts_that_miss():
    run = MadeUpRun()
    run.change("env1", UNKNOWN, 0, 10**6, tasks="C")
    headline, *lines = ledger.evidence_lines(judge(run.evidence())["E1-all"])
    assert re.match(r"strict reading: 7\d of 75 parts hold, \d+ fail, \d+ at the bound, \d+ open", headline)
    assert lines[0].startswith("task C, ptl_unknown_goal, jump start: −98")
    [plain] = [number for number, line in enumerate(lines) if line.startswith("plain reading: partly reproduced, 1")]
    assert all("task C" in line for line in lines[:plain])
    assert all("together, ptl_unknown_goal" in line for line in lines[plain + 1 :])


def test_markdown_starts_with_counts_for_programs(verdicts):
    lines = ledger.to_markdown(list(verdicts.values()), list(verdicts.values()), RUN).splitlines()
    n = len(verdicts)
    assert lines[0] == f"<!-- claims: {n}; reproduced: {n}; partly reproduced: 0; not reproduced: 0; undecided: 0 -->"
    rows = [line for line in lines if line.startswith("| **")]
    assert len(rows) == n
    assert {len(re.findall(r"(?<!\\)\|", row)) for row in rows} == {7}


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
    page = WellFormed(ledger.to_html(judged, judged, RUN))
    assert page.rows == [None, *verdicts]
    assert "not reproduced" in page.words
    assert "<b> & co" in page.words
    assert "src=" not in ledger.to_html(judged, judged, RUN)


def test_a_reader_of_verdicts_is_told_that_the_reading_was_fitted(verdicts):
    judged = list(verdicts.values())
    for page in (ledger.to_markdown(judged, judged, RUN), ledger.to_html(judged, judged, RUN)):
        assert "is a fit and no prediction" in page
