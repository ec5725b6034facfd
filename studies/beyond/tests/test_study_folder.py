"""Users' methods on the maps of the second study, as documented."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pandas as pd
import pytest
from projects import ROOT, Project, errors_of

from studies.beyond.collect import LIFE_COLUMNS, read_lives
from studies.beyond.population import read_population

PAGE = Path(__file__).parent.parent / "README.md"
CODE = re.search(r"^```python\n(.*?)^```$", PAGE.read_text(), re.MULTILINE | re.DOTALL)


def run(folder: Path, *arguments: str | Path) -> subprocess.CompletedProcess[str]:
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-m", *map(str, arguments)]
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=900)


def theirs(path: Path, maps: int, **changes: object) -> Path:
    """Write lives of another program at twice the optimum of 5 episodes."""
    entries = [
        entry for entry in read_population() if (entry.band, entry.size) == ("test", 300) and entry.seed < 4000 + maps
    ]
    optima = [5 * sum(entry.shortest_paths[1:]) for entry in entries]
    rows = [
        (entry.family, entry.seed, 300, "increasing", "rocket", seed, 2 * optimum, optimum, 0)
        for entry, optimum in zip(entries, optima, strict=True)
        for seed in range(2)
    ]
    pd.DataFrame(rows, columns=list(LIFE_COLUMNS)).assign(**changes).to_csv(path, index=False)
    return path


@pytest.mark.slow
def test_a_file_and_a_table_of_lives_are_put_on_the_page(tmp_path):
    assert CODE
    (tmp_path / "half_hopeful.py").write_text(CODE[1])
    theirs(tmp_path / "rocket.csv", 2)
    made = run(tmp_path, "ptl", "new-study", "final", "--population", "test", "--maps-per-family", "2", "--seeds", "2",
               "--episodes", "5", "--method", "half_hopeful.py", "--method", "ptl",
               "--lives", "rocket.csv")  # fmt: skip
    assert made.returncode == 0, made.stderr
    done = run(tmp_path / "final", "snakemake", "-j2")
    assert done.returncode == 0, done.stderr[-3000:]
    page = (tmp_path / "final/reports/final/index.html").read_text()
    assert "Half hopeful" in page and "Rocket" in page
    costs = pd.read_csv(tmp_path / "final/reports/final/costs.csv").set_index(["family", "method"])["cost"]
    assert costs.xs("rocket", level="method").tolist() == [2.0] * 6
    lives = read_lives(tmp_path / "final/reports/final/per_life.csv")
    assert set(lives["method"]) == {"half_hopeful", "ptl"} and len(lives) == 2 * 6 * 2 * 2


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"optimum": 7}, "the optimum of family chain, map 4000 is 7, where 5 episodes give"),
        ({"total_steps": 3}, "has fewer steps than the optimum"),
        ({"seed": 0}, "is there twice"),
        ({"method": "ptl"}, "method ptl is in methods already"),
        ({"size": 1000}, "holds no life on the maps of this study"),
    ],
)
def test_a_table_of_lives_at_fault_is_refused_before_anything_is_written(tmp_path, changes, message):
    theirs(tmp_path / "rocket.csv", 1, **changes)
    made = run(tmp_path, "ptl", "new-study", "final", "--population", "test", "--maps-per-family", "1", "--seeds", "2",
               "--episodes", "5", "--method", "ptl", "--lives", "rocket.csv")  # fmt: skip
    [line] = errors_of(made)
    assert message in line
    assert not (tmp_path / "final").exists()


def test_options_that_do_not_go_together_are_refused(tmp_path):
    for arguments in (["--population", "test", "--map", "a.txt"], ["--lives", "a.csv"], ["--population", "own"], []):
        [_] = errors_of(run(tmp_path, "ptl", "new-study", "final", *arguments))
        assert not (tmp_path / "final").exists()


def test_without_the_study_there_is_no_population(tmp_path):
    project = Project(tmp_path / "copy", None)
    done = project.ptl("new-study", "final", "--population", "test")
    assert errors_of(done) == ["error: --population: there is no study of a population of maps here; give --map"]
