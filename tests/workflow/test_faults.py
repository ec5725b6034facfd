"""Killed, damaged, starved of disk: a run goes on to the same bytes, and no damage stays unseen."""

from __future__ import annotations

import itertools
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import psutil
import pytest
from click.testing import CliRunner
from damage import SEED, damages
from projects import ROOMS, ROOT, TARGETS, Project

from ptl.cli import commands
from ptl.cli.verify import _checkable
from ptl.config import Parameters
from ptl.errors import UserError
from ptl.files import store
from ptl.files.atomic import UNFINISHED, atomic_path, remove_unfinished, write_text
from ptl.files.lock import LOCK
from ptl.jobs import Grow
from ptl.world.gridworld import map_digest


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory) -> Project:
    project = Project(tmp_path_factory.mktemp("undisturbed"))
    started = time.monotonic()
    project.make(*TARGETS)
    project.seconds = time.monotonic() - started
    return project


# -- kill -------------------------------------------------------------------------------------------------------


def start(project: Project, *arguments: str) -> subprocess.Popen:
    """`ptl workflow` in its own process group, so that a kill ends all of it and nothing else."""
    return subprocess.Popen(
        [sys.executable, "-m", "ptl", "workflow", "-j2", *arguments],
        cwd=project.folder, env=project.environment, start_new_session=True,
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip


def kill_all(run: subprocess.Popen) -> bool:
    os.killpg(run.pid, signal.SIGKILL)
    return True


def kill_snakemake_only(run: subprocess.Popen) -> bool:
    run.kill()
    return True


def servers(run: subprocess.Popen) -> list[psutil.Process]:
    """The process that jobs are forked from, in a list that is empty before it is started."""
    return [process for process in psutil.Process(run.pid).children() if "ptl.cli.forks" in process.cmdline()]


def kill_one_job(run: subprocess.Popen) -> bool:
    """Kill one process of a job; False if none is running."""
    jobs = [job for server in servers(run) for job in server.children()]
    for process in jobs[:1]:
        process.kill()
    return bool(jobs)


def kill_server(run: subprocess.Popen) -> bool:
    """Kill the process that jobs are forked from; False if there is none."""
    for process in servers(run):
        process.kill()
    return bool(servers(run))


def disturb(project: Project, kill: Callable, moment: float, *arguments: str) -> bool:
    """Start a run and kill it, or a part of it, after some seconds; False if it was complete by then."""
    run = start(project, *arguments)
    try:
        try:
            assert run.wait(moment) == 0  # nothing but a kill ends a run early
            return False
        except subprocess.TimeoutExpired:
            pass
        deadline = time.monotonic() + 5
        hit = False
        while not hit and run.poll() is None and time.monotonic() < deadline:
            try:
                hit = kill(run)
            except psutil.Error:  # ended meanwhile
                continue
        run.wait(400)
        return hit
    finally:
        if run.poll() is None:
            os.killpg(run.pid, signal.SIGKILL)
            run.wait()


def finish(project: Project, *arguments: str) -> None:
    """Run again, as `make` does, regardless of earlier faults."""
    done = project.ptl("workflow", "-j2", *arguments)
    assert done.returncode == 0, done.stderr[-3000:]


@pytest.mark.slow
def test_killed_runs_end_in_the_same_bytes(undisturbed, tmp_path, record_property):
    chance = random.Random(SEED)
    project = Project(tmp_path / "killed")
    hits = 0
    for kill in (kill_all, kill_snakemake_only, kill_one_job, kill_server):
        # The first third of a run is the start of Snakemake itself.
        moment = undisturbed.seconds * chance.uniform(0.2, 0.6)
        hits += disturb(project, kill, moment, *TARGETS)
    record_property("runs killed", hits)
    assert hits
    finish(project, *TARGETS)
    assert project.files("results", "reports") == undisturbed.files("results", "reports")
    assert not list(project.folder.rglob(f"{UNFINISHED}*"))
    done = project.ptl("verify", "results", "reports")
    assert done.returncode == 0, done.stdout


@pytest.mark.slow
@pytest.mark.exhaustive
def test_smoke_run_killed_many_times_ends_in_the_same_bytes(tmp_path, record_property):
    """Every product of the smoke run, killed in turn as a whole, without its jobs, in one job, and in their server."""
    chance = random.Random(f"{SEED} smoke")
    config = ("--configfile", "config/smoke.yaml")
    reference, project = Project(tmp_path / "reference", None), Project(tmp_path / "killed", None)
    started = time.monotonic()
    reference.make(*config)
    seconds = time.monotonic() - started
    hits = 0
    kills = itertools.cycle((kill_all, kill_snakemake_only, kill_one_job, kill_server))
    while hits < 6:
        if disturb(project, next(kills), seconds * chance.uniform(0.1, 0.5), *config):
            hits += 1
        else:  # complete too soon: lose a part of it
            shutil.rmtree(project.folder / "results/smoke/learning")
            shutil.rmtree(project.folder / "reports/smoke")
    record_property("runs killed", hits)
    finish(project, *config)
    assert project.files("results", "reports") == reference.files("results", "reports")
    assert not list(project.folder.rglob(f"{UNFINISHED}*"))
    done = project.ptl("verify", "results", "reports")
    assert done.returncode == 0, done.stdout


@pytest.mark.slow
def test_a_second_run_is_refused_while_the_first_goes_on_and_not_after_it_was_killed(tmp_path):
    project = Project(tmp_path / "busy", seeds=40)  # takes longer than a second run needs to start
    lock = project.folder / LOCK
    run = start(project, "learning")
    try:
        deadline = time.monotonic() + 60
        while not (lock.exists() and lock.read_text()) and time.monotonic() < deadline:
            time.sleep(0.05)
        os.kill(run.pid, signal.SIGSTOP)  # so that it cannot end while we ask
        for command in ((project.ptl, "workflow"), (project.snakemake,)):
            done = command[0](*command[1:], "-j2", "learning")
            assert done.returncode == 1 and "Traceback" not in done.stderr
            assert f"error: snakemake is running in this folder (process {run.pid} on " in done.stderr
        assert "learning" in project.snakemake("-n", "learning").stdout
    finally:
        os.killpg(run.pid, signal.SIGKILL)
        run.wait()
    finish(project, "learning")


def test_of_runs_that_begin_at_once_one_goes_on_and_the_others_are_refused(tmp_path):
    begin = (
        "import os; from ptl.files import lock; lock.ENDING = 0.5; told = os.dup(0)"
        "; lock.begin_run(); os.read(told, 1)"  # until it is told to end: the lock takes the standard input
    )
    runs = [
        subprocess.Popen(
            [sys.executable, "-c", begin], cwd=tmp_path, env=os.environ | {"PYTHONPATH": str(ROOT)}, text=True,
            stdin=subprocess.PIPE, stderr=subprocess.PIPE,
        )
        for _ in range(4)
    ]  # fmt: skip
    deadline = time.monotonic() + 60
    while sum(run.poll() is None for run in runs) > 1 and time.monotonic() < deadline:
        time.sleep(0.05)
    (first,) = (run for run in runs if run.poll() is None)
    for run in runs:
        says = run.communicate("\n")[1]
        assert run.returncode == int(run is not first)
        assert run is first or f"error: snakemake is running in this folder (process {first.pid} on " in says


def test_jobs_left_behind_by_a_killed_run_are_waited_for(tmp_path):
    hold = "from ptl.files.lock import hold_folder; hold_folder()"
    leave = f"import os, subprocess; {hold}; subprocess.Popen(['sleep', '3'], stderr=subprocess.DEVNULL); os._exit(1)"
    for code, says in ((leave, ""), (hold, "waiting for jobs of a killed run"), (hold, "")):
        done = subprocess.run(
            [sys.executable, "-c", code], cwd=tmp_path, env=os.environ | {"PYTHONPATH": str(ROOT)}, text=True,
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
        )  # fmt: skip
        assert (says in done.stderr) and bool(says) == bool(done.stderr)


# -- damage -----------------------------------------------------------------------------------------------------


@pytest.fixture
def kept(tiny) -> Iterator[Project]:
    """The tiny run, put back after each test."""
    before = tiny.files("results", "reports")
    yield tiny
    for name, content in before.items():
        path = tiny.folder / name
        if not path.is_file() or path.read_bytes() != content:
            path.write_bytes(content)


def results_of(project: Project) -> list[Path]:
    """One file of each kind in the folder of results."""
    names = ["learning/rooms/ptl/seed_000.h5", "growth/run_000.h5", "subgoal_frequencies/rooms.h5", "steps.h5"]
    return [project.folder / "results/tiny" / name for name in names]


def test_every_damage_is_found(kept, record_property):
    """A change of any byte is detected, even of unused ones."""
    chance = random.Random(SEED)
    tried = 0
    for path in results_of(kept):
        whole = path.read_bytes()
        store.read_arrays(path)
        for what, damaged in damages(whole, chance):
            if damaged == whole:
                continue
            tried += 1
            path.write_bytes(damaged)
            with pytest.raises(UserError) as caught:
                store.read_arrays(path)
            line = str(caught.value)
            assert line.startswith(f"{path}: ") and "\n" not in line and "remove it" in line, f"{what}: {line}"
        path.write_bytes(whole)
    record_property("damages tried, all found: result files", tried)
    assert tried > 100


SWAPS = [
    ("learning/rooms/ptl/seed_000.h5", "learning/rooms/ptl/seed_001.h5"),
    ("learning/rooms/ptl/seed_000.h5", "learning/rooms/no_transfer/seed_000.h5"),
    ("learning/rooms/ptl/seed_000.h5", "growth/run_000.h5"),
    ("growth/run_001.h5", "growth/run_000.h5"),
    ("subgoal_frequencies/rooms.h5", "learning/rooms/ptl/seed_001.h5"),
]
"""Results and those of other jobs that could be mistaken for them."""


@pytest.mark.parametrize(("product", "other"), SWAPS)
def test_files_of_other_jobs_are_found(tiny, tmp_path, product, other):
    """By the place alone, as before the end of a run, which writes made.json."""
    results = tmp_path / "results/tiny"
    for name in (product, other):
        (results / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(tiny.folder / "results/tiny" / other, results / name)
    done = CliRunner().invoke(commands, ["verify", str(results / product)])
    assert isinstance(done.exception, UserError) and f"is the file {other} of a run" in done.output


# -- disk -------------------------------------------------------------------------------------------------------

GROW = Grow(
    root_seed=1, parameters=Parameters().to_dict(), maps={"rooms": map_digest(ROOMS)}, code="0" * 16,
    environment="rooms", tasks=3, seed=0,
)  # fmt: skip
COMMANDS = {
    "learn": ["learn", "--map", "rooms.txt", "--environment", "rooms", "--tasks", "AB", "--method", "ptl", "--seed",
              "0", "--root-seed", "1", "--output", "{}/learned.h5"],
    "run": ["run", "--job", GROW.text.replace("{", "{{").replace("}", "}}"), "--map", "rooms=rooms.txt", "--output",
            "{}/grown.h5"],
}  # fmt: skip
"""The commands that write results."""


@pytest.mark.parametrize(("command", "limit"), [("learn", 0), ("run", 20)])
def test_full_disk_is_one_line_and_leaves_nothing(tiny, command, limit):
    """A limit on the size of files, which fails like a full disk and needs no special rights."""
    folder = tiny.folder / f"full_{command}_{limit}"
    arguments = [part.format(folder.name) for part in COMMANDS[command]]
    done = tiny.ptl(*arguments, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)))
    assert done.returncode == 1, done.stderr
    [line] = done.stderr.splitlines()
    assert line.startswith("error: ") and f"{folder.name}/" in line and "cannot be written" in line
    assert list(folder.rglob("*")) == []


