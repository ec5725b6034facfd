"""The workflow as a whole, run by Snakemake on a copy of the project."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import h5py
import pandas as pd
import pytest

ROOT = Path(__file__).resolve().parent.parent

TINY = """
run: tiny
seeds: 2
environments:
  rooms: {map: rooms.txt, title: Two rooms, tasks: AB}
methods: [no_transfer, policy_reuse, ptl]
learning: {episodes: 20}
statistics: {resamples: 100}
growth: {environment: rooms, tasks: 4, runs: 2, breakpoint: 2}
subgoal_frequencies: {trajectories: 3, starts: 2, batches: 1}
"""

ROOMS = "#########\n#I..#..A#\n#.......#\n#...#..B#\n#########\n"


class Project:
    """A copy of the project in which snakemake runs."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        folder.mkdir(exist_ok=True)
        for name in ("Snakefile", "config", "workflow", "profiles", "ptl"):
            source = ROOT / name
            if source.is_dir():
                shutil.copytree(source, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
            else:
                shutil.copy(source, folder / name)
        (folder / "rooms.txt").write_text(ROOMS)
        # Dictionaries of a second configuration are merged into the first, so the tiny one has to replace it.
        (folder / "tiny.yaml").write_text(TINY)

    def snakemake(self, *arguments: str, config: str | None = None, cores: int = 2) -> subprocess.CompletedProcess:
        if config == "tiny":
            shutil.copy(self.folder / "tiny.yaml", self.folder / "config/config.yaml")
            config = None
        chosen = ["--configfile", config] if config else []
        environment = dict(os.environ, PYTHONPATH=str(self.folder))
        return subprocess.run(
            [sys.executable, "-m", "snakemake", f"-j{cores}", *chosen, *arguments],
            cwd=self.folder, env=environment, capture_output=True, text=True, timeout=500,
        )  # fmt: skip

    def rules_that_would_run(self, *arguments: str) -> dict[str, int]:
        done = self.snakemake("-n", "--quiet", "reason", *arguments)
        assert done.returncode == 0, done.stderr
        table = re.findall(r"^(\w+) +(\d+)$", done.stdout + done.stderr, flags=re.M)
        return {name: int(count) for name, count in table if name != "total"}

    def files(self, *folders: str) -> dict[str, bytes]:
        return {
            str(path.relative_to(self.folder)): path.read_bytes()
            for folder in folders
            for path in sorted((self.folder / folder).rglob("*"))
            if path.is_file()
        }


@pytest.fixture(scope="module")
def smoke(tmp_path_factory) -> Project:
    project = Project(tmp_path_factory.mktemp("smoke"))
    done = project.snakemake(config="config/smoke.yaml")
    assert done.returncode == 0, done.stderr[-5000:]
    return project


@pytest.fixture(scope="module")
def tiny(tmp_path_factory) -> Project:
    project = Project(tmp_path_factory.mktemp("tiny"))
    done = project.snakemake(config="tiny")
    assert done.returncode == 0, done.stderr[-5000:]
    return project


SMOKE_METHODS = ["full_transfer", "no_transfer", "policy_reuse", "ptl", "ptl_supervised", "ptl_unknown_goal"]


def test_smoke_makes_every_product(smoke):
    for environment in ("env1", "env2", "env3"):
        for method in SMOKE_METHODS:
            for seed in range(2):
                path = smoke.folder / f"results/smoke/learning/{environment}/{method}/seed_{seed:03d}.h5"
                with h5py.File(path) as file:
                    assert list(file["tasks"]) == list("ABCDEF")
        with h5py.File(smoke.folder / f"results/smoke/subgoal_frequencies/{environment}.h5") as file:
            assert file["counts"][()].sum() + file["unresolved"][()] == file["pairs"][()] > 0
    assert len(list((smoke.folder / "results/smoke/growth").glob("run_*.h5"))) == 2
    reports = smoke.folder / "reports/smoke"
    for number in range(1, 7):
        for suffix in ("html", "md", "tex", "csv"):
            assert (reports / f"tables/table{number}.{suffix}").stat().st_size > 200
    for name in [f"figure{number:02d}" for number in range(3, 15)] + ["library_cost"]:
        assert (reports / f"figures/{name}.png").read_bytes().startswith(b"\x89PNG")
        assert "</svg>" in (reports / f"figures/{name}.svg").read_text()
        assert len(pd.read_csv(reports / f"figures/{name}.csv")) > 0
    per_seed = pd.read_csv(reports / "tables/per_seed.csv")
    assert len(per_seed) == 3 * 6 * 6 * 2
    assert set(per_seed.columns) >= {
        "environment", "task", "method", "seed", "first_episode", "asymptotic", "threshold_episode", "total_steps",
        "jump_start", "transfer_ratio",
    }  # fmt: skip
    base = per_seed[per_seed.method == "no_transfer"]
    assert (base.jump_start == 0).all() and (base.transfer_ratio == 0).all()
    claims = pd.read_csv(reports / "claims.csv")
    assert set(claims.columns) >= {"id", "claim", "verdict", "evidence"} and len(claims) == 24


def test_per_seed_measures_are_those_of_the_files(smoke):
    per_seed = pd.read_csv(smoke.folder / "reports/smoke/tables/per_seed.csv").set_index(
        ["environment", "method", "task", "seed"]
    )
    learning = smoke.folder / "results/smoke/learning"
    for place in [("env2", "ptl", "C", 1), ("env3", "policy_reuse", "F", 0), ("env1", "full_transfer", "B", 1)]:
        environment, method, task, seed = place
        with h5py.File(learning / environment / method / f"seed_{seed:03d}.h5") as file:
            steps = file[f"tasks/{task}/steps"][()]
        with h5py.File(learning / environment / f"no_transfer/seed_{seed:03d}.h5") as file:
            base = file[f"tasks/{task}/steps"][()]
        row = per_seed.loc[place]
        assert row.first_episode == steps[0]
        assert row.asymptotic == pytest.approx(steps[-10:].mean(), rel=1e-5)
        assert row.total_steps == steps.sum()
        assert row.jump_start == base[0] - steps[0]
        assert row.transfer_ratio == pytest.approx((base.sum() - steps.sum()) / base.sum(), rel=1e-5)


def test_second_run_has_nothing_to_do(smoke):
    done = smoke.snakemake(config="config/smoke.yaml")
    assert done.returncode == 0 and "Nothing to be done" in done.stderr


def test_report_holds_the_products(smoke):
    done = smoke.snakemake("--report", "reports/smoke/report.html", config="config/smoke.yaml")
    assert done.returncode == 0, done.stderr[-3000:]
    assert "WARNING" not in done.stderr and "rror in" not in done.stderr, done.stderr[-3000:]
    page = (smoke.folder / "reports/smoke/report.html").read_text()
    for item in ("figure12.png", "table1.html", "claims.html"):
        assert item in page


@pytest.mark.parametrize(
    ("edited", "reruns", "spares"),
    [
        ("ptl/figures/maps.py", {"draw_map"}, {"learn", "grow", "survey_batch", "measure", "draw_growth"}),
        ("ptl/tables.py", {"tabulate"}, {"learn", "grow", "survey_batch", "draw_map"}),
        ("ptl/methods/policy_reuse.py", {"learn"}, {"grow", "survey_batch", "draw_map"}),
        ("ptl/subgoals.py", {"learn", "grow"}, {"draw_map", "draw_prior", "library_cost"}),
    ],
)
def test_an_edit_reruns_what_hangs_on_it_and_nothing_else(tiny, edited, reruns, spares):
    path = tiny.folder / edited
    original = path.read_text()
    try:
        path.write_text(original + "\n# edited\n")
        would_run = tiny.rules_that_would_run()
    finally:
        path.write_text(original)
    assert reruns <= set(would_run) and not spares & set(would_run), would_run
    if edited == "ptl/methods/policy_reuse.py":
        assert would_run["learn"] == 2  # two seeds of that method
    assert tiny.rules_that_would_run() == {}


def test_editing_the_kernel_demands_a_build(tiny):
    path = tiny.folder / "ptl/_kernel.pyx"
    original = path.read_text()
    try:
        path.write_text(original + "\n# edited\n")
        done = tiny.snakemake("-n")
    finally:
        path.write_text(original)
    assert done.returncode != 0
    assert "ptl._kernel was built from other sources" in done.stderr and "Traceback" not in done.stderr


def test_one_core_gives_the_same_bytes_as_two(tiny, tmp_path):
    other = Project(tmp_path / "other")
    done = other.snakemake(config="tiny", cores=1)
    assert done.returncode == 0, done.stderr[-3000:]
    first, second = tiny.files("results", "reports"), other.files("results", "reports")
    assert set(first) == set(second)
    timed = {"selection_cost.csv", "library_cost", "claims", "manifest"}
    for name in first:
        if not any(part in name for part in timed):
            assert first[name] == second[name], name


def test_damaged_file_is_named_and_the_advised_command_mends_it(tiny):
    path = tiny.folder / "results/tiny/learning/rooms/ptl/seed_001.h5"
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    (tiny.folder / "reports/tiny/tables/per_seed.csv").unlink()
    done = tiny.snakemake("reports/tiny/tables/per_seed.csv")
    assert done.returncode != 0
    [line] = [line for line in (done.stderr + done.stdout).splitlines() if line.strip().startswith("error:")][:1]
    assert "results/tiny/learning/rooms/ptl/seed_001.h5: damaged" in line and "snakemake" in line
    assert "Traceback" not in done.stderr + done.stdout
    path.unlink()
    assert tiny.snakemake("results/tiny/learning/rooms/ptl/seed_001.h5").returncode == 0
    assert path.read_bytes() == whole
    assert tiny.snakemake().returncode == 0


@pytest.mark.parametrize(
    ("override", "says"),
    [
        ("seeds=0", "configuration key seeds: 0 is not allowed; give at least 1"),
        ("methods=[ptl,sarsa]", "unknown method 'sarsa'"),
        ("learnin={}", "unknown key 'learnin'"),
        ("learning={alpha: -1}", "configuration key learning.alpha: '-1' is not allowed; give a value of type number"),
    ],
)
def test_bad_configuration_ends_in_one_line(tiny, override, says):
    before = tiny.files("results")
    done = tiny.snakemake("--config", override)
    assert done.returncode != 0
    errors = [line for line in done.stderr.splitlines() if line.startswith("error:")]
    assert len(errors) == 1 and says in errors[0]
    assert "Traceback" not in done.stderr
    assert tiny.files("results") == before


def test_bad_map_ends_in_one_line(tiny):
    path = tiny.folder / "rooms.txt"
    path.write_text(ROOMS.replace("I", "."))
    try:
        done = tiny.snakemake()
    finally:
        path.write_text(ROOMS)
    assert done.returncode != 0
    assert "error: rooms.txt: no start; put the letter 'I' on a free cell" in done.stderr
    assert "Traceback" not in done.stderr


def test_commands_end_in_one_line_on_bad_input(tmp_path):
    def ptl(*arguments: str) -> subprocess.CompletedProcess:
        return subprocess.run([sys.executable, "-m", "ptl", *arguments], capture_output=True, text=True, cwd=tmp_path)

    (tmp_path / "ragged.txt").write_text("I..\nA\n")
    for arguments, says in [
        (("show-map", "ragged.txt"), "error: ragged.txt: row 2 has 1 cells but row 1 has 3"),
        (("inspect", "none.h5"), "error: none.h5: no such file"),
        (("verify", "ragged.txt"), "ragged.txt: has no checksum to hold it against"),
        (("show-map", str(ROOT / "none.txt")), "cannot be read"),
    ]:
        done = ptl(*arguments)
        assert done.returncode == 1, arguments
        assert says in done.stdout + done.stderr and "Traceback" not in done.stderr
    assert ptl("show-map", str(ROOT / "config/environments/env1.txt")).returncode == 0
    for command in ("learn", "inspect", "verify", "show-map"):
        assert ptl(command, "--help").returncode == 0


def test_make_targets_go_on_after_a_kill(tiny):
    """A lock left behind is taken away; tests/test_faults.py has one that is not."""
    locks = tiny.folder / ".snakemake/locks"
    locks.mkdir(parents=True, exist_ok=True)
    (locks / "0.input.lock").write_text("rooms.txt\n")
    (locks / "0.output.lock").write_text("results/tiny/learning/rooms/ptl/seed_000.h5\n")
    environment = dict(os.environ, PYTHONPATH=str(tiny.folder))
    run = [sys.executable, "-m", "ptl", "workflow", "-j2"]
    path = tiny.folder / "results/tiny/learning/rooms/ptl/seed_000.h5"
    whole = path.read_bytes()
    path.unlink()
    assert "locked" in tiny.snakemake(str(path.relative_to(tiny.folder))).stderr
    done = subprocess.run(run, cwd=tiny.folder, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-3000:]
    assert path.read_bytes() == whole
