"""Killed, damaged, starved of disk: a run goes on to the same bytes, and no damage stays unseen."""

from __future__ import annotations

import itertools
import os
import random
import re
import resource
import shlex
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import h5py
import psutil
import pytest
from test_workflow import Project

from ptl.files import UNFINISHED, atomic_path, expand_numbers, write_text
from ptl.hdf5 import sealed
from ptl.manifest import TIMED, TIMED_LINE
from ptl.verification import checkable, faults_of

SEED = 20_190_306
"""Every random moment, byte and bit below comes from this seed."""

SMALL = """
run: tiny
seeds: 2
environments:
  rooms: {map: rooms.txt, title: Two rooms, tasks: AB}
methods: [no_transfer, ptl]
learning: {episodes: 20}
statistics: {resamples: 100}
growth: {environment: rooms, tasks: 3, runs: 2, breakpoint: 1}
subgoal_frequencies: {trajectories: 3, starts: 4, batches: 2}
"""

TARGETS = (
    "reports/tiny/tables/per_seed.csv",
    "reports/tiny/tables/growth.csv",
    "results/tiny/subgoal_frequencies/rooms.h5",
)
"""Made by jobs of each kind that stores results: learning, growth, survey (with temporary files), measures."""


def small_project(folder: Path) -> Project:
    folder.mkdir(parents=True, exist_ok=True)
    project = Project(folder)
    (folder / "tiny.yaml").write_text(SMALL)
    shutil.copy(folder / "tiny.yaml", folder / "config/config.yaml")
    return project


def products(project: Project) -> dict[str, bytes]:
    """Bytes of all products; of those with measured times only that they are there."""
    found = {}
    for name, content in project.files("results", "reports").items():
        table = (project.folder / name).with_suffix("")  # of a checksum
        if any(stem in name for stem in TIMED) or (name.endswith(".sha256") and TIMED_LINE in table.read_bytes()):
            content = b""
        found[name] = b"".join(line for line in content.splitlines(True) if TIMED_LINE not in line)
    return {name: content for name, content in found.items() if "manifest.json" not in name}


def ptl(project: Project, *arguments: str | Path, **options) -> subprocess.CompletedProcess:
    environment = dict(os.environ, PYTHONPATH=str(project.folder))
    return subprocess.run(
        [sys.executable, "-m", "ptl", *map(str, arguments)],
        cwd=project.folder, env=environment, capture_output=True, text=True, timeout=300, **options,
    )  # fmt: skip


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory) -> Project:
    project = small_project(tmp_path_factory.mktemp("undisturbed"))
    started = time.monotonic()
    done = project.snakemake(*TARGETS)
    assert done.returncode == 0, done.stderr[-3000:]
    project.seconds = time.monotonic() - started
    return project


# -- kill -------------------------------------------------------------------------------------------------------


