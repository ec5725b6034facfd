"""Whatever happens to a build or its folder, the next `make` mends it."""

from __future__ import annotations

import hashlib
import os
import random
import re
import shutil
import signal
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from damage import SEED
from projects import ROOT

pytestmark = pytest.mark.slow

PACKAGES = ("setuptools", "cython", "numpy", "click", "msgspec")
"""All that a build and `ptl --version` need; installing the rest is no different and takes minutes."""

ENVIRONMENT = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}


class Checkout:
    """A checkout that is built with few packages and without optimisation."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        folder.mkdir()
        for name in ("Makefile", "make_venv.py", "pyproject.toml", "README.md"):
            shutil.copy(ROOT / name, folder)
        shutil.copytree(ROOT / "ptl", folder / "ptl", ignore=shutil.ignore_patterns("__pycache__", "*.so", "_*.c"))
        (folder / "setup.py").write_text((ROOT / "setup.py").read_text().replace('"-O3"', '"-O0"'))
        locked = re.split(r"\n(?=\S)", (ROOT / "requirements.lock").read_text())
        kept = [entry.strip() for entry in locked if entry.startswith(tuple(f"{name}==" for name in PACKAGES))]
        assert len(kept) == len(PACKAGES)
        (folder / "requirements.lock").write_text("\n".join(kept) + "\n")

    def start(self) -> subprocess.Popen:
        """Start a build in a process group of its own."""
        return subprocess.Popen(
            ["make", "build"], cwd=self.folder, env=ENVIRONMENT, start_new_session=True, text=True,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        )  # fmt: skip

    def build(self) -> str:
        """Build to the end; return what was printed."""
        run = self.start()
        printed, _ = run.communicate(timeout=600)
        assert run.returncode == 0, printed[-3000:]
        return printed

    def ptl(self, *arguments: str, folder: Path | None = None) -> subprocess.CompletedProcess[str]:
        """Run the installed command, from another folder."""
        command = [self.folder / ".venv/bin/ptl", *arguments]
        return subprocess.run(command, cwd=folder or "/", env=ENVIRONMENT, capture_output=True, text=True)

    def origin(self) -> str:
        """Return the folder of the kernel that the environment's Python imports."""
        code = "from ptl.agent import _kernel; print(_kernel.__file__)"
        done = subprocess.run(
            [self.folder / ".venv/bin/python", "-c", code], cwd="/", env=ENVIRONMENT, capture_output=True, text=True
        )
        assert done.returncode == 0, done.stderr
        return str(Path(done.stdout.strip()).parents[2])


@pytest.fixture(scope="module")
def built(tmp_path_factory) -> Iterator[Checkout]:
    """A checkout whose first build is killed four times, and whose last ones are started twice at once."""
    checkout = Checkout(tmp_path_factory.mktemp("build") / "checkout")
    chance = random.Random(SEED)
    hits, printed = 0, []
    for number, latest in enumerate((0.3, 2, 6, 15)):
        run = checkout.start()
        try:
            run.wait(chance.uniform(latest / 3, latest))
        except subprocess.TimeoutExpired:
            os.killpg(run.pid, (signal.SIGKILL, signal.SIGINT)[number % 2])
            hits += 1
        printed.append(run.communicate()[0])
    assert hits >= 3, printed
    checkout.hits = hits
    first = checkout.start()
    time.sleep(1)
    checkout.second = checkout.build()
    checkout.first, _ = first.communicate()
    assert first.returncode == 0, checkout.first
    yield checkout


def test_a_build_that_was_killed_or_doubled_is_mended_by_the_next(built, record_property):
    record_property("builds killed, moved and doubled, all mended", built.hits)
    assert "waiting for another" in built.second and "Building ptl" not in built.second
    assert built.ptl("--version").stdout.startswith("ptl, version")
    assert built.origin() == str(built.folder)
    assert built.build() == ""


def test_a_build_waits_for_what_a_killed_one_left_behind(tmp_path):
    checkout = Checkout(tmp_path / "checkout")
    run = checkout.start()
    children = Path(f"/proc/{run.pid}/task/{run.pid}/children")
    while not (checkout.folder / ".venv/pyvenv.cfg").exists():
        assert run.poll() is None
        time.sleep(0.01)
    [program] = children.read_text().split()  # make_venv.py, which goes without what it has started
    os.kill(int(program), signal.SIGKILL)
    run.communicate()
    following = checkout.start()
    assert following.stdout is not None and "waiting for another" in following.stdout.readline()
    os.killpg(following.pid, signal.SIGKILL)
    following.communicate()


def test_a_copy_never_runs_the_code_of_the_original(built, tmp_path, record_property):
    record_property("builds killed, moved and doubled, all mended", 1)
    copy = object.__new__(Checkout)
    copy.folder = tmp_path / "copy"
    shutil.copytree(built.folder, copy.folder, symlinks=True)
    done = copy.ptl("--version")
    assert done.returncode == 1 and done.stdout == ""
    assert done.stderr.startswith(f"error: {copy.folder}/.venv: was copied") and "make build" in done.stderr
    copy.build()
    assert copy.ptl("--version").returncode == 0
    assert copy.origin() == str(copy.folder)
    assert built.origin() == str(built.folder)


def test_what_is_lost_or_replaced_is_built_again_whatever_its_time(built, record_property):
    record_property("builds killed, moved and doubled, all mended", 1)
    source, version = built.folder / "ptl/world/_graph.pyx", built.folder / "ptl/__init__.py"
    for extension in source.parent.glob("_graph.*.so"):
        extension.unlink()
    assert "Building ptl" in built.build()
    source.write_text(source.read_text() + "# older\n")
    version.write_text(version.read_text().replace('__version__ = "', '__version__ = "9.'))
    for path in (source, version):
        os.utime(path, (1, 1))
    assert "Building ptl" in built.build()
    [extension] = source.parent.glob("_graph.*.so")
    assert hashlib.sha256(source.read_bytes()).hexdigest().encode() in extension.read_bytes()
    [metadata] = built.folder.glob(".venv/lib/*/site-packages/ptl-*.dist-info")
    assert metadata.name.startswith("ptl-9.")


def test_a_source_that_does_not_compile_leaves_the_packages_alone(built):
    path = built.folder / "ptl/world/_graph.pyx"
    whole = path.read_text()
    path.write_text("cdef int nothing(")
    run = built.start()
    printed, _ = run.communicate(timeout=300)
    assert run.returncode != 0 and "error: the package could not be built" in printed
    path.write_text(whole)
    assert "Installing" not in built.build()
