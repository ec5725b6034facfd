"""Hyper-parameters: checked however they are made, and given to jobs as JSON."""

from __future__ import annotations

import json
import math

import pytest
from click.testing import CliRunner

from ptl.cli import learn
from ptl.config import Learning, Parameters, Skills, Subgoals
from ptl.errors import UserError

MAP = "I..A\n...B\n"


def test_round_trip():
    changed = Parameters().replace(learning__alpha=0.1, skills__null_skill=False)
    assert Parameters.from_dict(changed.to_dict()) == changed
    assert Parameters.from_json(json.dumps(changed.to_dict())) == changed
    assert changed.learning.alpha == 0.1 and Parameters().learning.alpha == 0.05


def test_a_whole_number_is_a_number_but_not_the_other_way_round():
    assert isinstance(Learning(alpha=1).alpha, float)
    with pytest.raises(UserError, match=r"episodes: 3\.0 is not allowed"):
        Learning(episodes=3.0)


@pytest.mark.parametrize(
    ("group", "key", "value"),
    [
        ("learning", "alpha", -0.1),
        ("learning", "alpha", 0),
        ("learning", "alpha", math.nan),
        ("learning", "alpha", "fast"),
        ("learning", "alpha", True),
        ("learning", "episodes", 0),
        ("learning", "episodes", 1.5),
        ("learning", "max_steps", math.inf),
        ("skills", "prior_form", "cauchy"),
        ("skills", "null_skill", 1),
        ("policy_reuse", "psi_decay", 1.0),
        ("subgoals", "cover_radius", -1),
    ],
)
def test_bad_values_are_refused_by_name(group, key, value):
    with pytest.raises(UserError, match=rf"^configuration key {group}\.{key}: .* is not allowed; give "):
        Parameters.from_dict({group: {key: value}})
    with pytest.raises(UserError, match=rf"^configuration key {key}: .* is not allowed; give "):
        type(getattr(Parameters(), group))(**{key: value})


@pytest.mark.parametrize("make", [lambda: Parameters(learning={}), lambda: Parameters(learning=Skills()),
                                  lambda: Parameters(subgoals=None)])  # fmt: skip
def test_a_group_is_a_group(make):
    with pytest.raises(
        UserError, match=r"(not allowed|no value); give (Learning|Subgoals)\(\.\.\.\), or dictionaries to from_dict"
    ):
        make()


@pytest.mark.parametrize(
    ("groups", "says"),
    [
        ({"lerning": {}}, "key lerning: unknown; known are learning, skills, subgoals, policy_reuse"),
        ({"learning": {"alhpa": 0.1}}, r"key learning\.alhpa: unknown; known are episodes, alpha, gamma"),
        ({"learning": 3}, "key learning: 3 is not allowed; give keys and values"),
        ([], r"configuration: \[\] is not allowed"),
    ],
)
def test_unknown_keys_are_refused(groups, says):
    with pytest.raises(UserError, match=says):
        Parameters.from_dict(groups)
    with pytest.raises(UserError, match=says):
        Parameters.from_json(json.dumps(groups))


def test_values_cannot_be_changed():
    with pytest.raises(AttributeError):
        Subgoals().trajectories = 3


# -- jobs


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--parameters", "episodes=3"], "parameters: episodes=3 is not JSON"),
        (["--parameters", '{"learning": {"alpha": NaN}}'], "is not JSON"),
        (
            ["--parameters", '{"learning": {"alpha": 5}}'],
            "learning.alpha: 5 is not allowed; give a number > 0 and <= 1",
        ),
        (["--tasks", "AA"], "tasks: 'AA' is not allowed; give one or more of AB, each once"),
        (["--tasks", ""], "tasks: '' is not allowed; give one or more of AB, each once"),
        (["--tasks", "AZ"], "tasks: 'AZ' is not allowed; give one or more of AB, each once"),
    ],
)
def test_a_learning_job_refuses_in_one_line(tmp_path, options, says):
    (tmp_path / "map.txt").write_text(MAP)
    given = {"--map": str(tmp_path / "map.txt"), "--environment": "e", "--tasks": "AB", "--method": "ptl",
             "--seed": "0", "--root-seed": "1", "--output": str(tmp_path / "out.h5"),
             **dict([options])}  # fmt: skip
    done = CliRunner().invoke(learn.command, [part for option in given.items() for part in option])
    assert isinstance(done.exception, UserError) and says in str(done.exception)
    assert "\n" not in str(done.exception) and not (tmp_path / "out.h5").exists()
