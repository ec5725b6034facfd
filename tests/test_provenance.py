"""The digests name exactly the sources that a module uses."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from ptl import provenance
from ptl.errors import UserError


@pytest.fixture
def package(tmp_path, monkeypatch) -> Path:
    """A copy of the package's sources whose files a test may edit."""
    copy = tmp_path / "ptl"
    shutil.copytree(provenance.PACKAGE, copy, ignore=shutil.ignore_patterns("*.so", "*.c", "__pycache__"))
    monkeypatch.setattr(provenance, "PACKAGE", copy)
    provenance._sources_and_imports.cache_clear()
    yield copy
    provenance._sources_and_imports.cache_clear()


LEARNING = ("ptl.learning", "ptl.methods.ptl", "ptl.store")


@pytest.mark.parametrize(
    ("edited", "learning_changes"),
    [
        ("_kernel.pyx", True),
        ("_kernel.pxd", True),
        ("_graph.pyx", True),
        ("skills.py", True),
        ("subgoals.py", True),
        ("methods/ptl.py", True),
        ("store.py", True),
        ("methods/policy_reuse.py", False),
        ("figures/maps.py", False),
        ("figures/style.py", False),
        ("tables.py", False),
        ("statistics.py", False),
        ("_survey.pyx", False),
    ],
)
def test_only_what_learning_uses_changes_its_digest(package, edited, learning_changes):
    before = provenance.code_digest(*LEARNING)
    path = package / edited
    path.write_text(path.read_text() + "\n# edited\n")
    provenance._sources_and_imports.cache_clear()
    assert (provenance.code_digest(*LEARNING) != before) == learning_changes


def test_a_plot_hangs_on_its_own_file(package):
    maps, growth = provenance.code_digest("ptl.figures.maps"), provenance.code_digest("ptl.figures.growth")
    path = package / "figures/maps.py"
    path.write_text(path.read_text() + "\n# edited\n")
    provenance._sources_and_imports.cache_clear()
    assert provenance.code_digest("ptl.figures.maps") != maps
    assert provenance.code_digest("ptl.figures.growth") == growth


def test_present_build_is_accepted():
    provenance.check_build()


def test_stale_build_is_refused(package):
    (package / "_kernel.pyx").write_text("# other sources\n")
    with pytest.raises(UserError, match=r"ptl\._kernel was built from other sources .* 'make build'"):
        provenance.check_build()
