"""The digests name exactly the sources that a module uses."""

from __future__ import annotations

import ast
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from projects import ROOT

from ptl import methods
from ptl.errors import UserError
from ptl.files import provenance
from ptl.files.checkout import check_checkout
from ptl.files.outside import learning_code, sources_of
from ptl.learning.growth import METHOD


def forget() -> None:
    """Make the next digest read the sources again."""
    provenance.code_digest.cache_clear()
    provenance._sources_and_imports.cache_clear()


def parsed_imports(path: Path) -> set[str]:
    """Imports of a file from this package and the studies, by Python's own parser."""
    found, ours = set(), ("ptl", "studies")
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.split(".")[0] in ours:
            names = [f"{node.module}.{alias.name}" for alias in node.names]
            found |= {name if provenance._is_module(name) else node.module for name in names}
        elif isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names if alias.name.split(".")[0] in ours}
    return found


def test_imports_are_found_as_the_parser_finds_them():
    modules = sorted(provenance.PACKAGE.rglob("*.py"))
    assert len(modules) > 50
    for path in modules:
        parts = path.relative_to(provenance.PACKAGE.parent).with_suffix("").parts
        name = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
        sources, imported = provenance._sources_and_imports(name)
        assert sources[0] == path and imported >= parsed_imports(path), name
        assert imported == parsed_imports(path), name


def test_both_forms_of_imports_are_found(package):
    (package / "odd.py").write_text(
        '"""Odd."""\n\nimport os\nimport ptl.files.atomic\nfrom ptl.agent import skills as s\nfrom ptl import methods\n'
        "if True:\n    from ptl.errors import (  # a comment, with a comma\n        UserError,  # another (one\n    )\n"
        "def later():\n    from ptl.methods import load, _base\n"
    )
    expected = {"ptl.files.atomic", "ptl.agent.skills", "ptl.methods", "ptl.errors", "ptl.methods._base"}
    assert parsed_imports(package / "odd.py") == expected
    assert provenance._sources_and_imports("ptl.odd")[1] == expected


@pytest.fixture
def package(tmp_path, monkeypatch) -> Path:
    """A copy of the package's sources whose files a test may edit."""
    copy = tmp_path / "ptl"
    shutil.copytree(provenance.PACKAGE, copy, ignore=shutil.ignore_patterns("*.so", "*.c", "__pycache__"))
    monkeypatch.setattr(provenance, "PACKAGE", copy)
    monkeypatch.setattr(provenance, "ROOT", tmp_path)
    forget()
    yield copy
    forget()


BUILT_IN = methods.names()
ALL = {*BUILT_IN, "mine", "growth", "survey", "lives"}


def learning_digests(package: Path) -> dict[str, str]:
    """Digest of the jobs of every method, of a user's method derived from ptl, and of the other jobs."""
    forget()
    mine = package.parent / "mine.py"
    mine.write_text("from ptl.keys import Group\nfrom ptl.methods import ptl\n", encoding="utf-8")
    return {name: learning_code(name) for name in BUILT_IN} | {
        "mine": learning_code(str(mine)),
        "growth": learning_code(METHOD, "ptl.learning.growth"),
        "survey": sources_of("ptl.learning.survey"),
        "lives": learning_code(METHOD, "ptl.learning.lives"),
    }


def changed_by(package: Path, edited: str) -> set[str]:
    """Digests that a sentence added to a source changes."""
    before = learning_digests(package)
    add_sentence(package / edited)
    after = learning_digests(package)
    return {name for name in ALL if before[name] != after[name]}


def add_sentence(path: Path) -> None:
    path.write_text(path.read_text(encoding="utf-8") + "\n# A sentence.\n", encoding="utf-8")


def test_no_sentence_outside_the_rooms_of_learning_makes_anything_learn_again(package):
    before = learning_digests(package)
    rooms = ("world", "agent", "methods", "learning")
    outside = [path for path in package.rglob("*.py") if path.relative_to(package).parts[0] not in rooms]
    for path in outside:
        add_sentence(path)
    assert learning_digests(package) == before and {*before} == ALL
    names = {path.relative_to(package).as_posix() for path in outside}
    assert len(names) > 50 and {"config.py", "keys.py", "files/store.py", "jobs/learn.py"} < names


@pytest.mark.parametrize("name", BUILT_IN)
def test_a_method_counts_for_itself_and_those_derived_from_it(package, name):
    kinds = {other: methods.load(other) for other in BUILT_IN}
    changed = {other for other, kind in kinds.items() if issubclass(kind, kinds[name])}
    if METHOD in changed:
        changed |= {"growth", "lives", "mine"}
    assert changed_by(package, f"methods/{name}.py") == changed


@pytest.mark.parametrize(
    ("edited", "changed"),
    [
        ("agent/_kernel.pyx", ALL),
        ("agent/_kernel.pxd", ALL),
        ("agent/seeding.py", ALL),
        ("world/_graph.pyx", ALL),
        ("world/gridworld.py", ALL),
        ("learning/life.py", ALL - {"survey"}),
        ("methods/__init__.py", ALL - {"survey"}),
        ("methods/_base.py", ALL - {"survey"}),
        ("agent/_selection.pyx", ALL - {"no_transfer", "full_transfer", "survey"}),
        ("learning/growth.py", {"growth", "lives"}),
        ("learning/lives.py", {"lives"}),
        ("learning/_survey.pyx", {"survey"}),
        ("world/mazes.py", set()),
    ],
)
def test_learning_depends_on_what_it_uses(package, edited, changed):
    assert changed_by(package, edited) == changed


@pytest.mark.parametrize(
    ("edited", "depends", "apart"),
    [
        ("report/figures/maps.py", "ptl.report.figures.maps", "ptl.report.figures.growth"),
        ("report/templates/table.html", "ptl.report.metric_tables", "ptl.measures.statistics"),
    ],
)
def test_a_product_depends_on_its_own_files(package, edited, depends, apart):
    before = provenance.code_digest(depends), provenance.code_digest(apart)
    path = package / edited
    path.write_text(path.read_text() + "\n# edited\n")
    forget()
    assert provenance.code_digest(depends) != before[0]
    assert provenance.code_digest(apart) == before[1]


def test_present_build_is_accepted():
    provenance.check_build()


def test_stale_build_is_refused(package):
    (package / "agent/_kernel.pyx").write_text("# other sources\n")
    with pytest.raises(UserError, match=r"ptl\.agent\._kernel was built from other sources .* 'make build'"):
        provenance.check_build()


@pytest.mark.parametrize("starts", [["-m", "ptl", "--help"], ["-c", "import ptl.cli.forks"]], ids=["ptl", "Snakefile"])
def test_a_checkout_that_is_not_built_says_so_in_one_line(package, starts):
    done = subprocess.run([sys.executable, *starts], cwd=package.parent, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (1, "error: ptl is not built; run 'make build'\n")


def test_the_workflow_of_another_checkout_is_refused(tmp_path):
    (tmp_path / "ptl").mkdir()
    (tmp_path / "ptl/__init__.py").touch()
    with pytest.raises(UserError, match=r"runs with the code in .* run 'make build' there"):
        check_checkout(tmp_path / "workflow")
    check_checkout(ROOT / "workflow")