def start(project: Project, *arguments: str) -> subprocess.Popen:
    """`ptl workflow` in a process group of its own, so that a kill can take all of it and nothing else."""
    environment = dict(os.environ, PYTHONPATH=str(project.folder))
    return subprocess.Popen(
        [sys.executable, "-m", "ptl", "workflow", "-j2", *arguments],
        cwd=project.folder, env=environment, start_new_session=True,
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip


def kill_all(run: subprocess.Popen) -> bool:
    os.killpg(run.pid, signal.SIGKILL)
    return True


def kill_snakemake_only(run: subprocess.Popen) -> bool:
    run.kill()
    return True


def kill_one_job(run: subprocess.Popen) -> bool:
    """Kill one process of a job; False if none is running."""
    jobs = [process for process in psutil.Process(run.pid).children(recursive=True) if "ptl" in process.cmdline()]
    for process in jobs[:1]:
        process.kill()
    return bool(jobs)


def disturb(project: Project, kill: Callable, moment: float, *arguments: str) -> bool:
    """Start a run and kill it, or a part of it, after so many seconds; False if it had ended by then."""
    run = start(project, *arguments)
    try:
        try:
            run.wait(moment)
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
        run.wait(120)
        return hit
    finally:
        if run.poll() is None:
            os.killpg(run.pid, signal.SIGKILL)
            run.wait()


def finish(project: Project, *arguments: str) -> None:
    """What `make` does: run again, whatever happened before."""
    done = ptl(project, "workflow", "-j2", *arguments)
    assert done.returncode == 0, done.stderr[-3000:]


def test_killed_runs_end_in_the_same_bytes(undisturbed, tmp_path, record_property):
    chance = random.Random(SEED)
    project = small_project(tmp_path / "killed")
    hits = 0
    for kill in (kill_all, kill_snakemake_only, kill_one_job):
        # The first third of a run is the start of Snakemake itself.
        moment = undisturbed.seconds * chance.uniform(0.2, 0.6)
        hits += disturb(project, kill, moment, *TARGETS)
    record_property("runs killed", hits)
    assert hits
    finish(project, *TARGETS)
    assert products(project) == products(undisturbed)
    assert not list(project.folder.rglob(f"{UNFINISHED}*"))
    done = ptl(project, "verify", "results", "reports")
    assert done.returncode == 0, done.stdout


@pytest.mark.slow
def test_smoke_run_killed_many_times_ends_in_the_same_bytes(tmp_path, record_property):
    """Every product of the smoke run, killed in turn as a whole, without its jobs, and in one job."""
    chance = random.Random(f"{SEED} smoke")
    config = ("--configfile", "config/smoke.yaml")
    for name in ("reference", "killed"):
        (tmp_path / name).mkdir()
    reference, project = Project(tmp_path / "reference"), Project(tmp_path / "killed")
    done = reference.snakemake(*config)
    assert done.returncode == 0, done.stderr[-3000:]
    hits = 0
    kills = itertools.cycle((kill_all, kill_snakemake_only, kill_one_job))
    for _ in range(40):
        hits += disturb(project, next(kills), chance.uniform(1, 20), *config)
        if hits == 10:
            break
        if (project.folder / "reports/smoke/manifest.json").exists():  # done too soon: lose a part of it
            shutil.rmtree(project.folder / "results/smoke/learning")
            shutil.rmtree(project.folder / "reports/smoke")
    record_property("runs killed", hits)
    assert hits == 10
    finish(project, *config)
    assert products(project) == products(reference)
    assert not list(project.folder.rglob(f"{UNFINISHED}*"))
    done = ptl(project, "verify", "results", "reports")
    assert done.returncode == 0, done.stdout


def test_lock_of_a_run_that_goes_on_is_spared_and_that_of_a_killed_one_is_not(tmp_path):
    project = small_project(tmp_path / "busy")
    locks = project.folder / ".snakemake/locks"
    run = start(project, "learning")
    try:
        deadline = time.monotonic() + 60
        while not list(locks.glob("*.lock")) and time.monotonic() < deadline:
            time.sleep(0.05)
        os.kill(run.pid, signal.SIGSTOP)  # so that it cannot end while we ask
        done = ptl(project, "workflow", "-j2", "learning")
        assert done.returncode == 1 and "is running in this folder" in done.stderr and str(run.pid) in done.stderr
        assert "Traceback" not in done.stderr and list(locks.glob("*.lock"))
    finally:
        os.killpg(run.pid, signal.SIGKILL)
        run.wait()
    assert list(locks.glob("*.lock"))
    finish(project, "learning")
    assert not list(locks.glob("*.lock"))


# -- damage -----------------------------------------------------------------------------------------------------


@pytest.fixture
def kept(undisturbed) -> Iterator[Project]:
    """The undisturbed run, put back after each test."""
    before = undisturbed.files("results", "reports")
    yield undisturbed
    for name, content in before.items():
        path = undisturbed.folder / name
        if not path.is_file() or path.read_bytes() != content:
            path.write_bytes(content)


def sealed_and_results(project: Project) -> list[Path]:
    """Everything that later jobs read."""
    found = checkable(project.folder / "results") + checkable(project.folder / "reports")
    assert {path.suffix for path in found} == {".h5", ".csv"} and len(found) > 10
    return found


def damages(whole: bytes, chance: random.Random) -> Iterator[tuple[str, bytes]]:
    yield "emptied", b""
    yield "cut by a byte", whole[:-1]
    for _ in range(3):
        yield "truncated", whole[: chance.randrange(len(whole))]
    for _ in range(25):
        place, bit = chance.randrange(len(whole)), chance.randrange(8)
        flipped = bytearray(whole)
        flipped[place] ^= 1 << bit
        yield f"bit {bit} of byte {place} flipped", bytes(flipped)
    start = chance.randrange(max(len(whole) - 512, 1))
    yield "a block lost", whole[:start] + bytes(len(whole[start : start + 512])) + whole[start + 512 :]


def test_every_damage_is_found(kept, monkeypatch, record_property):
    """Whatever byte it is in: no exceptions, not even unused bytes."""
    monkeypatch.chdir(kept.folder)
    chance = random.Random(SEED)
    tried = 0
    for path in sealed_and_results(kept):
        relative = path.relative_to(kept.folder)
        assert faults_of(relative) == []
        whole = path.read_bytes()
        for what, damaged in damages(whole, chance):
            if damaged == whole:
                continue
            tried += 1
            path.write_bytes(damaged)
            faults = faults_of(relative)
            assert faults, f"{relative}: {what} was not found"
            for fault in faults:
                assert fault.startswith(str(relative)) and "\n" not in fault and "snakemake" in fault, fault
        path.write_bytes(whole)
    record_property("damages tried, all found: HDF5 files and tables", tried)
    assert tried > 300


def swaps(project: Project) -> list[tuple[str, str]]:
    """Products and those of other jobs that could be mistaken for them."""
    results, reports = "results/tiny", "reports/tiny"
    learned = f"{results}/learning/rooms"
    return [
        (f"{learned}/ptl/seed_000.h5", f"{learned}/ptl/seed_001.h5"),
        (f"{learned}/ptl/seed_000.h5", f"{learned}/no_transfer/seed_000.h5"),
        (f"{learned}/ptl/seed_000.h5", f"{results}/growth/run_000.h5"),
        (f"{results}/growth/run_001.h5", f"{results}/growth/run_000.h5"),
        (f"{results}/growth/run_001.h5", f"{learned}/ptl/seed_001.h5"),
        (f"{results}/subgoal_frequencies/rooms.h5", f"{learned}/ptl/seed_001.h5"),
        (f"{results}/steps.h5", f"{learned}/ptl/seed_001.h5"),
        (f"{reports}/tables/per_seed.csv", f"{reports}/tables/subgoals.csv"),
        (f"{reports}/tables/growth.csv", f"{reports}/tables/per_seed.csv"),
    ]


def test_files_of_other_jobs_are_found(kept, monkeypatch, record_property):
    monkeypatch.chdir(kept.folder)
    record_property("files of another job in a product's place, all found", len(swaps(kept)))
    for product, other in swaps(kept):
        whole = Path(product).read_bytes()
        shutil.copy(other, product)
        faults = faults_of(Path(product))
        assert faults, f"{product} replaced by {other} was not found"
        for fault in faults:
            assert fault.startswith(product) and "snakemake" in fault and "\n" not in fault
        Path(product).write_bytes(whole)


def older_code(path: Path) -> None:
    rewrite(path, lambda file: file.attrs.modify("code", "0" * 16))


def other_settings(path: Path) -> None:
    rewrite(path, lambda file: file.attrs.modify("root_seed", 1))


def rewrite(path: Path, change: Callable[[h5py.File], None]) -> None:
    """Change a file and its checksum with it."""
    with h5py.File(path, "r+") as file:
        change(file)
    path.write_bytes(sealed(path.read_bytes()))


def cut(path: Path) -> None:
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def flip(path: Path) -> None:
    content = bytearray(path.read_bytes())
    content[-3] ^= 1
    path.write_bytes(bytes(content))


def replace(path: Path) -> None:
    """By the file of the other seed or run."""
    [other] = set(path.parent.glob("*.h5")) - {path}
    shutil.copy(other, path)


@pytest.mark.parametrize(
    ("damaged", "damage"),
    [
        ("results/tiny/learning/rooms/ptl/seed_001.h5", cut),
        ("results/tiny/learning/rooms/ptl/seed_001.h5", older_code),
        ("results/tiny/learning/rooms/ptl/seed_001.h5", other_settings),
        ("results/tiny/learning/rooms/ptl/seed_001.h5", replace),
        ("results/tiny/growth/run_000.h5", cut),
        ("results/tiny/growth/run_000.h5", replace),
        ("reports/tiny/tables/per_seed.csv", flip),
        ("reports/tiny/tables/per_seed.csv", cut),
    ],
)
def test_aggregation_refuses_damage_and_its_advice_works(kept, damaged, damage):
    """Without Snakemake in between, which would take a minute: the commands are those of the rules."""
    folder = kept.folder
    path = folder / damaged
    whole = path.read_bytes()
    damage(path)
    if damaged.endswith("seed_001.h5"):
        files = sorted(folder.glob("results/tiny/learning/rooms/*/seed_*.h5"))
        arguments = ["measure", *(file.relative_to(folder) for file in files), "--window", "10",
                     "--threshold-factor", "1.5", "--output-per-seed", "out.csv"]  # fmt: skip
    elif "growth" in damaged:
        arguments = ["collect-growth", *(f"results/tiny/growth/run_{run:03d}.h5" for run in (0, 1)),
                     "--output", "out.csv"]  # fmt: skip
    else:
        arguments = ["tables", damaged, "--output-metrics", "out.csv", "--output-folder", "out", "--window", "10",
                     "--threshold-factor", "1.5", "--confidence", "0.95", "--resamples", "100"]  # fmt: skip
    done = ptl(kept, *arguments)
    assert done.returncode == 1 and not (folder / "out.csv").exists()
    [line] = done.stderr.splitlines()
    assert line.startswith(f"error: {damaged}: "), line
    advice = re.search(r"remove it and run '(snakemake [^']*)' to make it again", line)[1]
    path.unlink()
    if damage in {cut, older_code}:  # one of each kind of file, because Snakemake takes seconds
        done = kept.snakemake(*shlex.split(advice)[1:])
        assert done.returncode == 0, done.stderr[-2000:]
        assert path.read_bytes() == whole
        assert faults_of(path) == []


def test_advice_names_the_configuration_of_the_run(tmp_path, monkeypatch):
    from ptl.remedies import rebuild_command

    (tmp_path / "config").mkdir()
    (tmp_path / "config/config.yaml").write_text("run: published\n")
    (tmp_path / "config/smoke.yaml").write_text("# small\nrun: 'smoke'\n")
    monkeypatch.chdir(tmp_path)
    assert rebuild_command("results/published/steps.h5") == "snakemake results/published/steps.h5 --cores 1"
    expected = "snakemake results/smoke/steps.h5 --cores 1 --configfile config/smoke.yaml"
    assert rebuild_command("results/smoke/steps.h5") == expected
    assert rebuild_command(tmp_path / "results/smoke/steps.h5") == expected
    assert rebuild_command("results/other/a b.h5") == "snakemake 'results/other/a b.h5' --cores 1"
    assert rebuild_command("/elsewhere/x.h5") == "snakemake /elsewhere/x.h5 --cores 1"


def test_manifest_finds_every_damage_to_a_report_folder(tmp_path, record_property):
    """Bit flips anywhere in tables, figures and the manifest itself."""
    import json

    from ptl import manifest

    chance = random.Random(SEED)
    folder = tmp_path / "reports/tiny"
    folder.mkdir(parents=True)
    names = ["a.csv", "b.png", "c.svg", "claims.csv"]
    for name in names:
        (folder / name).write_bytes(chance.randbytes(2000))
    (folder / "claims.csv").write_text("id,seconds\nE1-all,1\nselection-cost,2\n")
    built = manifest.build([folder / name for name in names], folder, {"run": "tiny"})
    text = json.dumps(built, indent=1, sort_keys=True) + "\n"
    write_text(folder / manifest.MANIFEST, text)
    reference = tmp_path / "published.json"
    write_text(reference, text)
    own = folder / manifest.MANIFEST
    assert faults_of(own) == [] and manifest.differences(folder, reference) == []
    tried = 0
    for name in [*names, manifest.MANIFEST]:
        path = folder / name
        whole = path.read_bytes()
        for what, damaged in damages(whole, chance):
            if damaged != whole and damaged.strip() != whole.strip():
                tried += 1
                path.write_bytes(damaged)
                assert faults_of(own), f"{name}: {what}"
        path.unlink()
        assert faults_of(own)
        path.write_bytes(whole)
    record_property("damages tried, all found: report folder with manifest", tried)
    # Against another run's manifest, lines with measured times do not count, and all others do.
    (folder / "claims.csv").write_text("id,seconds\nE1-all,1\nselection-cost,3\n")
    assert manifest.differences(folder, reference) == []
    (folder / "claims.csv").write_text("id,seconds\nE1-all,2\nselection-cost,2\n")
    assert len(manifest.differences(folder, reference)) == 1


def test_merging_batches_refuses_a_batch_given_twice(kept):
    common = ["--map", "rooms.txt", "--environment", "rooms", "--batches", "2", "--root-seed", "1", "--starts", "4"]
    for batch in (0, 1):
        output = f"results/tiny/subgoal_frequencies/rooms/batch_{batch}.h5"
        assert ptl(kept, "survey", "batch", *common, "--batch", str(batch), "--output", output).returncode == 0
    first, second = (f"results/tiny/subgoal_frequencies/rooms/batch_{batch}.h5" for batch in (0, 1))
    assert faults_of(kept.folder / second) == []
    done = ptl(kept, "survey", "merge", first, first, "--output", "merged.h5")
    assert done.returncode == 1 and "batches 0, 0 were given where 0 to 1 are needed" in done.stderr
    shutil.copy(kept.folder / first, kept.folder / second)
    done = ptl(kept, "survey", "merge", first, second, "--output", "merged.h5")
    assert done.returncode == 1 and done.stderr.startswith(f"error: {second}: holds the frequencies")
    assert not (kept.folder / "merged.h5").exists()
    shutil.rmtree(kept.folder / "results/tiny/subgoal_frequencies/rooms")


# -- disk -------------------------------------------------------------------------------------------------------

COMMANDS = {
    "learn": ["learn", "--map", "rooms.txt", "--environment", "rooms", "--tasks", "AB", "--method", "ptl", "--seed",
              "0", "--root-seed", "1", "--output", "{}/learned.h5"],
    "grow": ["grow", "--map", "rooms.txt", "--environment", "rooms", "--tasks", "3", "--run", "0", "--root-seed",
             "1", "--output", "{}/grown.h5"],
    "survey": ["survey", "batch", "--map", "rooms.txt", "--environment", "rooms", "--batch", "0", "--batches", "1",
               "--root-seed", "1", "--starts", "2", "--output", "{}/batch_0.h5"],
    "collect-growth": ["collect-growth", "results/tiny/growth/run_000.h5", "--output", "{}/growth.csv"],
    "figure": ["figure", "map", "rooms.txt", "--output", "{}/map.png"],
}  # fmt: skip
"""One command of each kind that writes: HDF5, text, figures."""


@pytest.mark.parametrize("limit", [0, 20])
@pytest.mark.parametrize("command", COMMANDS)
def test_full_disk_is_one_line_and_leaves_nothing(undisturbed, command, limit):
    """A limit on the size of files, which fails like a full disk and needs no special rights."""
    folder = undisturbed.folder / f"full_{command}_{limit}"
    arguments = [part.format(folder.name) for part in COMMANDS[command]]
    done = ptl(undisturbed, *arguments, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)))
    assert done.returncode == 1, done.stderr
    [line] = done.stderr.splitlines()
    assert line.startswith("error: ") and f"{folder.name}/" in line and "cannot be written" in line
    assert list(folder.rglob("*")) == []


