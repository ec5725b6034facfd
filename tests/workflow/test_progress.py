"""Progress bars: for a person at a terminal, and nowhere else."""

from __future__ import annotations

import os
import pty
import subprocess
import sys

from projects import ROOMS, ROOT

from ptl.cli._progress import shown


def test_silent_without_a_terminal(capsys):
    assert list(shown(["a", "b"], "Reading")) == ["a", "b"]
    assert capsys.readouterr() == ("", "")


def test_long_command_shows_a_bar_on_a_terminal(tmp_path):
    (tmp_path / "rooms.txt").write_text(ROOMS)
    screen, terminal = pty.openpty()
    done = subprocess.run(
        [sys.executable, "-m", "ptl", "learn", "--map", "rooms.txt", "--parameters", '{"learning": {"episodes": 20}}',
         "--output", "learned.h5"],
        cwd=tmp_path, env=os.environ | {"PYTHONPATH": str(ROOT)}, stdout=subprocess.PIPE, stderr=terminal,
    )  # fmt: skip
    os.close(terminal)
    shown_text = os.read(screen, 100_000).decode()
    os.close(screen)
    assert done.returncode == 0 and done.stdout == b""
    assert "Learning tasks" in shown_text and "2/2" in shown_text
    assert (tmp_path / "learned.h5").is_file()
