"""The robustness study and the second study use files only for the question that they answer, as the run does."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml
from projects import TINY, Project

from ptl.files.manifest import _content

pytestmark = pytest.mark.slow

PAIRED = "results and products paired with another run, all refused"

SETTINGS: dict[str, Any] = {
    "seeds": 2, "replicates": 2, "max_steps": 10_000, "step_budget": 10**6, "growth": {"tasks": 4, "runs": 1},
    "latin_hypercube": {"settings": 0, "seed": 0}, "unknowns": {"skills.patience": {"symbol": "p", "values": [2.0]}},
}  # fmt: skip

LIVES: dict[str, Any] = {
    "run": "beyond", "families": ["rooms"], "maps": 2, "seeds": 2, "methods": ["no_transfer", "ptl"],
    "article_maps": {"rooms": {"map": "rooms.txt", "tasks": "AB"}}, "article_seeds": 2, "learning": {"episodes": 20},
    "explorer": {"methods": ["ptl"]}, "statistics": {"resamples": 100},
}  # fmt: skip


class Side:
    """A study in a copy of the checkout, its file, and the arguments that run it."""

    def __init__(self, folder: Path, file: str, content: dict[str, Any], results: str, *arguments: str) -> None:
        self.project = Project(folder)
        self.file = self.project.folder / file
        self.results = results
        self.arguments = arguments
        self.write(content)
        self.project.make(*arguments)

    def write(self, content: dict[str, Any]) -> None:
        self.file.write_text(yaml.safe_dump(content, sort_keys=False))

    def forget(self) -> None:
        """Lose what Snakemake remembers."""
        shutil.rmtree(self.project.folder / ".snakemake")

    def refused(self) -> str:
        """Run the study, which must refuse; return what it printed."""
        done = self.project.snakemake(*self.arguments)
        printed = done.stdout + done.stderr
        assert done.returncode != 0 and "Traceback" not in printed
        return printed

    def mend(self, printed: str) -> None:
        """Run the command that a refusal names, then the study."""
        command = re.search(r"run 'snakemake ([^']*)'", printed)
        assert command, printed
        self.project.make(*command[1].split())
        self.project.make(*self.arguments)

    def verified(self) -> str:
        done = self.project.ptl("verify", self.results)
        assert "Traceback" not in done.stderr
        return done.stdout + done.stderr

    def change_made(self, change: Callable[[dict[str, Any]], Any]) -> str:
        """Return what `ptl verify` says while the copy of the manifest is another one."""
        made = self.project.folder / self.results / "made.json"
        whole = made.read_text()
        manifest = json.loads(whole)
        change(manifest)
        manifest["content"] = _content(manifest)
        made.write_text(json.dumps(manifest))
        try:
            return self.verified()
        finally:
            made.write_text(whole)


@pytest.fixture(scope="module")
def robustness(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Side]:
    folder = tmp_path_factory.mktemp("robustness")
    yield Side(folder, "config/robustness.yaml", SETTINGS, "results/tiny/robustness", "--", "robustness")


@pytest.fixture(scope="module")
def lives(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Side]:
    folder = tmp_path_factory.mktemp("lives")
    yield Side(folder, "config/beyond.yaml", LIVES, "results/beyond", "--snakefile", "workflow/beyond.smk")


def test_what_the_studies_leave_is_whole(robustness: Side, lives: Side) -> None:
    for side, files in ((robustness, 3), (lives, 4)):
        printed = side.verified()
        assert "are whole, in place and consistent" in printed and "not held against" not in printed, printed
        assert int(printed.split()[0]) >= files
        assert side.project.waiting(*side.arguments) == {}
    printed = lives.project.ptl("verify", "reports/beyond").stdout
    assert re.search(r"\d\d products are those of reports/beyond/manifest\.json", printed)
    assert "not checked" not in printed


def test_settings_of_another_run_are_refused(robustness: Side, record_property: Callable[[str, int], None]) -> None:
    record_property(PAIRED, 3)
    assert "was made with another value of parameters" in robustness.change_made(
        lambda made: made["config"]["learning"].update(alpha=0.7)
    )
    assert "which is not in the run" in robustness.change_made(
        lambda made: made["config"]["study"].update(replicates=1)
    )
    robustness.project.configure({**TINY, "learning": {"episodes": 20, "alpha": 0.7}})
    robustness.forget()
    printed = robustness.refused()
    assert "parameters" in printed and "--forcerun learn_setting" in printed
    robustness.mend(printed)
    assert "are whole" in robustness.verified()


def test_lives_of_another_study_are_refused(lives: Side, record_property: Callable[[str, int], None]) -> None:
    record_property(PAIRED, 4)
    for change in (
        lambda made: made["config"]["learning"].update(alpha=0.7),
        lambda made: made["config"].update(seeds=3),
    ):
        assert "was made with another value of" in lives.change_made(change)
    fewer = {"methods": ["no_transfer"], "explorer": {}}
    assert "which is not in the run" in lives.change_made(lambda made: made["config"].update(fewer))
    printed = lives.change_made(lambda made: made["config"].update(methods=["fly"]))
    assert "results/beyond/made.json: cannot be a run's" in printed and printed.count("\n") == 1
    lives.write({**LIVES, "learning": {"episodes": 20, "alpha": 0.7}})
    lives.forget()
    printed = lives.refused()
    assert "alpha" in printed and "learn_lives" in printed
    lives.mend(printed)
    assert "are whole" in lives.verified()


def test_a_map_replaced_by_an_older_file_is_learned_anew(lives: Side) -> None:
    rooms = lives.project.folder / "rooms.txt"
    text = rooms.read_text()
    other = lives.project.folder / "other.txt"
    other.write_text(text.replace("#..B#", "#.B.#"))
    shutil.copystat("/etc/hostname", other)
    other.replace(rooms)
    waiting = lives.project.waiting(*lives.arguments)
    assert waiting["learn_lives"] == 2 and waiting["check_study"] == 1
    lives.project.make(*lives.arguments)
    assert "are whole" in lives.verified()
