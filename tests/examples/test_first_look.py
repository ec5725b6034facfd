"""The first look: a script that runs, and a notebook that shows what it prints and draws."""

from __future__ import annotations

import json
import subprocess
import sys

from matplotlib.image import imread
from projects import ROOT


def test_the_script_prints_what_the_notebook_shows_and_draws_three_figures(tmp_path):
    script = ROOT / "examples/first_look.py"
    done = subprocess.run([sys.executable, script], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0 and not done.stderr, done.stderr
    cells = json.loads(script.with_suffix(".ipynb").read_text(encoding="utf-8"))["cells"]
    outputs = [output for cell in cells for output in cell.get("outputs", ())]
    assert "".join(line for output in outputs for line in output.get("text", ())) == done.stdout
    assert [output["output_type"] for output in outputs].count("display_data") == 3
    for name in ("map", "values", "curves"):
        paper = imread(tmp_path / f"first_look_{name}.png")[..., :3].min(axis=2) > 0.99
        assert 0.01 < (~paper).mean() < 0.95, name