def test_unwritable_place_is_one_line(tiny):
    """A file where a folder is needed: unwritable for root as well."""
    (tiny.folder / "blocked").write_text("")
    done = tiny.ptl(*(part.format("blocked") for part in COMMANDS["run"]))
    assert done.returncode == 1
    [line] = done.stderr.splitlines()
    assert line.startswith("error: ") and "cannot be written" in line


def test_disk_that_fills_up_while_writing(tmp_path):
    """At every size between nothing and the whole file, the old product stays and no other appears."""
    path = tmp_path / "product.bin"
    write_text(path, "old")
    code = (
        "import resource, sys; from ptl.files.atomic import atomic_path\n"
        "limit = int(sys.argv[2]); resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))\n"
        "with atomic_path(sys.argv[1]) as place: place.write_bytes(b'x' * 5000)\n"
    )
    for limit in (0, 1, 4096, 4999):
        done = subprocess.run([sys.executable, "-c", code, path, str(limit)], capture_output=True, text=True)
        assert "cannot be written (File too large)" in done.stderr
        assert path.read_text() == "old" and list(tmp_path.iterdir()) == [path]


def test_unfinished_files_are_not_products(tmp_path):
    (tmp_path / "results/learning").mkdir(parents=True)
    with pytest.raises(KeyboardInterrupt), atomic_path(tmp_path / "results/learning/a.h5") as temporary:
        assert temporary.name.startswith(UNFINISHED) and temporary.suffix == ".h5"
        assert list(_checkable(tmp_path)) == []
        copy = temporary.with_name(f"{UNFINISHED}left-a.h5")
        shutil.copy(temporary, copy)
        raise KeyboardInterrupt
    assert not temporary.exists() and copy.exists()
    (tmp_path / "results/kept.csv").write_text("")
    remove_unfinished(tmp_path / "results", tmp_path / "no such folder")
    assert [path.name for path in tmp_path.rglob("*") if path.is_file()] == ["kept.csv"]
