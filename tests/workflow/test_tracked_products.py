"""The published products are tracked, and that must not keep a first run from making them."""

from __future__ import annotations

import json
import shutil
import subprocess
from fnmatch import fnmatch
from pathlib import Path

from projects import ROOT, Project

PUBLISHED = ROOT / "reports/published"


def test_a_checkout_with_published_products_still_runs_every_job(tmp_path: Path):
    project = Project(tmp_path, None)
    pages = shutil.ignore_patterns("report.html", "explorer.html")
    shutil.copytree(PUBLISHED, tmp_path / "reports/published", ignore=pages)
    jobs = project.waiting()
    assert (jobs["learn"], jobs["grow"], jobs["survey_batch"]) == (540 + 30, 30, 24)
    for rule in ("collect_growth", "draw_figure", "tabulate", "judge_claims", "manifest"):
        assert rule in jobs


APART = ("manifest.json", "ro-crate-metadata.json", "benchmark.*", "scaling.*")
"""Tracked files that are not products of the main run, or contain checksums themselves."""


def test_the_manifest_names_every_product_of_the_main_run():
    command = ["git", "ls-files", "."]
    listed = subprocess.run(command, cwd=PUBLISHED, capture_output=True, text=True, check=True).stdout
    tracked = {name for name in listed.splitlines() if not any(fnmatch(name, pattern) for pattern in APART)}
    assert len(tracked) > 70
    assert set(json.loads((PUBLISHED / "manifest.json").read_text())["products"]) == tracked


def test_reproduce_keeps_only_products_that_are_there(tmp_path: Path):
    for name in ("Makefile", "requirements.lock", "setup.py", "pyproject.toml"):
        shutil.copy(ROOT / name, tmp_path)

    def commands() -> str:
        done = subprocess.run(["make", "-n", "reproduce"], cwd=tmp_path, capture_output=True, text=True, check=True)
        return done.stdout

    assert "cp -R reports/published" not in commands()
    (tmp_path / "reports/published").mkdir(parents=True)
    assert "cp -R reports/published" in commands()
