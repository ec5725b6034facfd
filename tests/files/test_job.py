"""Jobs: equal jobs have equal texts, a difference is named, and every value that decides a result is in them."""

from __future__ import annotations

import json

import msgspec
import pytest
from lives import QUICK, job

from ptl.errors import UserError
from ptl.files.job import differences, packed
from ptl.jobs.kinds import job_from, unpacked

LEARN = job("ptl", 3)
replace = msgspec.structs.replace


def test_a_job_is_read_back_from_its_text():
    assert job_from(LEARN.text) == LEARN
    assert unpacked(packed([LEARN, job("no_transfer")])) == [LEARN, job("no_transfer")]
    assert job_from(job("ptl", 3).text).digest == LEARN.digest


@pytest.mark.parametrize(
    ("other", "says"),
    [
        (job("ptl", 3, parameters=QUICK.replace(learning__alpha=0.7)), "learning.alpha 0.7, not 0.05"),
        (replace(LEARN, root_seed=2), "root_seed 2, not 1"),
        (replace(LEARN, tasks="BA"), "tasks 'BA', not 'AB'"),
        (
            replace(LEARN, method="full_transfer", reference="full_transfer", code="0" * 16),
            "method 'full_transfer', not",
        ),
        (replace(LEARN, own={"weight": 2}), "own.weight 2, not none"),
        (replace(LEARN, maps={"rooms": "0" * 16}), "another map of rooms"),
        (replace(LEARN, code="0" * 16), "another version of the code"),
    ],
)
def test_a_difference_is_named(other, says):
    assert differences(LEARN, LEARN) == []
    assert differences(other, LEARN)[0].startswith(says)
    assert other.digest != LEARN.digest


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"kind": "flying/1"}, "job of the kind 'flying/1': is not one of"),
        ({"seed": -1}, "at `\\$.seed`"),
        ({"environment": "../rooms"}, "at `\\$.environment`"),
        ({"colour": "red"}, "unknown field `colour`"),
        ({"tasks": "AI"}, "at `\\$.tasks`"),
    ],
)
def test_other_texts_are_no_jobs(change, says):
    text = json.dumps({**json.loads(LEARN.text), **change})
    with pytest.raises(UserError, match=says):
        job_from(text)
    for rubbish in ("", "[]", "{", '{"kind": 1}'):
        with pytest.raises(UserError, match=r"^job: "):
            job_from(rubbish)
