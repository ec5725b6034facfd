"""The ledger: counts, evidence and pages made from verdicts."""

from __future__ import annotations

import re
from dataclasses import replace
from html.parser import HTMLParser

import pytest
from made_up_run import GROUPS, UNKNOWN, MadeUpRun

from ptl import claims
from ptl.claims.degrees import CLASSES, EVERY, NONE, SOME, Degree, degrees_of
from ptl.claims.verdict import Verdict
from ptl.report import ledger


def judge(evidence):
    return {judged.claim.id: judged for judged in claims.judge(evidence)}


@pytest.fixture(scope="module")
def verdicts():
    return judge(MadeUpRun().evidence())


@pytest.fixture(scope="module")
def degrees():
    return degrees_of(claims.CLAIMS, MadeUpRun().evidence())


def entries(judged, few=None, degrees=None):
    given = degrees or [Degree(EVERY)] * len(judged)
    return [ledger.Entry(*row) for row in zip(judged, few or judged, given, strict=True)]


RUN = ledger.run_text(12, GROUPS.statistics)


def test_frame_has_a_row_for_each_claim(verdicts, degrees):
    judged = list(verdicts.values())
    few = [replace(judged[0], verdict=Verdict.NOT), *judged[1:]]
    rows = entries(judged, few, degrees)
    frame = ledger.to_frame(rows)
    assert frame["class"].tolist() == [degree.name for degree in degrees]
    assert frame["holds_when"].tolist() == [degree.when for degree in degrees]
    assert (frame["holds_when"] != "")[frame["class"] == SOME].all()
    assert tuple(frame.columns) == ledger.COLUMNS
    assert frame["id"].tolist() == list(verdicts)
    assert (frame["evidence"] != "").all()
    assert frame["verdict_30"].tolist() == ["not reproduced", *frame["verdict"][1:]]
    assert set(frame.loc[frame["verdict_plain"] != "", "id"]) == {"E1-all", "E2-all", "curves"}
    parts = ledger.to_parts_frame(rows)
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
    frame = ledger.to_parts_frame(entries(list(verdicts.values()), claims.judge(run.evidence())))
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


def test_markdown_starts_with_counts_for_programs(verdicts, degrees):
    lines = ledger.to_markdown(entries(list(verdicts.values()), degrees=degrees), RUN).splitlines()
    counts = ledger.class_counts(degree.name for degree in degrees)
    assert sum(count for _, count in counts) == len(verdicts)
    said = "; ".join(f"{name}: {count}" for name, count in counts)
    assert lines[0] == f"<!-- claims: {len(verdicts)}; {said} -->"
    rows = [line for line in lines if line.startswith("| **")]
    assert len(rows) == len(verdicts)
    assert {len(re.findall(r"(?<!\\)\|", row)) for row in rows} == {6}


def test_classes_are_counted_in_their_order_and_in_words():
    assert ledger.class_counts([NONE, SOME, SOME]) == [(SOME, 2), (NONE, 1)]
    assert ledger.counts_text([NONE, SOME, SOME]) == "2 hold under some readings only and 1 is contradicted"
    assert ledger.counts_text([*CLASSES, EVERY]) == (
        "2 hold under every reading of the words, 1 holds under some readings only, 1 holds in part, 1 is contradicted,"
        " 1 holds by construction and 1 is undecided"
    )
    assert ledger.counts_text([EVERY]) == "1 holds under every reading of the words"
    assert set(ledger.STYLES) == set(ledger.PHRASES) == set(CLASSES)


def test_names_stand_for_identifiers_as_in_a_sentence():
    names = {"ptl": "PTL", "ptl_unknown_goal": "PTL, goal unknown", "no_transfer": "No transfer"}
    assert (
        ledger.in_words("ptl_unknown_goal, ptl minus no_transfer", names) == "PTL, goal unknown, PTL minus no transfer"
    )
    assert ledger.in_words("ptl_other ptlx", names) == "ptl_other ptlx"


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


def test_page_is_well_formed_and_says_classes_in_words(verdicts):
    judged = list(verdicts.values())
    judged[0] = replace(judged[0], verdict=Verdict.NOT, notes=("<b> & co",))
    rows = entries(judged, degrees=[Degree(SOME, "on task F"), *[Degree(EVERY)] * (len(judged) - 1)])
    html = ledger.to_html(rows, RUN, {"ptl": "PTL"})
    page = WellFormed(html)
    assert page.rows == [None, *verdicts]
    assert {"under some readings", "on task F", CLASSES[SOME]} <= set(page.words)
    assert any("not reproduced" in words for words in page.words)
    assert "<b> & co" in page.words
    assert "src=" not in html and "ptl," not in html


def test_a_reader_of_classes_is_told_that_the_settings_were_fitted(verdicts):
    rows = entries(list(verdicts.values()))
    for page in (ledger.to_markdown(rows, RUN), ledger.to_html(rows, RUN)):
        assert "a fit and no prediction" in page
