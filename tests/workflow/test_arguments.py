"""Absurd arguments of single commands end in one line, at once and before anything is written."""

from __future__ import annotations

import os
import shutil

import pytest
from click.testing import CliRunner
from projects import MAPS, ROOT

from ptl.cli import commands
from ptl.errors import UserError

HUGE = "9" * 30
LEARN = ("learn", "--map", "env3.txt", "--tasks", "A")
GROW = ("grow", "--map", "env3.txt", "--environment", "e", "--output", "x.h5", "--tasks", "3", "--run", "0",
        "--root-seed", "1")  # fmt: skip
SURVEY = ("survey", "batch", "--map", "env3.txt", "--environment", "e", "--output", "x.h5", "--batch", "0", "--batches",
          "2", "--root-seed", "1")  # fmt: skip
FV = ("fv", "--map", "env3.txt", "--library", "q_learning", "--root-seed", "1", "--output", "x.h5", "--seeds", "1")
ROBUSTNESS = ("robustness", "--output", "x.h5", "--job")
FIT = ("fit", "--search", "fit.yaml", "--lives", "lives", "--output", "found", "--config")


@pytest.mark.parametrize(
    "arguments",
    [
        (*LEARN, "--tasks", "AA"), (*LEARN, "--tasks", "{"), (*LEARN, "--seed", HUGE), (*LEARN, "--root-seed", HUGE),
        (*LEARN, "--seed", "1.0"), (*LEARN, "--output", ""), (*LEARN, "--environment", "{", "--output", "x.h5"),
        (*LEARN, "--map", "{"), (*LEARN, "--parameters", "{"), (*LEARN, "--parameters", '{"learning": {"alpha": NaN}}'),
        (*LEARN, "--method-parameters", "["), (*LEARN, "--method", "{"),
        (*GROW, "--tasks", HUGE), (*GROW, "--run", HUGE), (*GROW, "--root-seed", HUGE), (*GROW, "--output", ""),
        (*SURVEY, "--batches", HUGE), (*SURVEY, "--starts", HUGE), (*SURVEY, "--starts", "9" * 5000),
        (*SURVEY, "--starts", "{"),
        (*SURVEY, "--trajectories", HUGE), (*SURVEY, "--root-seed", HUGE), (*SURVEY, "--batch", "2"),
        ("survey", "merge", "none.h5", "--output", "x.h5"),
        (*FV, "--seeds", HUGE), (*FV, "--trials", HUGE), (*FV, "--library-trials", HUGE), (*FV, "--library", "{"),
        *((*command, text) for command in (ROBUSTNESS,) for text in ("{", "{}", "[]", "1", "[" * 10**5)),
        (*ROBUSTNESS, '{"setting": "a", "environments": {}, "methods": ["none"], "seeds": 1, "root_seed": 1,'
                      ' "parameters": {}, "step_budget": 1, "growth": {}}'),
        (*LEARN, "--parameters", "[" * 10**5),
        (*FIT, "{"), (*FIT, "{}"), (*FIT[:2], "none", *FIT[3:], "{}"),
        (*FIT[:2], "pipe", *FIT[3:], "{}"), (*FIT[:2], "bytes", *FIT[3:], "{}"),
        ("readme",), ("config-docs", "none"), ("config-docs", "pipe"), ("config-docs", "bytes"),
        ("show-map", "{"),
        ("inspect", "[0-99999999999]"), ("verify", "[0-99999999999]"), ("metrics", "{"),
        ("new-study", "new", "--map", "env3.txt", "--seeds", HUGE),
        ("new-study", "new", "--map", "env3.txt", "--tasks", "{"),
    ],
    ids=lambda arguments: " ".join(arguments)[-60:],
)  # fmt: skip
def test_absurd_arguments_are_refused_in_one_line(arguments, tmp_path, monkeypatch, record_property):
    record_property("absurd arguments of commands, all refused", 1)
    monkeypatch.chdir(tmp_path)
    shutil.copy(MAPS / "env3.txt", tmp_path)
    shutil.copy(ROOT / "config/fit.yaml", tmp_path)
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "bytes").write_bytes(b"\xff")
    before = sorted(tmp_path.iterdir())
    result = CliRunner().invoke(commands, arguments)
    if isinstance(result.exception, UserError):
        assert "\n" not in str(result.exception)
    else:  # click's own refusal, which shows the usage
        assert isinstance(result.exception, SystemExit) and result.exit_code == 2, repr(result.exception)
    assert sorted(tmp_path.iterdir()) == before
