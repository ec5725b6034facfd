"""The workflow as a whole, run by Snakemake on a copy of the checkout."""

from __future__ import annotations

import json
import os
import re

import h5py
import pandas as pd
import pytest
from projects import MAPS, ROOMS, ROOT, Project, errors_of

from ptl import methods
from ptl.measures.exact import first_episode_without_transfer
from ptl.world.map_files import load_map

# -- the smoke run ----------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def smoke(tmp_path_factory) -> Project:
    project = Project(tmp_path_factory.mktemp("smoke"), None)
    project.make("--configfile", "config/smoke.yaml")
    return project


@pytest.mark.slow
def test_smoke_makes_every_product(smoke):
    results, reports = smoke.folder / "results/smoke", smoke.folder / "reports/smoke"
    for environment in ("env1", "env2", "env3"):
        for method in methods.names():
            for seed in range(2):
                with h5py.File(results / f"learning/{environment}/{method}/seed_{seed:03d}.h5") as file:
                    assert {*file["tasks"]} == {*"ABCDEF"}
        with h5py.File(results / f"subgoal_frequencies/{environment}.h5") as file:
            assert file["counts"][()].sum() + file["unresolved"][()] == file["pairs"][()] > 0
    assert len(list((results / "growth").glob("run_*.h5"))) == 2
    for number in range(1, 7):
        for suffix in ("html", "md", "tex", "csv"):
            assert (reports / f"tables/table{number}.{suffix}").stat().st_size > 200
    for name in [f"figure{number:02d}" for number in range(3, 15)] + ["library_cost"]:
        assert (reports / f"figures/{name}.png").read_bytes().startswith(b"\x89PNG")
        assert "</svg>" in (reports / f"figures/{name}.svg").read_text()
        assert len(pd.read_csv(reports / f"figures/{name}.csv")) > 0


@pytest.mark.slow
def test_per_seed_measures_are_those_of_the_files(smoke):
    per_seed = pd.read_csv(smoke.folder / "reports/smoke/tables/per_seed.csv")
    assert len(per_seed) == 3 * 6 * 6 * 2
    assert (per_seed.loc[per_seed.method == "no_transfer", ["jump_start", "transfer_ratio"]] == 0).all(axis=None)
    per_seed = per_seed.set_index(["environment", "method", "task", "seed"])
    learning = smoke.folder / "results/smoke/learning"
    for place in [("env2", "ptl", "C", 1), ("env3", "policy_reuse", "F", 0), ("env1", "full_transfer", "B", 1)]:
        environment, method, task, seed = place
        with h5py.File(learning / environment / method / f"seed_{seed:03d}.h5") as file:
            steps = file[f"tasks/{task}/steps"][()]
        with h5py.File(learning / environment / f"no_transfer/seed_{seed:03d}.h5") as file:
            base = file[f"tasks/{task}/steps"][()]
        world = load_map(ROOT / f"config/environments/{environment}.txt")
        expected = first_episode_without_transfer(world, world.goal(task))
        row = per_seed.loc[place]
        assert row.first_episode == steps[0]
        assert row.asymptotic == pytest.approx(steps[-10:].mean(), rel=1e-5)
        assert row.total_steps == steps.sum()
        assert row.jump_start == pytest.approx(expected - steps[0], rel=1e-5)
        assert row.transfer_ratio == pytest.approx((base.sum() - steps.sum()) / base.sum(), rel=1e-5)


# -- a tiny run -------------------------------------------------------------------------------------------------


def test_second_run_has_nothing_to_do(tiny):
    assert "Nothing to be done" in tiny.make()


def test_every_link_of_the_page_leads_to_a_product(tiny):
    reports = tiny.folder / "reports/tiny"
    page = (reports / "index.html").read_text(encoding="utf-8")
    targets = set(re.findall(r'(?:href|src)="([^"#:]+)(?:#[^"]*)?"', page))
    assert len(targets) > 30 and "explorer.html" in targets
    assert not [target for target in targets if not (reports / target).is_file()]
    products = json.loads((reports / "manifest.json").read_text())["products"]
    assert targets <= set(products) and "index.html" in products


