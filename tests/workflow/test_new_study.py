"""Users' studies: folders made by `ptl new-study`, outside of the checkout."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml
from projects import ROOMS, ROOT, errors_of

from ptl.world.map_files import load_map

HASTY = """
import rates
from ptl.methods.no_transfer import Method as NoTransfer


class Method(NoTransfer):
    label = "Hasty"
    colour = "#123456"

    def run_episode(self, learner):
        learner.explore(epsilon=rates.EPSILON)
        return []
"""
WALKER = (
    HASTY.replace("import rates", "from . import rates")
    .replace("class Method", "class Walker")
    .replace('label = "Hasty"', 'label, name = "Walker", "walker"')
)
HALL = "######\n#I...#\n#.#..#\n#A.#B#\n#C..##\n######\n"


class Study:
    """A folder with a study, and the place that the package is imported from."""

    def __init__(self, folder: Path, package: Path) -> None:
        self.folder, self.package = folder, package

    def run(self, *arguments: str | Path, where: Path | None = None) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-m", *map(str, arguments)]
        environment = os.environ | {"PYTHONPATH": str(self.package)}
        return subprocess.run(
            command, cwd=where or self.folder, env=environment, capture_output=True, text=True, timeout=900
        )

    def make(self, *arguments: str | Path) -> str:
        done = self.run("snakemake", "-j2", *arguments)
        assert done.returncode == 0, done.stderr[-5000:]
        return done.stdout + done.stderr

    def lay_over(self, **keys: Any) -> None:
        """Change keys of the configuration."""
        path = self.folder / "config/config.yaml"
        path.write_text(yaml.safe_dump(yaml.safe_load(path.read_text()) | keys, sort_keys=False))

    def table(self, name: str) -> pd.DataFrame:
        return pd.read_csv(self.folder / "reports/own_maps/tables" / f"{name}.csv")

    def shown(self) -> Iterator[tuple[str, str]]:
        """Names and texts of all that readers of the study see."""
        for path in sorted((self.folder / "reports").rglob("*")):
            if path.suffix in {".md", ".html", ".rst", ".tex", ".csv", ".svg"}:
                yield path.name, path.read_text(encoding="utf-8")


def new_study(folder: Path, package: Path) -> Study:
    """Make a study of two maps, one of them with its own order."""
    (folder / "rooms.txt").write_text(ROOMS)
    (folder / "Long hall.txt").write_text(HALL)
    for place, file, text in (("mine", "hasty.py", HASTY), ("agents", "walker.py", WALKER)):
        (folder / place).mkdir()
        (folder / place / file).write_text(text)
        (folder / place / "rates.py").write_text("EPSILON = 0.5\n")
    study = Study(folder / "own maps", package)
    done = study.run(
        "ptl", "new-study", "own maps", "--map", "rooms.txt", "--map", "Long hall.txt", "--tasks", "long_hall=CAB",
        "--seeds", "2", "--episodes", "20", "--method", "no_transfer", "--method", "mine/hasty.py",
        "--method", "agents.walker:Walker", "--method", "ptl",
        where=folder,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    study.lay_over(
        statistics={"resamples": 100}, growth={"runs": 2, "tasks": 4, "breakpoint": 2},
        subgoal_frequencies={"trajectories": 3, "starts": 4, "batches": 2},
    )  # fmt: skip
    return study


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Study:
    """A study after a run and its report."""
    study = new_study(tmp_path_factory.mktemp("somewhere"), ROOT)
    study.make()
    study.make("--report", "reports/own_maps/report.html")
    return study


@pytest.mark.slow
def test_only_the_maps_of_the_study_are_learned_in_their_order(study: Study) -> None:
    per_seed = study.table("per_seed")
    orders = {name: "".join(dict.fromkeys(part["task"])) for name, part in per_seed.groupby("environment")}
    assert orders == {"rooms": "AB", "long_hall": "CAB"}
    assert set(per_seed["method"]) == {"no_transfer", "hasty", "walker", "ptl"} and set(per_seed["seed"]) == {0, 1}
    results = {path.name for path in (study.folder / "results/own_maps").iterdir()}
    assert results == {"learning", "growth", "subgoal_frequencies", "steps.h5", "made.json"}


@pytest.mark.slow
def test_its_numbers_are_those_of_its_maps(study: Study) -> None:
    world = load_map(study.folder / "maps/long_hall.txt")
    last = study.table("per_seed").query("environment == 'long_hall' and task == 'B'")
    assert (last["total_steps"] >= 20 * world.shortest_path_length(world.start, world.goal("B"))).all()
    base, ptl = (last[last["method"] == method].set_index("seed") for method in ("no_transfer", "ptl"))
    expected = 1 - ptl["total_steps"] / base["total_steps"]
    assert np.allclose(ptl["transfer_ratio"], expected, rtol=1e-4)


@pytest.mark.slow
def test_it_is_silent_on_the_article(study: Study) -> None:
    names = {path.name for path in (study.folder / "reports").rglob("*.*")}
    assert {"table4.html", "map_long_hall.png", "discovery_rooms.svg", "curves.csv", "growth.png", "explorer.html",
            "frequencies.png", "prior.png", "measures.png", "report.html", "manifest.json"} <= names  # fmt: skip
    assert not [name for name in names if re.match(r"claims|differences|policy_reuse|misleading|figure\d", name)]
    for name, text in study.shown():
        if name not in {"explorer.html", "report.html"}:
            assert not re.search(r"\barticle\b|reproduction|Fern[aá]ndez|figure ?\d\d", text, re.IGNORECASE), name
    report = (study.folder / "reports/own_maps/report.html").read_text(encoding="utf-8")
    assert "own_maps" in report and "a reproduction" not in report
    assert "Verdicts" not in report and "Figure 1" not in report


@pytest.mark.slow
def test_a_second_run_and_verification_find_nothing_to_do(study: Study) -> None:
    assert "Nothing to be done" in study.make()
    done = study.run("ptl", "verify", "results", "reports")
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.slow
def test_a_method_from_elsewhere_came_with_its_helpers_and_is_learned_again_when_they_change(study: Study) -> None:
    for helper, method in (("methods/rates.py", "hasty"), ("agents/rates.py", "walker")):
        path = study.folder / helper
        text = path.read_text()
        path.write_text("EPSILON = 0.6\n")
        planned = study.make("-n", "learning")
        path.write_text(text)
        assert re.findall(r"Learning \w+ with (\w+), seed", planned) == 2 * 2 * [method]


@pytest.mark.slow
def test_it_runs_from_a_wheel(tmp_path: Path) -> None:
    """Everything next to the package in a checkout is in the wheel."""
    site = tmp_path / "site"
    pip = [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check"]
    for command in (
        ["wheel", "--no-deps", "--no-build-isolation", "--wheel-dir", tmp_path, ROOT],
        ["install", "--no-deps", "--target", site, "--find-links", tmp_path, "--no-index", "ptl-skill-library"],
    ):
        done = subprocess.run([*pip, *map(str, command)], capture_output=True, text=True, cwd=tmp_path)
        assert done.returncode == 0, done.stderr
    study = new_study(tmp_path, site)
    study.make()
    study.make("--report", "reports/own_maps/report.html")
    assert len(study.table("per_seed")) == 2 * 4 * 5
    done = study.run("ptl", "verify", "results", "reports")
    assert done.returncode == 0, done.stdout + done.stderr


# -- what is written

YARD = "type octile\nheight 3\nwidth 6\nmap\n......\n.T..W.\n......\n"


def test_a_map_of_another_format_is_written_as_text_with_the_places_asked_for(tmp_path: Path) -> None:
    (tmp_path / "Yard.map").write_text(YARD)
    done = Study(tmp_path, ROOT).run(
        "ptl", "new-study", "my study", "--map", "Yard.map", "--start", "1,1", "--goal", "3,6", "--goal", "1,4"
    )
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "my study/maps/yard.txt").read_text() == "I..B..\n.#..#.\n.....A\n"
    assert "run it: cd 'my study' && " in done.stdout
    config = yaml.safe_load((tmp_path / "my study/config/config.yaml").read_text())
    assert (config["growth"], config["subgoal_frequencies"]) == ({"runs": 0}, {"starts": 0})


def test_survey_and_growth_are_there_if_asked_for(tmp_path: Path) -> None:
    (tmp_path / "rooms.txt").write_text(ROOMS)
    arguments = ["new-study", "mine", "--map", "rooms.txt", "--seeds", "3", "--survey", "--growth"]
    assert Study(tmp_path, ROOT).run("ptl", *arguments).returncode == 0
    config = yaml.safe_load((tmp_path / "mine/config/config.yaml").read_text())
    assert config["growth"] == {"runs": 3} and "subgoal_frequencies" not in config


@pytest.mark.slow
def test_a_configuration_names_maps_of_other_formats_and_leaves_survey_and_growth_out(tmp_path: Path) -> None:
    (tmp_path / "yard.map").write_text(YARD)
    (tmp_path / "rooms.txt").write_text(ROOMS)
    study = Study(tmp_path / "mine", ROOT)
    assert study.run("ptl", "new-study", "mine", "--map", "rooms.txt", "--seeds", "2", where=tmp_path).returncode == 0
    options = {"start": [1, 1], "goals": [[3, 6], [1, 4]]}
    study.lay_over(
        environments={"yard": {"map": "../yard.map", "map_options": options}}, methods=["no_transfer", "ptl"],
        learning={"episodes": 10}, statistics={"resamples": 100},
    )  # fmt: skip
    study.make()
    per_seed = pd.read_csv(study.folder / "reports/mine/tables/per_seed.csv")
    assert set(per_seed["task"]) == {"A", "B"} and set(per_seed["environment"]) == {"yard"}
    names = {path.name for path in (study.folder / "reports").rglob("*.*")}
    assert "map_yard.png" in names and not {"growth.csv", "growth.png", "frequencies.png"} & names
    assert {path.name for path in (study.folder / "results/mine").iterdir()} == {"learning", "steps.h5", "made.json"}
    assert "Nothing to be done" in study.make()
    options["start"] = [3, 1]
    study.lay_over(environments={"yard": {"map": "../yard.map", "map_options": options}})
    assert "Learning yard" in study.make("-n", "learning")


def test_a_study_of_few_episodes_has_a_shorter_window(tmp_path: Path) -> None:
    (tmp_path / "rooms.txt").write_text(ROOMS)
    study = Study(tmp_path / "mine", ROOT)
    done = study.run("ptl", "new-study", "mine", "--map", "rooms.txt", "--episodes", "5", where=tmp_path)
    *_, note, last = done.stdout.splitlines()
    assert "measures.window is 5" in note and last.endswith("then open reports/mine/index.html")
    config = yaml.safe_load((study.folder / "config/config.yaml").read_text())
    assert (config["learning"], config["measures"]) == ({"episodes": 5}, {"window": 5})


def test_a_run_ends_with_the_page_to_open(tmp_path: Path) -> None:
    (tmp_path / "rooms.txt").write_text(ROOMS)
    study = Study(tmp_path / "mine", ROOT)
    arguments = ["--map", "rooms.txt", "--episodes", "5", "--seeds", "1", "--method", "ptl"]
    assert study.run("ptl", "new-study", "mine", *arguments, where=tmp_path).returncode == 0
    assert "Open reports" not in study.make("learning")
    assert "Open reports/mine/index.html in a browser." in study.make("reports/mine/index.html")


# -- refusals


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--map", "nowhere.txt"], "nowhere.txt: "),
        (["--map", "rooms.txt", "--map", "Rooms.txt"], "both called rooms; rename"),
        (["--map", "rooms.txt", "--tasks", "BX"], "environments.rooms.tasks: 'BX' is not allowed; give"),
        (["--map", "rooms.txt", "--tasks", "halls=AB"], "no map is called 'halls'; known are rooms"),
        (["--map", "rooms.txt", "--method", "magic"], "unknown method 'magic'"),
        (["--map", "rooms.txt", "--method", "lost.py"], "method lost.py: no such file"),
    ],
)
def test_a_mistake_is_one_line_and_leaves_no_folder(tmp_path: Path, arguments: list[str], message: str) -> None:
    for name in ("rooms.txt", "Rooms.txt"):
        (tmp_path / name).write_text(ROOMS)
    done = Study(tmp_path, ROOT).run("ptl", "new-study", "mine", *arguments)
    [line] = errors_of(done)
    assert message in line
    assert not (tmp_path / "mine").exists()


def test_a_folder_in_use_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "rooms.txt").write_text(ROOMS)
    [line] = errors_of(Study(tmp_path, ROOT).run("ptl", "new-study", ".", "--map", "rooms.txt"))
    assert "exists already" in line
