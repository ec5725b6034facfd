"""The page of differences follows from the ledger."""

from __future__ import annotations

import pandas as pd

from ptl.report.differences import MAX_COMPARISONS, differences_table

PART = {
    "id": "a",
    "part": "steps",
    "estimate": 12345.6,
    "low": 0.1234,
    "high": 2.0,
    "unit": "steps",
    "outcome": "holds",
}
CLAIM = {"id": "a", "claim": "PTL is faster", "class": "under some readings", "holds_when": "on task F",
         "verdict": "reproduced", "verdict_30": "partly reproduced", "verdict_plain": "",
         "evidence": "not in this run"}  # fmt: skip
DEGREE = "under some readings: on task F"


def row(claim: dict, parts: list[dict]) -> list[str]:
    table = differences_table(pd.DataFrame([claim]), pd.DataFrame(parts, columns=[*PART, "demand"]))
    [found] = table.groups[0].rows
    return [found.label, *(cell.text for cell in found.cells)]


def test_statement_numbers_and_verdict_come_from_the_ledger():
    assert row(CLAIM, [PART]) == ["a", "PTL is faster", "steps: 12,350 [0.1, 2] steps (holds)", DEGREE, "reproduced",
                                "partly reproduced"]  # fmt: skip


def test_another_verdict_changes_nothing_but_the_verdict():
    before, after = row(CLAIM, [PART]), row(CLAIM | {"verdict": "not reproduced"}, [PART])
    assert after == [*before[:4], "not reproduced", *before[5:]]


def test_the_plain_reading_stands_beside_the_verdict():
    found = row(CLAIM | {"verdict_plain": "not reproduced"}, [PART])
    assert found[4:] == ["reproduced\n(plain reading: not reproduced)", "partly reproduced"]


def test_a_share_reads_as_in_the_ledger():
    part = PART | {"estimate": 81.0, "low": 74.0, "high": 85.0, "unit": "%", "part": "saved"}
    assert row(CLAIM, [part])[2] == "saved: 81% [74, 85] (holds)"
    assert row(CLAIM, [part | {"unit": float("nan")}])[2] == "saved: 81 [74, 85] (holds)"


def test_of_many_comparisons_those_that_do_not_hold_come_first():
    outcomes = ["holds"] * MAX_COMPARISONS + ["open", "at the bound", "fails"]
    shown = row(CLAIM, [PART | {"part": f"part {i}", "outcome": o} for i, o in enumerate(outcomes)])[2].splitlines()
    assert len(shown) == MAX_COMPARISONS
    assert [line.split(":")[0] for line in shown[:4]] == [f"part {MAX_COMPARISONS + k}" for k in (2, 1, 0)] + ["part 0"]


def test_a_claim_without_comparisons_gives_its_reason():
    assert row(CLAIM | {"verdict": "undecided"}, [])[2:5] == ["not in this run", DEGREE, "undecided"]


def test_methods_and_environments_have_their_names():
    parts = [PART | {"part": "env1, ptl_unknown_goal minus ptl"}]
    names = {"ptl": "PTL", "ptl_unknown_goal": "PTL, goal unknown", "env1": "Environment 1"}
    table = differences_table(pd.DataFrame([CLAIM]), pd.DataFrame(parts, columns=[*PART, "demand"]), names)
    assert table.groups[0].rows[0].cells[1].text.startswith("environment 1, PTL, goal unknown minus PTL: ")


def test_the_page_says_that_the_reading_was_fitted():
    notes = differences_table(pd.DataFrame([CLAIM]), pd.DataFrame([PART])).notes
    assert any("a fit and no prediction" in note for note in notes)
