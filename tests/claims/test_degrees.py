"""Degrees: the class of a claim from what came out under each reading."""

from __future__ import annotations

from dataclasses import replace

import pytest
from made_up_run import MadeUpRun

from ptl import claims
from ptl.claims.claim import Claim
from ptl.claims.degrees import (
    CLASSES,
    CONSTRUCTION,
    EVERY,
    NONE,
    PARTLY,
    PLAIN,
    SOME,
    STRICT,
    UNDECIDED,
    Degree,
    Outcomes,
    degree_of,
    judge_all_readings,
    outcomes_of,
)
from ptl.claims.reading import ARTICLE_RUNS, Reading, readings
from ptl.measures.statistics import Resampling


def claim(open_to: tuple[str, ...] = (), by_construction: str = "") -> Claim:
    return Claim("made-up", "A statement.", (), lambda evidence: iter(()), open_to, by_construction)


def outcomes(own: Claim, holds, some: bool = False, words: str = STRICT) -> list[Outcomes]:
    return [Outcomes(reading, words, holds(reading), some) for reading in readings(own.open_to)]


@pytest.mark.parametrize(
    ("holds", "some", "expected"),
    [(True, True, EVERY), (False, True, PARTLY), (False, False, NONE), (None, False, UNDECIDED)],
)
def test_one_reading(holds, some, expected):
    own = claim()
    assert degree_of(own, outcomes(own, lambda reading: holds, some)) == Degree(expected)


def test_a_claim_by_construction_says_why():
    assert str(degree_of(claim(by_construction="we drew it"), [])) == f"{CONSTRUCTION}: we drew it"


@pytest.mark.parametrize(
    ("good", "expected"),
    [
        ({"F"}, "on task F"),
        ({"C", "D", "BCDEF"}, "on tasks C, D and tasks B to F together"),
        ({"BCDEF"}, "on tasks B to F together"),
    ],
)
def test_the_tasks_on_which_a_claim_holds_are_named(good, expected):
    own = claim(("tasks",))
    assert degree_of(own, outcomes(own, lambda reading: reading.tasks in good)) == Degree(SOME, expected)


def test_tolerance_and_runs_are_named():
    own = claim(("tolerance",))
    assert degree_of(own, outcomes(own, lambda reading: reading.tolerance > 0)).when == "within 1 step of the place"
    own = claim(("runs",))
    assert degree_of(own, outcomes(own, lambda reading: reading.runs == ARTICLE_RUNS)).when == "at 30 runs"
    assert degree_of(own, outcomes(own, lambda reading: reading.runs is None)).when == "in the limit of many runs"


def test_two_open_words_name_only_what_matters():
    own = claim(("tasks", "runs"))
    found = degree_of(own, outcomes(own, lambda reading: reading.tasks == "C"))
    assert found.when == "on task C"
    found = degree_of(own, outcomes(own, lambda reading: reading.tasks in {"F", "B", "D"}))
    assert found.when == "on tasks B, D, F"


def test_plain_words_are_named():
    own = claim()
    both = [*outcomes(own, lambda reading: False, True), *outcomes(own, lambda reading: True, True, PLAIN)]
    assert degree_of(own, both) == Degree(SOME, "in plain words")


def test_an_undecided_reading_is_no_reading_under_which_a_claim_holds():
    own = claim(("tasks",))
    mixed = outcomes(own, lambda reading: None if reading.tasks == "B" else True, True)
    assert degree_of(own, mixed).name == SOME


def test_every_claim_of_a_run_gets_a_degree():
    evidence = replace(MadeUpRun().evidence(), how=Resampling(0.95, 0))
    for own in claims.CLAIMS:
        judged = list(judge_all_readings(own, evidence))
        assert [reading for reading, _ in judged] == list(own.readings())
        assert degree_of(own, outcomes_of(judged)).name in CLASSES


def test_a_run_as_in_the_article_holds_under_every_reading_of_the_tasks():
    evidence = replace(MadeUpRun().evidence(), how=Resampling(0.95, 0))
    by_id = {own.id: own for own in claims.CLAIMS}
    assert degree_of(by_id["E1-order"], outcomes_of(judge_all_readings(by_id["E1-order"], evidence))).name == EVERY
    assert isinstance(next(iter(by_id["E1-jump"].readings())), Reading)
