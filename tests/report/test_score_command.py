"""``ptl score``: its template, its output and files, and the worked example."""

from __future__ import annotations

import csv
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner
from predictions import normal_predictions
from projects import ROOT

from ptl.cli.score import command
from ptl.errors import UserError
from ptl.files.csv import write_csv
from ptl.measures.scoring import SCORE_COLUMNS
from ptl.text import interval

EXAMPLE = ROOT / "examples/score"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with predictions of the example's cells where the command looks for them."""
    monkeypatch.chdir(tmp_path)
    lines = (EXAMPLE / "made_up.csv").read_text(encoding="utf-8").splitlines()
    cells = [tuple(row[:5]) for row in csv.reader(lines[2:])]
    random = np.random.default_rng(3)
    predictions = normal_predictions(cells, random.uniform(0, 1000, len(cells)), random.uniform(1, 300, len(cells)))
    write_csv(predictions, tmp_path / "reports/predictions/predictions.csv")
    return tmp_path


def printed(*arguments: str, width: int = 250) -> str:
    result = CliRunner().invoke(command, arguments, env={"COLUMNS": str(width)}, catch_exceptions=False)
    assert result.exit_code == 0
    return result.output


def refusal(*arguments: str) -> str:
    result = CliRunner().invoke(command, arguments)
    assert isinstance(result.exception, UserError)
    return str(result.exception)


def test_template_then_scores(folder: Path):
    assert "typed" not in (said := printed("--template", "mine.csv")) and "ptl score mine.csv" in said
    assert "exists and may have numbers typed in" in refusal("--template", "mine.csv")
    text = (folder / "mine.csv").read_text()
    (folder / "mine.csv").write_text(text.replace("4,env2,F,ptl,total_steps,,", "4,env2,F,ptl,total_steps,500,"))
    lines = printed("mine.csv").splitlines()
    scores = pd.read_csv("mine_scores.csv", dtype={"table": str})
    assert list(scores.columns) == list(SCORE_COLUMNS) and len(scores) == 2
    assert lines[0] == "Table 4, env2"
    assert lines[3].split()[:5] == ["F", "ptl", "total_steps", "mean", "500"]
    row = scores.iloc[0]
    assert interval(row["low_90"], row["high_90"]) in lines[3]
    mark = "*" if row["inside_50"] else "+" if row["inside_90"] else " "
    assert f"{row['rank']:.3f}{mark}" in lines[3].replace("−", "-")
    for name in ("mine_scores.png", "mine_scores.svg"):
        assert (folder / name).stat().st_size > 10_000
    covered = pd.read_csv("mine_scores_coverage.csv")
    assert covered[["distribution", "nominal"]].to_numpy().tolist() == [
        ["prior", 0.5], ["prior", 0.9], ["conditional", 0.5], ["conditional", 0.9],
    ]  # fmt: skip
    assert lines[-3].startswith("The 90% range over all settings contains ")


def test_narrow_terminals_see_every_column(folder: Path):
    (folder / "mine.csv").write_text(
        "table,environment,task,method,measure,mean\n1,env1,F,ptl,asymptotic,101\n", encoding="utf-8"
    )
    narrow = printed("mine.csv", width=80)
    assert max(map(len, narrow.split("coverage")[0].splitlines())) <= 80
    assert narrow.count("CRPS") == printed("mine.csv").count("CRPS")


def test_refusals_name_the_file(folder: Path):
    assert refusal("none.csv").startswith("none.csv: cannot be read")
    assert refusal("none.csv", "--predictions", "other.csv").startswith("other.csv: cannot be read as CSV")
    (folder / "mine.csv").write_text("table\n")
    assert "mine.csv: no column 'environment'" in refusal("mine.csv")
    assert "end the name in .png" in refusal(str(EXAMPLE / "made_up.csv"), "--output", "scores.csv")


def test_the_example_is_scored(folder: Path):
    said = printed(str(EXAMPLE / "made_up.csv"), "--output", "made_up_scores.png")
    assert [line for line in said.splitlines() if line.startswith("Table ")] == [
        f"Table {table}, env{(table + 1) // 2}" for table in range(1, 7)
    ]
    assert len(pd.read_csv("made_up_scores.csv")) == 420 * 2 * 2
    assert "The 90% range over all settings contains" in said


def test_the_example_says_that_it_is_made_up_and_how(folder: Path):
    made_up = (EXAMPLE / "made_up.csv").read_text(encoding="utf-8")
    assert "MADE UP" in made_up.splitlines()[0] and "not the article's" in made_up.splitlines()[0]
    assert "made up; its numbers are not the article's" in (EXAMPLE / "README.md").read_text().splitlines()[0]
    (folder / "make_up.py").write_bytes((EXAMPLE / "make_up.py").read_bytes())
    subprocess.run([sys.executable, "make_up.py"], check=True)
    assert (folder / "made_up.csv").read_text(encoding="utf-8") == made_up