@pytest.mark.parametrize("command", COMMANDS)
def test_unwritable_place_is_one_line(undisturbed, command):
    """A file where a folder is needed: unwritable for root as well."""
    (undisturbed.folder / "blocked").write_text("")
    done = ptl(undisturbed, *(part.format("blocked") for part in COMMANDS[command]))
    assert done.returncode == 1
    [line] = done.stderr.splitlines()
    assert line.startswith("error: ") and "cannot be written" in line


def test_disk_that_fills_up_while_writing(tmp_path):
    """At every size between nothing and the whole file, the old product stays and no other appears."""
    path = tmp_path / "product.bin"
    write_text(path, "old")
    code = (
        "import resource, sys; from ptl.files import atomic_path\n"
        "limit = int(sys.argv[2]); resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))\n"
        "with atomic_path(sys.argv[1]) as place: place.write_bytes(b'x' * 5000)\n"
    )
    for limit in (0, 1, 4096, 4999):
        done = subprocess.run([sys.executable, "-c", code, path, str(limit)], capture_output=True, text=True)
        assert "cannot be written (File too large)" in done.stderr
        assert path.read_text() == "old" and list(tmp_path.iterdir()) == [path]


def test_unfinished_files_are_not_products(tmp_path):
    from ptl.files import remove_unfinished

    (tmp_path / "results/learning").mkdir(parents=True)
    with pytest.raises(KeyboardInterrupt), atomic_path(tmp_path / "results/learning/a.h5") as temporary:
        assert temporary.name.startswith(UNFINISHED) and temporary.suffix == ".h5"
        assert checkable(tmp_path) == []
        copy = temporary.with_name(f"{UNFINISHED}left-a.h5")
        shutil.copy(temporary, copy)
        raise KeyboardInterrupt
    assert not temporary.exists() and copy.exists()
    (tmp_path / "results/kept.csv").write_text("")
    remove_unfinished(tmp_path / "results", tmp_path / "no such folder")
    assert [path.name for path in tmp_path.rglob("*") if path.is_file()] == ["kept.csv"]


