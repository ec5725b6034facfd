"""Source digests, for reruns: exactly the sources that a module uses.

The workflow puts these digests into its rules' parameters, so that editing a plot reruns that plot and nothing else,
while editing the kernel reruns all learning.
"""

from __future__ import annotations

import hashlib
import re
from functools import cache
from importlib import import_module
from pathlib import Path

from ptl.errors import UserError
from ptl.extensions import EXTENSIONS

PACKAGE = Path(__file__).parent.parent
ROOT = PACKAGE.parent
LEARNING = ("ptl.world", "ptl.agent", "ptl.methods", "ptl.learning", "studies")
"""Subpackages whose sources determine what is learned; the others write, check, measure or describe it."""

FOLDERS = {"ptl.report.templating": "report/templates", "ptl.report.explorer.page": "report/explorer/web"}
"""Folders whose files a module reads; they count as its sources."""

IMPORT = re.compile(
    r"^[ \t]*(?:from ((?:ptl|studies)(?:\.\w+)*) import (\([^)]*\)|.*)|import ((?:ptl|studies)(?:\.\w+)*))",
    re.MULTILINE,
)
"""Our imports, of which there are two forms. Every job looks for them, and parsing takes ten times as long."""


@cache
def code_digest(*modules: str, within: tuple[str, ...] = ()) -> str:
    """Return the sha256 (first 16 hex digits) of the sources of modules and of all that they import from this package.

    Sources are read once in a process.

    Parameters
    ----------
    modules : str
        Names such as ``"ptl.methods.ptl"``.
    within : tuple of str
        Packages that count, all if empty.
    """
    digest = hashlib.sha256()
    for path in sorted(_closure(modules, within)):
        digest.update(path.relative_to(ROOT).as_posix().encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


def _closure(modules: tuple[str, ...], within: tuple[str, ...]) -> set[Path]:
    paths: set[Path] = set()
    waiting = [name for name in modules if counts(name, within)]
    seen = {*waiting}
    while waiting:
        sources, imported = _sources_and_imports(waiting.pop())
        paths.update(sources)
        new = {name for name in imported - seen if counts(name, within)}
        seen |= new
        waiting.extend(new)
    return paths


def counts(module: str, within: tuple[str, ...]) -> bool:
    """Return whether a module is in one of some packages; without any, all modules are."""
    return not within or f"{module}.".startswith(tuple(f"{package}." for package in within))


@cache
def _sources_and_imports(module: str) -> tuple[tuple[Path, ...], frozenset[str]]:
    if module in EXTENSIONS:
        return tuple(PACKAGE / name for name in EXTENSIONS[module]), frozenset()
    path = ROOT.joinpath(*module.split("."))
    # An installed package has a folder config/ of the workflow beside config.py.
    path = path.with_suffix(".py") if path.with_suffix(".py").is_file() else path / "__init__.py"
    imported = imports_of(path.read_text(encoding="utf-8"))
    folder = FOLDERS.get(module)
    files = sorted(file for file in (PACKAGE / folder).iterdir() if file.is_file()) if folder else []
    return (path, *files), frozenset(imported)


def imports_of(source: str) -> set[str]:
    """Return the modules of this package that a source imports."""
    imported: set[str] = set()
    for origin, listed, whole in IMPORT.findall(source):
        if whole:
            imported.add(whole)
        for alias in re.findall(r"(\w+)(?: as \w+)?", re.sub(r"#.*", "", listed)):
            name = f"{origin}.{alias}"
            imported.add(name if _is_module(name) else origin)
    return imported


def _is_module(name: str) -> bool:
    path = ROOT.joinpath(*name.split("."))
    return name in EXTENSIONS or path.with_suffix(".py").is_file() or (path / "__init__.py").is_file()


def check_build() -> None:
    """Refuse compiled modules that were built from other sources than the present ones.

    Raises
    ------
    UserError
        Naming the module and the command that rebuilds it.
    """
    for module, sources in EXTENSIONS.items():
        built = import_module(module).SOURCE_DIGEST
        present = hashlib.sha256(b"".join((PACKAGE / name).read_bytes() for name in sources)).hexdigest()
        if built != present:
            raise UserError(f"{module} was built from other sources than {', '.join(sources)}; run 'make build'")
