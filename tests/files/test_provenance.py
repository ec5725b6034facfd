"""The digests name exactly the sources that a module uses."""

from __future__ import annotations

import ast
import shutil
from pathlib import Path

import pytest
from projects import ROOT

from ptl.errors import UserError
from ptl.files import provenance
from ptl.files.checkout import check_checkout
from ptl.files.outside import learning_code


def forget() -> None:
    """Make the next digest read the sources again."""
    provenance.code_digest.cache_clear()
    provenance._sources_and_imports.cache_clear()


def parsed_imports(path: Path) -> set[str]:
    """What a file imports from this package, by Python's own parser."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.split(".")[0] == "ptl":
            names = [f"{node.module}.{alias.name}" for alias in node.names]
            found |= {name if provenance._is_module(name) else node.module for name in names}
        elif isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names if alias.name.split(".")[0] == "ptl"}
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
    forget()
    yield copy
    forget()


@pytest.mark.parametrize(
    ("edited", "learning_changes"),
    [
        ("agent/_kernel.pyx", True),
        ("agent/_kernel.pxd", True),
        ("agent/_selection.pyx", True),
        ("world/_graph.pyx", True),
        ("agent/skills.py", True),
        ("agent/subgoals.py", True),
        ("methods/ptl.py", True),
        ("methods/__init__.py", True),
        ("world/mazes.py", False),
        ("errors.py", False),
        ("keys.py", False),
        ("config.py", False),
        ("text.py", False),
        ("files/results.py", False),
        ("files/configuration.py", False),
        ("methods/policy_reuse.py", False),
        ("report/figures/maps.py", False),
        ("report/figures/style.py", False),
        ("report/metric_tables.py", False),
        ("study/statistics.py", False),
        ("learning/_survey.pyx", False),
    ],
)
def test_only_what_learning_uses_changes_its_digest(package, tmp_path, edited, learning_changes):
    mine = tmp_path / "mine.py"
    mine.write_text("from ptl.keys import Group\nfrom ptl.methods import ptl\n")
    before = [learning_code("ptl"), learning_code(str(mine))]
    path = package / edited
    path.write_text(path.read_text() + "\n# edited\n")
    forget()
    after = [learning_code("ptl"), learning_code(str(mine))]
    assert [one != other for one, other in zip(before, after, strict=True)] == [learning_changes] * 2


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


def test_the_workflow_of_another_checkout_is_refused(tmp_path):
    (tmp_path / "ptl").mkdir()
    (tmp_path / "ptl/__init__.py").touch()
    with pytest.raises(UserError, match=r"runs with the code in .* run 'make build' there"):
        check_checkout(tmp_path / "workflow")
    check_checkout(ROOT / "workflow")
