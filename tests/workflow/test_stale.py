"""Results and products of another configuration, map, code or checkout are made again or refused, even after losses."""

from __future__ import annotations

import os
import shutil
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
from projects import ROOMS, ROOT, TINY, Project, errors_of

pytestmark = pytest.mark.slow

OWN: dict[str, Any] = {
    **TINY,
    "environments": {"rooms": {"map": "rooms.txt", "tasks": "AB"}, "hall": {"map": "hall.txt", "tasks": "BA"}},
    "methods": ["no_transfer", "full_transfer", "ptl", "mine.py"],
    "foreign_results": {"theirs": {"file": "theirs.csv"}},
}
MINE = (ROOT / "examples/methods/optimistic.py").read_text()
HALL = ROOMS.replace("#I..#..A#", "#I.....A#")
LEARNED, GROWN, SURVEYED = 2 * 4 * 2, 2, 2 * 2
FASTER = {"learning": {"episodes": 20, "alpha": 0.7}}


def theirs(steps: int) -> str:
    """Results of another program, with the same number of steps in every episode."""
    rows = [
        f"rooms,theirs,{task},{seed},{episode},{steps}\n"
        for task in "AB" for seed in range(TINY["seeds"]) for episode in range(1, 21)
    ]  # fmt: skip
    return "environment,method,task,seed,episode,steps\n" + "".join(rows)


def put(path: Path, text: str) -> None:
    """Replace a file by one that is older than all that was made from it, as moving and unpacking can do."""
    other = path.with_name("other")
    other.write_text(text)
    os.utime(other, (946_684_800, 946_684_800))
    other.replace(path)


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Project:
    project = Project(tmp_path_factory.mktemp("finished"), OWN)
    for name, text in {"mine.py": MINE, "theirs.csv": theirs(50), "hall.txt": HALL}.items():
        (project.folder / name).write_text(text)
    project.make()
    return project


@pytest.fixture
def run(finished: Project, tmp_path: Path) -> Project:
    """A copy of the finished run."""
    return Project.copy_of(finished.folder, tmp_path / "copy")


def forget(run: Project) -> None:
    """Delete Snakemake's records."""
    shutil.rmtree(run.folder / ".snakemake")


def test_a_finished_run_stays_as_it_is_with_and_without_what_snakemake_remembers(run: Project) -> None:
    assert run.waiting() == {}
    forget(run)
    assert run.waiting() == {}
    done = run.ptl("verify", "results", "reports")
    assert done.returncode == 0 and "whole and consistent" in done.stdout, done.stdout


@pytest.mark.parametrize("lost", [False, True])
def test_another_alpha_is_learned_anew_and_the_first_one_found_again(run: Project, lost: bool) -> None:
    before = run.files("results/tiny/learning")
    run.configure({**OWN, **FASTER})
    if lost:
        forget(run)
    waiting = run.waiting()
    assert (waiting["learn"], waiting["grow"], waiting["survey_batch"]) == (LEARNED, GROWN, SURVEYED)
    assert run.waiting("growth").keys() == {"grow", "growth"}
    run.configure(OWN)  # planning has changed nothing for good
    assert "learn" not in run.waiting()
    assert run.files("results/tiny/learning") == before


