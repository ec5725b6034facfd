"""One run at a time in a folder, also on a file system without locks."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
from pathlib import Path

import pytest
from projects import ROOT

NO_LOCKS = """
import errno, fcntl, os

def flock(file, operation):
    raise OSError(getattr(errno, {name!r}), "no locks here")

fcntl.flock = flock
"""
HOLD = """
import os
from ptl.files import lock

lock.ENDING = 2
stdin = os.dup(0)
lock.begin_run()
print("held", flush=True)
os.read(stdin, 1)
"""


def hold(folder: Path, name: str = "") -> subprocess.Popen[str]:
    """Start a process that holds the folder until it gets a line; its file system may have no locks."""
    place = folder.parent / "site"
    place.mkdir(exist_ok=True)
    (place / "sitecustomize.py").write_text(NO_LOCKS.format(name=name) if name else "")
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(place), str(ROOT)])}
    return subprocess.Popen(
        [sys.executable, "-c", HOLD], cwd=folder, env=environment, text=True,
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip


@pytest.mark.parametrize("name", ["", "ENOSYS", "ENOLCK", "EOPNOTSUPP"])
def test_a_second_run_is_refused_while_the_first_one_works(tmp_path: Path, name: str) -> None:
    folder = tmp_path / "study"
    folder.mkdir()
    first = hold(folder, name)
    assert first.stdout.readline() == "held\n"
    _, refused = hold(folder, name).communicate("\n", timeout=60)
    remedy = "if it has ended, remove .snakemake/ptl.lock" if name else "wait for it or end it first"
    assert f"is running in this folder (process {first.pid} on {socket.gethostname()}); {remedy}" in refused
    _, said = first.communicate("\n", timeout=60)
    assert ("this file system has no locks; start one run at a time here" in said) == bool(name)
    third = hold(folder, name)
    assert third.stdout.readline() == "held\n"
    third.communicate("\n", timeout=60)


def test_a_run_that_is_ending_is_waited_for(tmp_path: Path) -> None:
    folder = tmp_path / "study"
    folder.mkdir()
    first = hold(folder)
    assert first.stdout.readline() == "held\n"
    second = hold(folder)
    assert second.stderr.readline() == f"waiting for another run here (process {first.pid}) to end\n"
    first.communicate("\n", timeout=60)
    assert second.stdout.readline() == "held\n"
    second.communicate("\n", timeout=60)


def test_a_killed_run_is_not_waited_for_without_locks(tmp_path: Path) -> None:
    folder = tmp_path / "study"
    folder.mkdir()
    first = hold(folder, "ENOLCK")
    assert first.stdout.readline() == "held\n"
    first.kill()
    first.wait()
    assert (folder / ".snakemake/ptl.lock").read_text() == f"{first.pid} on {socket.gethostname()}"
    second = hold(folder, "ENOLCK")
    assert second.stdout.readline() == "held\n"
    second.communicate("\n", timeout=60)


def test_another_fault_of_locking_is_one_line(tmp_path: Path) -> None:
    folder = tmp_path / "study"
    folder.mkdir()
    _, said = hold(folder, "EIO").communicate("\n", timeout=60)
    assert said == "error: .snakemake/ptl.lock: cannot be locked (no locks here); run in another folder\n"
