"""What is printed on terminals whose encoding lacks some letters."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from projects import ROOT

CODE = """
import sys, click
from ptl import cli
sys.argv = ["ptl"]
cli.commands = lambda **_: click.echo({text!r})
cli.main()
"""


@pytest.mark.parametrize(
    ("encoding", "text", "shown"),
    [
        ("latin-1", "−718.8 × ∞ ± 2 … é", b"-718.8 \xd7 inf \xb1 2 ... \xe9\n"),
        ("cp1252", "−718.8 – ☃", b"-718.8 \x96 \\u2603\n"),
        ("utf-8", "−718.8", "−718.8\n".encode()),
    ],
)
def test_numbers_are_printed_in_every_encoding(tmp_path: Path, encoding: str, text: str, shown: bytes) -> None:
    environment = os.environ | {"PYTHONPATH": str(ROOT), "PYTHONIOENCODING": encoding}
    command = [sys.executable, "-c", CODE.format(text=text)]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True)
    assert (done.returncode, done.stdout) == (0, shown), done.stderr


def test_arguments_that_are_no_text_are_still_refused(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "ptl", "show-map", b"\xff.txt"], cwd=tmp_path, capture_output=True,
        env=os.environ | {"PYTHONPATH": str(ROOT), "PYTHONIOENCODING": "utf-8"},
    )  # fmt: skip
    assert done.returncode == 1 and done.stderr.count(b"\n") == 1 and b"Traceback" not in done.stderr


def test_output_that_cannot_be_written_and_a_folder_that_is_gone_are_one_line(tmp_path: Path) -> None:
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    for command, says in (
        (f"{sys.executable} -m ptl --help > /dev/full", "the output cannot be written (No space left on device)"),
        (f'rmdir "$PWD" && {sys.executable} -m ptl workflow -n', "the present folder has been removed"),
    ):
        done = subprocess.run(["bash", "-c", command], cwd=tmp_path, env=environment, capture_output=True, text=True)
        assert done.returncode == 1 and done.stderr.startswith(f"error: {says}"), done.stderr
