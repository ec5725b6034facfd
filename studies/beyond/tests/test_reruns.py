"""The workflow of the second study uses files only if they were made by the expected jobs, whatever was lost."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
import yaml
from projects import ROOT, Project, errors_of

pytestmark = pytest.mark.slow

WORKFLOW = ("--snakefile", "studies/beyond/Snakefile")
MINE = (ROOT / "examples/methods/optimistic.py").read_text()
ARENA = "type octile\nheight 4\nwidth 5\nmap\n.....\n.@.@.\n.....\n.....\n"
SMALL: dict[str, Any] = {
    "run": "small", "families": ["rooms"], "maps": 2, "seeds": 2, "methods": ["no_transfer", "ptl", "mine.py"],
    "article_maps": {"env1": {"map": "rooms.txt", "tasks": "AB"}}, "article_seeds": 2, "moving_ai": ["arena.map"],
    "learning": {"episodes": 10}, "explorer": {"methods": ["ptl"]}, "statistics": {"resamples": 100},
}  # fmt: skip
ALL = {"collect_lives": 1, "report_beyond": 1, "manifest": 1, "beyond": 1}


class Side:
    """The second study in a copy of the checkout."""

    def __init__(self, folder: Path) -> None:
        self.project = Project(folder, None)
        self.folder = folder
        ignored = shutil.ignore_patterns("__pycache__", "tests")
        shutil.copytree(ROOT / "studies/beyond", folder / "studies/beyond", ignore=ignored)
        shutil.copy(ROOT / "studies/__init__.py", folder / "studies")
        (folder / "mine.py").write_text(MINE)
        (folder / "arena.map").write_text(ARENA)
        self.configure()

    def configure(self, **changes: Any) -> None:
        (self.folder / "small.yaml").write_text(yaml.safe_dump({**SMALL, **changes}))

    def waiting(self, *arguments: str) -> dict[str, int]:
        return self.project.waiting(*WORKFLOW, *arguments, "--configfile", "small.yaml")

    def make(self, *arguments: str) -> None:
        self.project.make(*WORKFLOW, *arguments, "--configfile", "small.yaml")

    def made(self) -> dict[str, bytes]:
        return self.project.files("results/small/lives", "reports/small")

    def forget(self) -> None:
        """Delete Snakemake's records."""
        shutil.rmtree(self.folder / ".snakemake")

    def put(self, name: str, text: str) -> None:
        """Replace a file by one that is older than all that was made from it, as moving and unpacking can do."""
        other = self.folder / "other"
        other.write_text(text)
        os.utime(other, (946_684_800, 946_684_800))
        other.replace(self.folder / name)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Side:
    side = Side(tmp_path_factory.mktemp("beyond") / "copy")
    side.make()
    return side


@pytest.fixture
def side(whole: Side) -> Iterator[Side]:
    """The finished study; its inputs are put back afterwards and what they made is made again when it is needed."""
    saved = shutil.copytree(whole.folder, whole.folder.with_name("saved"), symlinks=True)
    yield whole
    shutil.rmtree(whole.folder)
    saved.rename(whole.folder)


def test_a_finished_study_stays_as_it_is_and_is_whole(side):
    assert side.waiting() == {}
    done = side.project.ptl("verify", "results/small", "reports/small")
    assert "files are whole and consistent" in done.stdout, done.stdout + done.stderr
    lives = pd.read_csv(side.folder / "reports/small/per_life.csv")
    assert lives.groupby("family").size().to_dict() == {"env1": 6, "moving_ai": 6, "rooms": 12}
    inspected = side.project.ptl("inspect", "results/small/lives/rooms_300_increasing/ptl/4000.h5")
    assert inspected.returncode == 0 and "rooms" in inspected.stdout


def test_another_configuration_remakes_everything_though_the_state_is_lost(side):
    before = side.made()
    side.configure(learning={"episodes": 10, "alpha": 0.7})
    side.forget()
    assert side.waiting() == {"learn_lives": 9, "learn": 1, "explore_lives": 1, **ALL}
    side.make()
    same = {name for name, content in side.made().items() if content == before[name]}
    assert not {name for name in same if name.endswith(".h5")} | same & {
        f"reports/small/{name}" for name in ("per_life.csv", "costs.csv", "explorer.html", "manifest.json")
    }


