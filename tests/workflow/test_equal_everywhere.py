"""The same bytes wherever and however a job runs: hash seed, locale, time zone, folder, order, Python, wheel."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from projects import ROOT, TARGETS, Project

from ptl.config import Parameters
from ptl.files import store
from ptl.files.job import Job
from ptl.jobs.grow import Grow
from ptl.jobs.learn import Learn
from ptl.jobs.lives import Libraries, Lives
from ptl.jobs.survey import Survey
from ptl.world.gridworld import map_digest
from ptl.world.map_files import load_map

MAP = "config/environments/env2.txt"
WORLD = load_map(ROOT / MAP)
COMMON = {"root_seed": 11, "code": "0" * 16, "environment": "env2", "maps": {"env2": map_digest(WORLD.text)}}
GROUPS = Parameters().replace(learning__episodes=15, subgoals__trajectories=5).to_dict()


def made(kind: type[Job], **values: object) -> Job:
    return kind(parameters={name: GROUPS[name] for name in kind.READS}, **COMMON, **values)


JOBS = {
    "learned.h5": made(Learn, tasks="ABCDEF", method="ptl", reference="ptl", seed=7),
    "grown.h5": made(Grow, tasks=4, seed=3),
    "surveyed.h5": made(Survey, batch=0, batches=4, starts=4, trajectories=3),
    "lives.h5": made(Lives, name="env2_ptl", tasks="AB", method="ptl", look=1, first=0, seeds=2),
    "libraries.h5": made(Libraries, tasks=3, look=1, first=0, runs=2),
}
"""A job of each kind by its output file."""

SCRIPT = """
from ptl.files.csv import write_csv
from ptl.files.store import read
from ptl.measures.run_files import library_sizes, measure_files, write_steps
from ptl.report.figures import saving, style

found = measure_files([read("learned.h5")], 5, 1.5)
write_csv(found.per_seed, "per_seed.csv")
write_csv(found.subgoals, "subgoals.csv")
write_steps("steps.h5", found.steps)
sizes = library_sizes([read("grown.h5")])
write_csv(sizes, "growth.csv")

@style.styled
def draw():
    figure = style.new_figure(style.SLIDE_WIDTH, 8)
    figure.subplots().plot(sizes["tasks"], sizes["library_size"])
    return figure

