"""The command line: its help, one line for a wrong call, and arguments that are passed on."""

from __future__ import annotations

import re
from pathlib import Path

import click
import pytest
from click.testing import CliRunner
from projects import ROOMS

from ptl.cli import COMMANDS, UPKEEP, commands, workflow
from ptl.errors import UserError
from ptl.files.lock import begin_run


def test_help_lists_every_command_once_and_those_for_people_first() -> None:
    printed = CliRunner().invoke(commands, ["--help"]).output
    names = re.findall(r"^  ([a-z][a-z-]+) ", printed.split("Commands:")[1], re.MULTILINE)
    with click.Context(commands) as context:
        known = commands.list_commands(context)
    assert sorted(names) == known and {*COMMANDS, *UPKEEP} < set(known)
    assert tuple(names[: len(COMMANDS)]) == COMMANDS


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("learn --configfile nofile.yaml", "ptl learn: No such option '--configfile' (see 'ptl learn --help')"),
        ("learn", "ptl learn: Missing option '--map' (see 'ptl learn --help')"),
        ("--bad", "ptl: No such option '--bad' (see 'ptl --help')"),
        ("teach", "ptl: No such command 'teach' (see 'ptl --help')"),
    ],
)
def test_a_wrong_call_is_one_line(arguments: str, message: str) -> None:
    with pytest.raises(UserError, match=f"^{re.escape(message)}$"):
        commands(arguments.split(), prog_name="ptl")


def test_learn_needs_only_a_map(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("rooms.txt").write_text(ROOMS)
    printed = CliRunner().invoke(commands, ["learn", "--map", "rooms.txt"], catch_exceptions=False).output
    assert "rooms_ptl_0.h5" in printed and Path("rooms_ptl_0.h5").is_file()


def test_workflow_passes_its_arguments_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Without the ``--``, Snakemake takes the targets for configuration files."""
    passed: list[str] = []
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(workflow.os, "execve", lambda _, arguments, environment: passed.extend(arguments))
    given = ["-j2", "--configfile", "a.yaml", "--", "--odd", "results/x.h5", "--", "--help"]
    CliRunner().invoke(workflow.command, given, catch_exceptions=False)
    assert passed[-len(given) :] == given


def test_a_run_needs_a_folder_that_it_can_write_to(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path(".snakemake").write_text("no folder")
    with pytest.raises(SystemExit, match=r"^error: \.snakemake/ptl\.lock: cannot be written \(.*\); make this folder"):
        begin_run()