def test_products_of_another_configuration_are_remade_though_the_state_is_lost(side):
    side.configure(statistics={"resamples": 200})
    side.forget()
    assert side.waiting() == {"explore_lives": 1, **ALL}


def test_lives_copied_from_another_study_are_learned_again(side):
    folder = side.folder / "results/small/lives/rooms_300_increasing"
    shutil.copyfile(folder / "ptl/4000.h5", folder / "no_transfer/4000.h5")
    assert side.waiting()["learn_lives"] == 1
    side.make()
    assert side.waiting() == {}


def test_damaged_lives_are_named(side):
    path = side.folder / "results/small/lives/rooms_300_increasing/ptl/4000.h5"
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    done = side.project.snakemake(*WORKFLOW, "--configfile", "small.yaml", "--forcerun", "collect_lives")
    printed = done.stdout + done.stderr + (side.folder / "logs/small/collect_lives.log").read_text()
    assert done.returncode != 0 and "ptl/4000.h5: damaged" in printed


def test_maps_replaced_by_older_files_are_learned_anew(side):
    rooms = side.folder / "rooms.txt"
    side.put("rooms.txt", rooms.read_text().replace("#..B#", "#.B.#"))
    assert side.waiting()["learn_lives"] == 3
    side.put("arena.map", ARENA.replace("@.@", "@@@"))
    assert side.waiting() == {"learn_lives": 6, "write_map": 1, "explore_lives": 1, **ALL}
    side.make()
    assert side.waiting() == {}


def test_lives_by_an_edited_method_are_learned_anew(side):
    side.put("mine.py", MINE.replace("np.ones", "0.5 * np.ones"))
    side.forget()
    assert side.waiting()["learn_lives"] == 3


def test_words_do_not_relearn(side):
    for path in ("studies/beyond/page.py", "studies/beyond/jobs.py", "studies/beyond/planned.py", "ptl/errors.py"):
        with (side.folder / path).open("a") as file:
            file.write('\n"""Another sentence."""\n')
    assert not {"learn_lives", "learn"} & set(side.waiting())
    with (side.folder / "studies/beyond/maps.py").open("a") as file:
        file.write('\n"""Another sentence."""\n')
    assert side.waiting()["learn_lives"] == 9


def test_a_deleted_product_is_made_again(side):
    product = side.folder / "reports/small/costs.csv"
    whole = product.read_bytes()
    product.unlink()
    side.make()
    assert product.read_bytes() == whole


def test_older_lives_of_other_programs_are_read_anew(side):
    table = pd.read_csv(side.folder / "reports/small/per_life.csv").query("method == 'ptl'").assign(method="theirs")
    table = table[table["family"] == "rooms"]
    side.configure(foreign_lives=["lives.csv"])
    for factor in (2, 20):
        side.put("lives.csv", table.assign(total_steps=factor * table["optimum"]).to_csv(index=False))
        side.make()
        costs = pd.read_csv(side.folder / "reports/small/costs.csv").query("method == 'theirs'")
        assert costs["cost"].tolist() == pytest.approx([factor] * len(costs))


def test_a_wrong_configuration_ends_in_one_line(side):
    for changes, message in (
        ({"methods": ["ptl", "fly"]}, "unknown method 'fly'"), ({"maps": 101}, "maps: 101 is not allowed"),
        ({"foreign_lives": ["none.csv"]}, "none.csv: cannot be read"), ({"moving_ai": ["none.map"]}, "none.map"),
    ):  # fmt: skip
        side.configure(**changes)
        [line] = errors_of(side.project.snakemake(*WORKFLOW, "-n", "--configfile", "small.yaml"))
        assert message in line


def test_the_core_works_without_the_study(side):
    shutil.rmtree(side.folder / "studies")
    assert side.project.ptl("--help").returncode == 0
    side.project.waiting()