# -- size -------------------------------------------------------------------------------------------------------


def test_ranges_of_numbers_stand_for_files():
    assert expand_numbers(["a/seed_[0-2].h5", "b/seed_007.h5", "c/[x].h5", "d/run_[998-1001].h5"]) == [
        Path(name) for name in (
            "a/seed_000.h5", "a/seed_001.h5", "a/seed_002.h5", "b/seed_007.h5", "c/[x].h5", "d/run_998.h5",
            "d/run_999.h5", "d/run_1000.h5", "d/run_1001.h5",
        )
    ]  # fmt: skip


def test_command_lines_do_not_grow_with_the_number_of_seeds(tmp_path):
    """Linux takes no command of more than 128 KiB, which the names of 2 000 files exceed."""
    project = small_project(tmp_path / "many")
    many = SMALL.replace("seeds: 2", "seeds: 120").replace("runs: 2", "runs: 120")
    (project.folder / "config/config.yaml").write_text(many)
    targets = ("reports/tiny/tables/per_seed.csv", "reports/tiny/tables/growth.csv",
               "reports/tiny/figures/figure04.png", "reports/tiny/figures/discovery_rooms.png")  # fmt: skip
    done = project.snakemake(*targets, "-n", "-p", "--quiet", "progress")
    assert done.returncode == 0, done.stderr[-2000:]
    commands = [line for line in (done.stdout + done.stderr).splitlines() if line.startswith("Shell command: ptl ")]
    assert len(commands) > 120 * 4
    assert max(map(len, commands)) < 2000


def test_as_many_files_as_one_wants_can_be_measured(kept):
    done = ptl(kept, "measure", "results/tiny/learning/rooms/no_transfer/seed_[0-1].h5",
               "results/tiny/learning/rooms/ptl/seed_[0-1].h5", "--window", "10", "--threshold-factor", "1.5",
               "--output-per-seed", "again.csv")  # fmt: skip
    assert done.returncode == 0, done.stderr
    again = kept.folder / "again.csv"
    assert again.read_bytes() == (kept.folder / "reports/tiny/tables/per_seed.csv").read_bytes()
