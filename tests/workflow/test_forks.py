"""Jobs forked from the server of a run do what `python -m ptl` does."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import psutil
import pytest
from projects import ROOMS, ROOT, imports_of_a_fork

from ptl.cli.forks import client
from ptl.config import Parameters
from ptl.errors import INTERRUPTED
from ptl.jobs import Grow
from ptl.world.gridworld import map_digest

HOST = "import sys; from ptl.cli import forks; print(forks.start_server(), flush=True); sys.stdin.read()"
"""What starts a server and ends with its own standard input, as a run would."""


def grow(tasks: int) -> str:
    """A job as JSON."""
    return Grow(
        root_seed=1, parameters=Parameters().to_dict(), maps={"rooms": map_digest(ROOMS)}, code="0" * 16,
        environment="rooms", tasks=tasks, seed=0,
    ).text  # fmt: skip


class Host(NamedTuple):
    """A process that has started a server."""

    process: subprocess.Popen[str]
    server: str


def server_of(host: Host) -> psutil.Process:
    """The process of the server."""
    [server] = psutil.Process(host.process.pid).children()
    return server


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with a map."""
    (tmp_path / "rooms.txt").write_text(ROOMS)
    return tmp_path


@pytest.fixture
def host(folder: Path) -> Iterator[Host]:
    process = subprocess.Popen(
        [sys.executable, "-c", HOST], cwd=folder, env=os.environ | {"PYTHONPATH": str(ROOT)}, text=True,
        stdin=subprocess.PIPE, stdout=subprocess.PIPE,
    )  # fmt: skip
    yield Host(process, process.stdout.readline().strip())
    process.communicate()


def forked(host: Host, folder: Path, *arguments: str) -> subprocess.Popen[str]:
    """Start a job by the server."""
    return called(folder, "-I", "-S", str(client.__file__), host.server, *arguments)


def called(folder: Path, *arguments: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, *arguments], cwd=folder, env=os.environ | {"PYTHONPATH": str(ROOT)}, text=True,
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip


@pytest.mark.parametrize(
    "arguments",
    [
        ("run", "--job", grow(3), "--map", "rooms=rooms.txt", "--output", "{}.h5"),
        ("run", "--job", grow(3), "--output", "{}.h5"),
        ("run", "--job", "{{}}", "--output", "{}.h5"),
        ("run", "--hel", "ä\udcff"),
        ("show-map", "rooms.txt"),
        ("show-map", "--help"),
    ],
)
def test_a_fork_does_the_same_as_a_process_of_its_own(host, folder, arguments):
    outcomes = []
    for start in (lambda *args: forked(host, folder, *args), lambda *args: called(folder, "-m", "ptl", *args)):
        job = start(*(argument.replace("{}", "made") for argument in arguments))
        printed = job.communicate()
        made = folder / "made.h5"
        outcomes.append((job.returncode, *printed, made.read_bytes() if made.exists() else None))
        made.unlink(missing_ok=True)
    assert outcomes[0] == outcomes[1]


def test_the_server_has_imported_what_a_job_imports(folder):
    """A job finds numpy and h5py in the memory of the server."""
    assert imports_of_a_fork(folder, grow(1), maps=("--map=rooms=rooms.txt",)) == set()


def test_the_server_ends_with_the_process_that_started_it(host):
    server = server_of(host)
    host.process.kill()
    server.wait(10)
    assert not server.is_running()


def long_job(host: Host, folder: Path) -> tuple[subprocess.Popen[str], psutil.Process]:
    """Start a job that does not end, and return its client and its fork."""
    job = forked(host, folder, "run", "--job", grow(100_000), "--map", "rooms=rooms.txt", "--output", "made.h5")
    deadline = time.monotonic() + 20
    while not (forks := server_of(host).children()) and time.monotonic() < deadline:
        time.sleep(0.02)
    return job, forks[0]


def test_an_interrupted_job_says_so_in_one_line(host, folder):
    job, fork = long_job(host, folder)
    time.sleep(0.5)  # until it learns
    for process in (job, fork):  # a terminal sends the signal to both
        process.send_signal(signal.SIGINT)
    assert job.communicate()[1] == f"error: {INTERRUPTED}\n"
    assert not (folder / "made.h5").exists()


def test_a_job_whose_fork_is_killed_fails(host, folder):
    job, fork = long_job(host, folder)
    fork.kill()
    assert job.communicate()[1] == "error: the process of the job was killed\n"
    assert job.returncode == 1


def test_a_job_starts_on_its_own_when_the_server_was_killed(host, folder):
    os.kill(server_of(host).pid, signal.SIGKILL)
    job = forked(host, folder, "run", "--job", grow(3), "--map", "rooms=rooms.txt", "--output", "made.h5")
    assert job.communicate() == ("", "") and job.returncode == 0
    assert (folder / "made.h5").is_file()


@pytest.mark.skipif(os.getuid() != 0, reason="only root can become another user")
def test_another_user_starts_no_job(host, folder):
    code = "import _socket, os; from ptl.cli.forks import client; os.setuid(65534); client.main()"
    job = called(folder, "-c", code, host.server, "show-map", "rooms.txt")
    assert job.communicate()[0] == "" and job.returncode == 1
