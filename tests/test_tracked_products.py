"""The published products are tracked, and that must not keep a first run from making them."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
from fnmatch import fnmatch
from pathlib import Path

from test_workflow import ROOT, Project


def test_a_checkout_with_published_products_still_runs_every_job(tmp_path: Path):
    project = Project(tmp_path)
    shutil.copytree(
        ROOT / "reports/published",
        tmp_path / "reports/published",
        ignore=shutil.ignore_patterns("report.html", "explorer.html"),
    )
    done = subprocess.run(
        [sys.executable, "-m", "snakemake", "-n", "--quiet", "reason"],
        cwd=project.folder, capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    jobs = {name: int(count) for name, count in re.findall(r"^(\w+) +(\d+)$", done.stdout + done.stderr, flags=re.M)}
    assert jobs["learn"] == 540 and jobs["grow"] == 30 and jobs["survey_batch"] == 24
    for rule in ("collect_growth", "draw_frequencies", "tabulate", "judge_claims", "report_fv", "manifest"):
        assert rule in jobs


APART = ("manifest.json", "*.sha256", "robustness/*", "benchmark.*", "scaling.*")
"""What is tracked but not of the main run, or holds checksums itself."""


def test_the_manifest_names_every_product_of_the_main_run():
    folder = ROOT / "reports/published"
    listed = subprocess.run(["git", "ls-files", "."], cwd=folder, capture_output=True, text=True, check=True).stdout
    tracked = {name for name in listed.splitlines() if not any(fnmatch(name, pattern) for pattern in APART)}
    assert len(tracked) > 80
    assert set(json.loads((folder / "manifest.json").read_text())["products"]) == tracked
