"""Runs and the robustness study use files only for the question that they answer.

A run on methods of one's own, with results of other programs, is here too.
"""

from __future__ import annotations

import json
import os
import re
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
import yaml
from projects import ROOT, TINY, Project

from ptl.files.manifest import _content

pytestmark = pytest.mark.slow

PAIRED = "results and products paired with another run, all refused"

SETTINGS: dict[str, Any] = {
    "seeds": 2, "replicates": 2, "max_steps": 10_000, "step_budget": 10**6, "growth": {"tasks": 4, "runs": 1},
    "latin_hypercube": {"settings": 0, "seed": 0}, "unknowns": {"skills.patience": {"symbol": "p", "values": [2.0]}},
}  # fmt: skip

OWN: dict[str, Any] = {
    **TINY, "environments": {"rooms": {"map": "rooms.txt", "tasks": "AB"}},
    "methods": ["no_transfer", "full_transfer", "ptl", "mine.py"],
    "foreign_results": {"theirs": {"file": "theirs.csv"}},
}  # fmt: skip

MINE = (ROOT / "examples/methods/optimistic.py").read_text()


def theirs(steps: int) -> str:
    """Results of another program: so many steps in every episode."""
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


class Side:
    """A study in a copy of the checkout, its file, and the arguments that run it."""

    def __init__(self, folder: Path, file: str, content: dict[str, Any], results: str, *arguments: str) -> None:
        self.project = Project(folder)
        (self.project.folder / "mine.py").write_text(MINE)
        (self.project.folder / "theirs.csv").write_text(theirs(50))
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


@pytest.fixture
def own(tmp_path: Path, whole_run: Side) -> Side:
    """A finished run of which Snakemake remembers nothing."""
    copy = object.__new__(Side)
    copy.__dict__.update(whole_run.__dict__)
    copy.project = object.__new__(Project)
    copy.project.folder = tmp_path / "copy"
    copy.file = copy.project.folder / "config/config.yaml"
    shutil.copytree(whole_run.project.folder, copy.project.folder, symlinks=True)
    copy.forget()
    return copy


@pytest.fixture(scope="module")
def whole_run(tmp_path_factory: pytest.TempPathFactory) -> Side:
    return Side(tmp_path_factory.mktemp("own"), "config/config.yaml", OWN, "results/tiny")


def test_a_finished_run_stays_as_it_is(own: Side) -> None:
    own.project.make()
    assert "not held against" not in own.verified()


@pytest.mark.parametrize("place", ["mine.py", "other/mine.py"])
def test_lives_by_another_method_of_the_same_name_are_refused(own: Side, place: str) -> None:
    path = own.project.folder / place
    path.parent.mkdir(exist_ok=True)
    put(path, MINE.replace("np.ones", "0.5 * np.ones"))
    own.write({**OWN, "methods": [*OWN["methods"][:3], place]})
    printed = own.refused()
    assert "--forcerun learn" in printed
    own.mend(printed)
    assert "are whole" in own.verified()


def test_older_results_of_other_programs_are_noticed(own: Side) -> None:
    put(own.project.folder / "theirs.csv", theirs(500))
    own.mend(own.refused())
    table = pd.read_csv(own.project.folder / "reports/tiny/tables/per_seed.csv").query("method == 'theirs'")
    assert table["total_steps"].tolist() == [500 * 20] * 4


def test_a_method_that_leaves_the_run_leaves_every_product(own: Side) -> None:
    own.write({**OWN, "methods": ["no_transfer", "ptl", "mine.py"]})
    printed = own.refused()
    assert "learn" not in printed.partition("--forcerun")[2].partition("'")[0]
    own.mend(printed)
    for product in (own.project.folder / "reports/tiny").rglob("*.csv"):
        assert "full_transfer" not in product.read_text(), product


def test_the_command_for_a_missing_product_makes_it(own: Side) -> None:
    product = own.project.folder / "reports/tiny/tables/metrics.csv"
    whole = product.read_bytes()
    for damage in (product.unlink, lambda: product.write_text("x")):
        damage()
        printed = own.project.ptl("verify", "reports/tiny").stdout
        product.unlink(missing_ok=True)
        own.mend(printed)
        assert product.read_bytes() == whole
    assert "are whole" in own.project.ptl("verify", "reports/tiny").stdout
