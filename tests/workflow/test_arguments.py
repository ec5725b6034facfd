"""Absurd arguments of single commands end in one line, at once and before anything is written."""

from __future__ import annotations

import json
import os
import shutil

import pytest
from click.testing import CliRunner
from lives import job
from projects import MAPS

from ptl.cli import commands
from ptl.errors import UserError
from ptl.world.gridworld import GridWorld

HUGE, DEEP = "9" * 30, "[" * 10**5
LEARN = ("learn", "--map", "env3.txt", "--tasks", "A")
JOB = job("ptl", world=GridWorld.from_text((MAPS / "env3.txt").read_text(), "env3"), tasks="AB").text
RUN = ("run", "--output", "x.h5", "--map", "env3=env3.txt", "--job")


def changed(**values: object) -> str:
    """The job with other values."""
    return json.dumps({**json.loads(JOB), **values})


@pytest.mark.parametrize(
    "arguments",
    [
        (*LEARN, "--tasks", "AA"), (*LEARN, "--tasks", "{"), (*LEARN, "--seed", HUGE), (*LEARN, "--root-seed", HUGE),
        (*LEARN, "--seed", "1.0"), (*LEARN, "--output", ""), (*LEARN, "--environment", "{", "--output", "x.h5"),
        (*LEARN, "--map", "{"), (*LEARN, "--parameters", "{"), (*LEARN, "--parameters", '{"learning": {"alpha": NaN}}'),
        (*LEARN, "--method-parameters", "["), (*LEARN, "--method", "{"),
        *((*RUN, text) for text in ("{", "{}", "[]", "1", "", DEEP, JOB[:-1], '{"kind": "flying/1"}')),
        *((*RUN, changed(**{name: odd})) for name in ("seed", "root_seed") for odd in (-7, 10**30, "1", 1.5, None)),
        *((*RUN, changed(tasks=odd)) for odd in ("", "AA", "AZ", "{", 7)),
        *((*RUN, changed(method=odd, reference=odd)) for odd in ("none", "{", "none.py", "none:None")),
        *((*RUN, changed(parameters=odd)) for odd in ([], {"lerning": {}}, {"learning": {"alpha": 5}}, {"skills": 3})),
        *((*RUN, changed(own=odd)) for odd in ([], {"luck": 1})),
        *((*RUN, changed(**odd)) for odd in ({"odd": 1}, {"code": "x"}, {"maps": {}}, {"environment": "../e"})),
        (*RUN, changed(maps={"env3": "0" * 16})), (*RUN, changed(environment="other")),
        ("run", "--output", "x.h5", "--job", JOB), ("run", "--output", "", *RUN[3:], JOB),
        *((*RUN, JOB, "--map", odd) for odd in ("env3=none", "env3=pipe", "env3.txt", "=", "")),
        (*LEARN, "--parameters", DEEP), (*LEARN, "--method-parameters", DEEP),
        ("show-map", "{"),
        ("inspect", "[0-99999999999]"), ("verify", "[0-99999999999]"), ("metrics", "{"), ("score", "{"),
        ("score", "--template", "{"),
        *(("score", odd, "--predictions", odd) for odd in ("{", "pipe", "bytes", "", ".")),
        ("new-study", "new", "--map", "env3.txt", "--seeds", HUGE),
        ("new-study", "new", "--map", "env3.txt", "--tasks", "{"),
    ],
    ids=lambda arguments: " ".join(arguments)[-40:],
)  # fmt: skip
def test_absurd_arguments_are_refused_in_one_line(arguments, tmp_path, monkeypatch, record_property):
    record_property("absurd arguments of commands, all refused", 1)
    monkeypatch.chdir(tmp_path)
    shutil.copy(MAPS / "env3.txt", tmp_path)
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "bytes").write_bytes(b"\xff")
    before = sorted(tmp_path.iterdir())
    result = CliRunner().invoke(commands, arguments)
    if isinstance(result.exception, UserError):
        assert "\n" not in str(result.exception)
    else:  # click's own refusal, which shows the usage
        assert isinstance(result.exception, SystemExit) and result.exit_code == 2, repr(result.exception)
    assert sorted(tmp_path.iterdir()) == before


def test_the_job_itself_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copy(MAPS / "env3.txt", tmp_path)
    assert CliRunner().invoke(commands, [*RUN, JOB], catch_exceptions=False).exit_code == 0
    assert (tmp_path / "x.h5").is_file()