saving.save(draw(), sizes, "figure.png")
"""
"""Measuring, collecting and drawing, as the scripts of the workflow do it."""

FILES = (*JOBS, "per_seed.csv", "subgoals.csv", "steps.h5", "growth.csv", "figure.png", "figure.svg", "figure.csv")


def run_jobs(folder: Path, python: str | Path = sys.executable, path: str = str(ROOT), **environment: str) -> dict:
    """Bytes of the files of all jobs in their own folder."""
    (folder / "config/environments").mkdir(parents=True)
    shutil.copy(ROOT / MAP, folder / MAP)
    variables = {"PATH": os.environ["PATH"], "HOME": str(folder), "PYTHONPATH": path, "MPLBACKEND": "Agg"} | environment
    given = ("-m", "ptl", "run", "--map", f"env2={MAP}")
    for arguments in (*((*given, "--job", job.text, "--output", name) for name, job in JOBS.items()), ("-c", SCRIPT)):
        done = subprocess.run([python, *arguments], cwd=folder, env=variables, capture_output=True, text=True)
        assert done.returncode == 0, (arguments, done.stderr[-2000:])
    return {name: (folder / name).read_bytes() for name in FILES}


@pytest.fixture(scope="module")
def reference(tmp_path_factory) -> dict:
    return run_jobs(tmp_path_factory.mktemp("reference") / "plain", PYTHONHASHSEED="0", LC_ALL="C.UTF-8", TZ="UTC")


@pytest.mark.parametrize(
    ("folder", "environment"),
    [
        ("hash", {"PYTHONHASHSEED": "12345", "LC_ALL": "C", "TZ": "Pacific/Chatham"}),
        ("a b/ü 'c'", {"PYTHONHASHSEED": "random", "LC_ALL": "de_DE.UTF-8", "LANG": "tr_TR.UTF-8", "TZ": "Asia/Aden"}),
    ],
    ids=["hash seed, C locale, time zone", "folder with spaces, German locale, another time zone"],
)
def test_surroundings_do_not_show(reference, tmp_path, folder, environment, record_property):
    found = run_jobs(tmp_path / folder, **environment)
    record_property("surroundings compared", 1)
    assert [name for name in FILES if found[name] != reference[name]] == []


def test_nothing_in_a_file_tells_where_or_when_it_was_made(reference, tmp_path):
    host = os.uname().nodename.encode()
    for name, content in reference.items():
        assert str(ROOT).encode() not in content and b"plain" not in content, name
        assert len(host) < 4 or host not in content, name


@pytest.mark.slow
def test_whole_runs_are_equal_from_another_folder_in_another_order_and_resumed(tmp_path):
    """One core in the top folder against two cores in another folder, in stages, in another environment."""
    plain, other = Project(tmp_path / "plain"), Project(tmp_path / "other")
    plain.make(*TARGETS, cores=1)
    surroundings = {"PYTHONHASHSEED": "77", "LC_ALL": "C", "TZ": "America/St_Johns"}
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    for targets in (TARGETS[::-1][:1], ("results/tiny/learning/rooms/ptl/seed_001.h5",), TARGETS[::-1]):
        done = subprocess.run(
            [sys.executable, "-m", "snakemake", *targets, "-j2", "--snakefile", str(other.folder / "Snakefile"),
             "--directory", str(other.folder)],
            cwd=elsewhere, env=other.environment | surroundings, capture_output=True, text=True,
        )  # fmt: skip
        assert done.returncode == 0, done.stderr[-2000:]
    assert plain.files("results", "reports") == other.files("results", "reports")
    assert list(elsewhere.iterdir()) == []


def build_wheel(python: str | Path, folder: Path) -> Path:
    """Build the wheel from a copy of the sources, with the packages of this environment."""
    source = folder / "source"
    ignored = shutil.ignore_patterns("__pycache__", "*.so", "_*.c", "*.egg-info")
    for name in ("ptl", "workflow", "profiles", "config"):
        shutil.copytree(ROOT / name, source / name, ignore=ignored)
    for name in ("pyproject.toml", "setup.py", "MANIFEST.in", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, source / name)
    done = subprocess.run(
        [python, "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation", "-w", folder / "wheels", source],
        capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-3000:]
    [wheel] = (folder / "wheels").glob("ptl_skill_library-*.whl")
    return wheel


@pytest.mark.slow
def test_an_installed_wheel_gives_the_bytes_of_the_checkout(reference, tmp_path):
    """The wheel in its own folder; the packages it needs are those of this environment."""
    wheel = build_wheel(sys.executable, tmp_path)
    installed = tmp_path / "installed"
    subprocess.run(
        [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--target", installed, wheel], check=True
    )
    # -m puts the working folder first, then this path, then what is installed: it must not be the checkout.
    place = subprocess.run(
        [sys.executable, "-c", "import ptl; print(ptl.__file__)"],
        cwd=tmp_path, env=os.environ | {"PYTHONPATH": str(installed)}, capture_output=True, text=True, check=True,
    ).stdout  # fmt: skip
    assert place.startswith(str(installed))
    found = run_jobs(tmp_path / "run", path=str(installed))
    assert [name for name in FILES if found[name] != reference[name]] == []


def newer_pythons() -> list[str]:
    """Interpreters of this machine that are newer than this one, newest first."""
    folders = [Path(folder) for folder in os.environ["PATH"].split(os.pathsep)]
    folders += sorted(Path("~/.pyenv/versions").expanduser().glob("*/bin"))
    found: dict[tuple[int, int], str] = {}
    for minor in range(sys.version_info.minor + 1, 30):
        for folder in folders:
            python = folder / f"python3.{minor}"
            if python.is_file() and subprocess.run([python, "--version"], capture_output=True).returncode == 0:
                found.setdefault((3, minor), str(python))
    return [found[version] for version in sorted(found, reverse=True)]


@pytest.mark.slow
@pytest.mark.exhaustive
def test_the_newest_python_gives_the_same_results(reference, tmp_path, record_property):
    """Everything locked for running, installed anew under the newest Python; every byte but the recorded versions."""
    pythons = newer_pythons()
    if not pythons:
        record_property("Python versions compared", "none: no newer Python on this machine")
        pytest.skip(f"no Python newer than {sys.version.split()[0]} on this machine: nothing was compared")
    python = tmp_path / "venv/bin/python"
    subprocess.run([pythons[0], "-m", "venv", tmp_path / "venv"], check=True)
    done = subprocess.run(
        [python, "-m", "pip", "install", "--quiet", "--require-hashes", "-r", ROOT / "requirements.lock"],
        capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-3000:]
    wheel = build_wheel(python, tmp_path)
    subprocess.run([python, "-m", "pip", "install", "--quiet", "--no-deps", wheel], check=True)
    found = run_jobs(tmp_path / "run", python=python, path="")
    different = [name for name in FILES if found[name] != reference[name]]
    print(f"compared {sys.version.split()[0]} with {pythons[0]}: {len(FILES)} files, different: {different or 'none'}")
    record_property("Python versions compared", f"{sys.version.split()[0]} and {Path(pythons[0]).name}")
    assert different == []
    assert store.read(tmp_path / "run/learned.h5", JOBS["learned.h5"]).job.method == "ptl"
