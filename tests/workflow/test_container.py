"""The commands of the container file work, run without a container: in folders of this machine, with its Python."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from projects import ROOT

import ptl

LINES = re.findall(r"^([A-Z]+) (.*)$", (ROOT / "Containerfile").read_text(), re.MULTILINE)


@pytest.mark.slow
@pytest.mark.exhaustive
def test_the_commands_of_the_container_file_install_the_package(tmp_path: Path) -> None:
    source, target = tmp_path / "source", tmp_path / "opt/ptl"
    tracked = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    for name in filter(None, tracked.split("\0")):
        if (ROOT / name).is_file():
            (source / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, source / name)
    done = []
    for keyword, command in LINES:
        if keyword == "RUN" and "apt-get" not in command:
            here = command.replace("/source", str(source)).replace("/opt/ptl", str(target))
            here = re.sub(r"^python\b", sys.executable, here)
            run = subprocess.run(["bash", "-ec", here], cwd=tmp_path, capture_output=True, text=True)
            assert run.returncode == 0, f"{command}\n{run.stderr[-3000:]}"
            done.append(command)
    assert len(done) == 2
    [entry] = [json.loads(command) for keyword, command in LINES if keyword == "ENTRYPOINT"]
    environment = {"PATH": f"{target}/bin{os.pathsep}{os.environ['PATH']}", "HOME": str(tmp_path)}
    work = tmp_path / "work"
    work.mkdir()

    def call(*arguments: str) -> str:
        run = subprocess.run([*entry, *arguments], cwd=work, env=environment, capture_output=True, text=True)
        assert run.returncode == 0, run.stderr
        return run.stdout

    assert ptl.__version__ in call("--version")
    call("make-map", "rooms", "--size", "60", "--output", "rooms.txt")
    call("learn", "--map", "rooms.txt")
    assert call("new-study", "lab", "--map", "rooms.txt").endswith("then open reports/lab/index.html\n")