def test_report_holds_the_products(tiny, tmp_path):
    printed = tiny.make("--report", str(tmp_path / "report.html"))
    assert "WARNING" not in printed and "rror in" not in printed, printed[-3000:]
    page = (tmp_path / "report.html").read_text()
    for item in ("figure12.png", "table1.html", "claims.html"):
        assert item in page


@pytest.mark.parametrize(
    ("edited", "reruns", "spares"),
    [
        ("ptl/errors.py", {"measure": 1}, {"learn", "grow", "survey_batch", "decide"}),
        ("ptl/report/figures/maps.py", {"draw_figure": 1}, {"learn", "grow", "survey_batch", "measure"}),
        ("ptl/methods/policy_reuse.py", {"learn": 2}, {"grow", "survey_batch"}),
        ("ptl/agent/subgoals.py", {"learn": 8, "grow": 2}, {"library_cost"}),
    ],
)
def test_an_edit_reruns_what_depends_on_it_and_nothing_else(tiny, edited, reruns, spares):
    path = tiny.folder / edited
    original = path.read_text()
    try:
        path.write_text(original + "\n# edited\n")
        waiting = tiny.waiting()
    finally:
        path.write_text(original)
    assert reruns.items() <= waiting.items() and not spares & set(waiting), waiting


def test_editing_the_kernel_demands_a_build(tiny):
    path = tiny.folder / "ptl/agent/_kernel.pyx"
    original = path.read_text()
    try:
        path.write_text(original + "\n# edited\n")
        [line] = errors_of(tiny.snakemake("-n"))
    finally:
        path.write_text(original)
    assert "ptl.agent._kernel was built from other sources" in line


@pytest.mark.slow
@pytest.mark.exhaustive
def test_one_core_gives_the_same_bytes_as_two(tiny, tmp_path):
    other = Project(tmp_path)
    other.make(cores=1)
    assert other.files("results", "reports") == tiny.files("results", "reports")


def test_bad_configuration_ends_in_one_line(tiny):
    before = tiny.files("results")
    [line] = errors_of(tiny.snakemake("--config", "seeds=0"))
    assert "configuration key seeds: 0 is not allowed; give a whole number >= 1" in line
    assert tiny.files("results") == before


def test_bad_map_ends_in_one_line(tiny):
    path = tiny.folder / "rooms.txt"
    path.write_text(ROOMS.replace("I", "."))
    try:
        [line] = errors_of(tiny.snakemake())
    finally:
        path.write_text(ROOMS)
    assert line == "error: rooms.txt: no start; put the letter 'I' on a free cell"


def test_a_lock_that_snakemake_left_behind_is_not_in_the_way(tiny):
    locks = tiny.folder / ".snakemake/locks"
    locks.mkdir(parents=True, exist_ok=True)
    path = tiny.folder / "results/tiny/learning/rooms/ptl/seed_000.h5"
    name = path.relative_to(tiny.folder)
    (locks / "0.input.lock").write_text("rooms.txt\n")
    (locks / "0.output.lock").write_text(f"{name}\n")
    whole = path.read_bytes()
    path.unlink()
    tiny.make(name)
    assert path.read_bytes() == whole


def test_a_pipe_in_the_place_of_a_log_is_refused(tiny):
    path = tiny.folder / "logs/tiny/odd/pipe.log"
    path.parent.mkdir(exist_ok=True)
    os.mkfifo(path)
    try:
        [line] = errors_of(tiny.snakemake("-n", timeout=120))
        assert "logs/tiny/odd/pipe.log: is a pipe, and no file is written in its place" in line
    finally:
        path.unlink()


def test_a_command_prints_or_ends_in_one_line(tiny):
    assert "#" in tiny.ptl("show-map", MAPS / "env1.txt").stdout
    [line] = errors_of(tiny.ptl("inspect", "none.h5"))
    assert line.startswith("error: none.h5: no such file")
