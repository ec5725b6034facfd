"""Each folder of studies/ is a study that can be removed."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from projects import ROOT

from ptl.files.job import KINDS
from ptl.jobs.kinds import register_studies
from ptl.report.format_tables import tables

STUDIES = sorted(path.parent for path in (ROOT / "studies").glob("*/README.md"))


def test_every_study_has_its_parts() -> None:
    assert STUDIES
    for folder in STUDIES:
        assert (folder / "study.mk").is_file() and (folder / "__init__.py").is_file()
        assert list((folder / "config").glob("*.yaml")) and list((folder / "tests").glob("test_*.py"))


def test_pages_of_studies_describe_their_files() -> None:
    register_studies()
    kinds = [kind for kind in KINDS.values() if kind.__module__.startswith("studies.")]
    assert bool(kinds) == any((folder / "jobs.py").is_file() for folder in STUDIES)
    for kind in kinds:
        page = ROOT / "studies" / kind.__module__.split(".")[1] / "README.md"
        marks = [f"<!-- {kind.__name__}, {word} -->" for word in ("begin", "end")]
        assert f"{marks[0]}\n\n{tables(kind)}\n{marks[1]}" in page.read_text(encoding="utf-8"), "run: ptl docs"


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """A copy of all files of the checkout but results, with the built extensions."""
    folder = tmp_path / "copy"
    ignored = (".git", ".venv", ".snakemake", "results", "logs", "reports", "build", "__pycache__", ".*_cache")
    shutil.copytree(ROOT, folder, ignore=shutil.ignore_patterns(*ignored), symlinks=True)
    return folder


@pytest.mark.slow
@pytest.mark.parametrize("study", [folder.name for folder in STUDIES])
def test_a_study_can_be_removed(study: str, checkout: Path) -> None:
    shutil.rmtree(checkout / "studies" / study)
    environment = os.environ | {"PYTHONPATH": str(checkout)}

    def succeeds(*command: str) -> str:
        done = subprocess.run(command, cwd=checkout, env=environment, capture_output=True, text=True, timeout=900)
        assert done.returncode == 0, (done.stdout + done.stderr)[-5000:]
        return done.stdout + done.stderr

    succeeds(str(Path(sys.executable).with_name("lint-imports")), "--no-cache")
    assert "learn" in succeeds(sys.executable, "-m", "snakemake", "-n", "--quiet", "reason")
    assert "reproduce" in succeeds("make", "help")
    quick = ("-q", "-p", "no:cacheprovider", "-m", "not slow", "tests/claims", "tests/measures")
    assert " passed" in succeeds(sys.executable, "-m", "pytest", *quick)
