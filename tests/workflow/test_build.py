"""After any damage to a build or its folder, the next `make` repairs it."""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
from projects import ROOT

pytestmark = pytest.mark.slow

PACKAGES = ("setuptools", "cython", "numpy", "click", "msgspec")
"""All that a build and `ptl --version` need; installing the rest is no different and takes minutes."""

ENVIRONMENT = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}


def start(folder: Path, *arguments: str) -> subprocess.Popen:
    """Start a build in its own process group."""
    return subprocess.Popen(
        ["make", "build", *arguments], cwd=folder, env=ENVIRONMENT, start_new_session=True, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
    )  # fmt: skip


def build(folder: Path, *arguments: str, code: int = 0) -> str:
    """Build to the end; return the output."""
    run = start(folder, *arguments)
    printed, _ = run.communicate(timeout=600)
    assert (run.returncode != 0) == (code != 0), printed[-3000:]
    return printed


def version(folder: Path) -> subprocess.CompletedProcess[str]:
    """Run the installed command from another folder."""
    return subprocess.run(
        [folder / ".venv/bin/ptl", "--version"], cwd="/", env=ENVIRONMENT, capture_output=True, text=True
    )


@pytest.fixture(scope="module")
def built(tmp_path_factory) -> Iterator[Path]:
    """A checkout, built with few packages and without optimisation after two builds that were killed."""
    folder = tmp_path_factory.mktemp("build") / "checkout"
    shutil.copytree(ROOT / "ptl", folder / "ptl", ignore=shutil.ignore_patterns("__pycache__", "*.so", "_*.c"))
    for name in ("Makefile", "pyproject.toml", "README.md", "requirements-test.lock", "requirements-benchmark.lock"):
        shutil.copy(ROOT / name, folder)
    (folder / "setup.py").write_text((ROOT / "setup.py").read_text().replace('"-O3"', '"-O0"'))
    locked = re.split(r"\n(?=\S)", (ROOT / "requirements.lock").read_text())
    kept = [entry.strip() for entry in locked if entry.startswith(tuple(f"{name}==" for name in PACKAGES))]
    assert len(kept) == len(PACKAGES)
    (folder / "requirements.lock").write_text("\n".join(kept) + "\n")
    for step in ("Installing requirements.lock\n", "Building ptl\n"):
        run = start(folder)
        assert run.stdout is not None and step in iter(run.stdout.readline, "")
        with pytest.raises(subprocess.TimeoutExpired):
            run.wait(1)
        os.killpg(run.pid, signal.SIGKILL)
        run.communicate()
    yield folder


def test_a_build_that_was_killed_is_done_again_and_then_left_alone(built):
    assert "Building ptl" in build(built)
    assert version(built).stdout.startswith("ptl, version")
    assert build(built) == ""


def test_two_builds_at_once_do_the_work_once(built):
    (built / "ptl/extensions.py").open("a").write("# edited\n")
    runs = [start(built), start(built)]
    printed = "".join(run.communicate(timeout=600)[0] for run in runs)
    assert [run.returncode for run in runs] == [0, 0] and printed.count("Building ptl") == 1


def test_what_is_lost_or_edited_is_built_again_whatever_its_time(built):
    source = built / "ptl/world/_graph.pyx"
    for extension in source.parent.glob("_graph.*.so"):
        extension.unlink()
    assert "Building ptl" in build(built)
    whole = source.read_text()
    source.write_text("cdef int nothing(")
    os.utime(source, (1, 1))
    assert "_graph.pyx:1" in build(built, code=2)
    source.write_text(whole)
    printed = build(built)
    assert "Building ptl" in printed and "Installing" not in printed


def test_a_copy_never_runs_the_code_of_the_original(built, tmp_path):
    copy = tmp_path / "copy"
    shutil.copytree(built, copy, symlinks=True)
    assert re.match(f"error: {copy}/.venv: runs with the code in {built}/ptl, .* 'make build'", version(copy).stderr)
    build(copy)
    assert version(copy).returncode == 0 and str(copy) in (copy / ".venv/bin/ptl").read_text()


def test_what_is_missing_is_named_in_one_line(built, tmp_path):
    old = tmp_path / "python"
    old.write_text("#!/bin/sh\nexit 1\n")
    old.chmod(0o755)
    shutil.copytree(built, tmp_path / "copy", ignore=shutil.ignore_patterns(".venv"))
    assert "error: Python 3.11 or newer is needed" in build(tmp_path / "copy", f"PYTHON={old}", code=2)
    (built / "ptl/extensions.py").open("a").write("# edited\n")
    assert "error: no C compiler found" in build(built, "CC=nothing", code=2)
