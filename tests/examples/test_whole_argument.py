"""The argument in one script: published numbers without workflow and files; the notebook is the same."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from projects import ROOT

SCRIPT, NOTEBOOK = ROOT / "examples/whole_argument.py", ROOT / "examples/whole_argument.ipynb"
RUN = f"""
import json, runpy, sys
names = runpy.run_path({str(SCRIPT)!r}, run_name="__main__")
names["measured"].per_seed.to_csv("per_seed.csv", index=False)
names["measured"].subgoals.to_csv("subgoals.csv", index=False)
names["frame"].to_csv("figure12.csv", index=False)
parts = {{
    judged.claim.id: {{
        "verdict": str(judged.verdict),
        "parts": [
            [part.text, part.estimate.value, part.estimate.low, part.estimate.high, str(part.outcome)]
            for part in (*judged.parts, *judged.plain)
        ],
    }}
    for judged in names["judgements"]
}}
open("judged.json", "w").write(json.dumps(parts))
open("modules.json", "w").write(json.dumps(sorted(sys.modules)))
"""


@pytest.fixture(scope="module")
def ran(tmp_path_factory: pytest.TempPathFactory) -> SimpleNamespace:
    """The script, run once in its own folder: its output and its numbers."""
    folder = tmp_path_factory.mktemp("argument")
    done = subprocess.run([sys.executable, "-c", RUN], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0 and not done.stderr, done.stderr[-3000:]
    read = {name: json.loads((folder / f"{name}.json").read_text()) for name in ("judged", "modules")}
    return SimpleNamespace(folder=folder, printed=done.stdout, **read)


@pytest.fixture(scope="module")
def notebook() -> dict:
    return json.loads(NOTEBOOK.read_text(encoding="utf-8"))


def published(name: str, environment: str = "env2") -> pd.DataFrame:
    frame = pd.read_csv(ROOT / "reports/published" / name)
    return frame[frame["environment"] == environment].reset_index(drop=True)


def assert_equal(own: pd.DataFrame, other: pd.DataFrame, keys: list[str]) -> None:
    """The rows of both are the same, numbers to the digits that the published table has."""
    own, other = (frame.sort_values(keys).reset_index(drop=True) for frame in (own, other))
    pd.testing.assert_frame_equal(own[other.columns], other, check_dtype=False, rtol=1e-5)


@pytest.mark.parametrize("name", ["per_seed", "subgoals"])
def test_numbers_are_those_of_the_published_run(ran: SimpleNamespace, name: str) -> None:
    own, expected = pd.read_csv(ran.folder / f"{name}.csv"), published(f"tables/{name}.csv")
    assert len(own) > 500
    assert_equal(own, expected, ["method", "task", "seed"])


def test_curves_are_those_of_the_published_figure(ran: SimpleNamespace) -> None:
    own, expected = pd.read_csv(ran.folder / "figure12.csv"), published("figures/figure12.csv")
    assert_equal(own, expected, ["method", "episode"])


def test_verdicts_are_those_of_the_published_tables(ran: SimpleNamespace) -> None:
    """The ledger has the verdict by the 30 runs of the tables and the one by all runs."""
    claims = pd.read_csv(ROOT / "reports/published/claims.csv").set_index("id")
    parts = pd.read_csv(ROOT / "reports/published/claims_parts.csv")
    expected = [name for name in claims.index if name.startswith("E2-")]
    assert list(ran.judged) == expected
    for name, judged in ran.judged.items():
        assert judged["verdict"] == claims.loc[name, "verdict_30"]
        assert f"{name}: {judged['verdict']}" in ran.printed
        rows = parts[parts["id"] == name]
        texts, *numbers, outcomes = zip(*judged["parts"], strict=True)
        assert list(texts) == rows["part"].tolist()
        assert list(outcomes) == rows["outcome_30"].tolist()
        np.testing.assert_allclose(np.array(numbers).T, rows[["estimate_30", "low_30", "high_30"]], rtol=1e-3)


def test_needs_neither_workflow_nor_files(ran: SimpleNamespace) -> None:
    packages = {name.partition(".")[0] for name in ran.modules}
    assert not packages & {"snakemake", "h5py"}
    assert not [name for name in ran.modules if name.startswith("ptl.files")]
    assert len(SCRIPT.read_text().splitlines()) < 120


def test_figure_is_drawn(ran: SimpleNamespace) -> None:
    from matplotlib.image import imread

    paper = imread(ran.folder / "whole_argument.png")[..., :3].min(axis=2) > 0.99
    assert 0.01 < (~paper).mean() < 0.9
    for edge in (paper[:2], paper[-2:], paper[:, :2], paper[:, -2:]):
        assert edge.all()


# -- the notebook --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["whole_argument", "first_look"])
def test_notebooks_are_made_from_their_scripts(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(ROOT / "examples")
    from make_notebook import cells_of

    path = ROOT / f"examples/{name}.ipynb"
    notebook = json.loads(path.read_text(encoding="utf-8"))
    cells = [(cell["cell_type"], "".join(cell["source"])) for cell in notebook["cells"]]
    script = path.with_suffix(".py").read_text(encoding="utf-8")
    assert cells == cells_of(script), "run: python examples/make_notebook.py"


def test_notebook_shows_what_the_script_prints(ran: SimpleNamespace, notebook: dict) -> None:
    outputs = [output for cell in notebook["cells"] for output in cell.get("outputs", ())]
    printed = "".join(line for output in outputs for line in output.get("text", ()))
    assert printed == ran.printed, "run: python examples/make_notebook.py"
    [picture] = [output for output in outputs if output["output_type"] == "display_data"]
    assert set(picture["data"]) == {"image/png"}


@pytest.mark.parametrize("name", ["whole_argument", "first_look"])
def test_notebooks_are_small_and_name_no_machine(name: str) -> None:
    text = (ROOT / f"examples/{name}.ipynb").read_text(encoding="utf-8")
    assert len(text) < 300_000
    words = re.sub(r'"image/png": "[^"]*"', "", text)
    assert not re.search(r"/(home|root|tmp|usr|Users|opt|work)/", words)
    assert str(Path.home()) not in words and str(ROOT) not in words