def test_an_older_map_file_is_learned_anew(run: Project) -> None:
    put(run.folder / "rooms.txt", ROOMS.replace("#..B#", "#.B.#"))
    for _ in range(2):
        waiting = run.waiting()
        assert (waiting["learn"], waiting["survey_batch"]) == (LEARNED // 2, SURVEYED // 2)
        assert {"draw_figure", "library_cost", "measure"} <= waiting.keys()
        forget(run)


def test_exchanged_maps_are_learned_anew(run: Project) -> None:
    put(run.folder / "rooms.txt", HALL)
    put(run.folder / "hall.txt", ROOMS)
    forget(run)
    waiting = run.waiting()
    assert waiting["learn"] == LEARNED and waiting["draw_figure"] > 4


def test_a_renamed_environment_is_learned_anew_and_its_old_files_are_named(run: Project) -> None:
    rooms, hall = OWN["environments"].values()
    growth = {**TINY["growth"], "environment": "home"}
    run.configure({**OWN, "environments": {"home": rooms, "hall": hall}, "foreign_results": {}, "growth": growth})
    forget(run)
    assert run.waiting()["learn"] == LEARNED // 2
    run.make()
    done = run.ptl("verify", "results/tiny")
    assert (
        done.returncode == 0
        and f"left from another configuration, may be removed: {LEARNED // 2 + 1} files" in done.stdout
    )
    drawn = run.ptl("verify", "reports/tiny").stdout
    assert "left from another configuration" in drawn and "reports/tiny/figures/discovery_rooms" in drawn
    for product in (run.folder / "reports/tiny/tables").glob("*.csv"):
        assert "rooms" not in product.read_text(), product


def test_results_copied_from_another_checkout_are_learned_anew(run: Project, finished: Project) -> None:
    """Snakemake remembers having made these very files from the present parameters."""
    run.configure({**OWN, **FASTER})
    run.make("learning", "growth")
    for folder in ("learning", "growth"):
        shutil.rmtree(run.folder / "results/tiny" / folder)
        shutil.copytree(finished.folder / "results/tiny" / folder, run.folder / "results/tiny" / folder)
    waiting = run.waiting("learning", "growth")
    assert (waiting["learn"], waiting["grow"]) == (LEARNED, GROWN)


def test_a_file_of_another_job_in_the_place_of_a_result_is_made_anew(run: Project) -> None:
    folder = run.folder / "results/tiny/learning/rooms/ptl"
    whole = (folder / "seed_001.h5").read_bytes()
    shutil.copy(folder / "seed_000.h5", folder / "seed_001.h5")
    done = run.ptl("verify", "results/tiny")
    assert done.returncode == 1 and "seed_001.h5: was made with seed 0, not 1" in done.stdout
    assert run.waiting()["learn"] == 1
    run.make()
    assert (folder / "seed_001.h5").read_bytes() == whole


def test_a_damaged_result_is_refused_and_the_advice_mends_it(run: Project) -> None:
    path = run.folder / "results/tiny/learning/rooms/ptl/seed_001.h5"
    whole = path.read_bytes()
    path.write_bytes(whole[:-1000] + bytes(500) + whole[-500:])
    (run.folder / "reports/tiny/tables/per_seed.csv").unlink()
    [line] = errors_of(run.snakemake())[:1]
    assert "seed_001.h5: damaged" in line and "'ptl verify --remove results'" in line
    assert run.ptl("verify", "--remove", "results").returncode == 1 and not path.exists()
    run.make()
    assert path.read_bytes() == whole and run.waiting() == {}


@pytest.mark.parametrize("lost", [False, True])
def test_an_edited_table_is_made_anew(run: Project, lost: bool) -> None:
    table = run.folder / "reports/tiny/tables/per_seed.csv"
    whole = table.read_text()
    table.write_text(whole.replace("rooms,A,ptl,0,", "rooms,A,ptl,0,9"))
    done = run.ptl("verify", "reports/tiny")
    assert done.returncode == 1 and "per_seed.csv: differs from manifest.json" in done.stdout
    if lost:
        forget(run)
    assert run.waiting()["measure"] == 1
    run.make()
    assert table.read_text() == whole


def test_products_of_another_configuration_are_made_anew(run: Project, finished: Project) -> None:
    """The products of a checkout with other statistics, copied over those of this one."""
    run.configure({**OWN, "statistics": {"resamples": 150}})
    run.make()
    for folder in ("reports", "results"):
        shutil.rmtree(run.folder / folder)
        shutil.copytree(finished.folder / folder, run.folder / folder)
    waiting = run.waiting()
    assert {"tabulate", "draw_figure", "measure"} <= waiting.keys() and "learn" not in waiting


def test_another_method_of_the_same_name_is_learned(run: Project) -> None:
    put(run.folder / "mine.py", MINE.replace("np.ones", "0.5 * np.ones"))
    forget(run)
    assert run.waiting()["learn"] == LEARNED // 4


def test_older_results_of_other_programs_are_read_anew(run: Project) -> None:
    put(run.folder / "theirs.csv", theirs(500))
    forget(run)
    run.make()
    table = pd.read_csv(run.folder / "reports/tiny/tables/per_seed.csv").query("method == 'theirs'")
    assert table["total_steps"].tolist() == [500 * 20] * 4


def test_results_of_other_programs_that_change_during_the_run_are_refused(run: Project) -> None:
    changing = f"""
    def end_task(self, learner):
        if self.world.n_states > 12:  # not in the trial before the run
            from pathlib import Path
            Path("theirs.csv").write_text({theirs(60)!r})
"""
    put(run.folder / "mine.py", MINE + changing)
    [line] = errors_of(run.snakemake())[:1]
    assert line == "error: theirs.csv: was changed during the run; run the same command again"
    run.make()
    table = pd.read_csv(run.folder / "reports/tiny/tables/per_seed.csv").query("method == 'theirs'")
    assert table["total_steps"].tolist() == [60 * 20] * 4


def test_a_method_that_leaves_the_run_leaves_every_product(run: Project) -> None:
    run.configure({**OWN, "methods": ["no_transfer", "ptl", "mine.py"]})
    forget(run)
    assert "learn" not in run.waiting()
    run.make()
    for product in (run.folder / "reports/tiny").rglob("*.csv"):
        assert "full_transfer" not in product.read_text(), product
