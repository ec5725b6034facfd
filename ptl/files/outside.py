"""Methods as named in a run's configuration: their own parameters, and digests of their sources."""

from __future__ import annotations

import ast
import hashlib
import os
import sysconfig
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import msgspec

from ptl import methods
from ptl.errors import UserError
from ptl.files.provenance import LEARNING, code_digest, counts, imports_of
from ptl.keys import ConfigurationError, Group, shortened
from ptl.methods import BaseMethod


def configured(reference: str, values: Mapping[str, Any]) -> type[BaseMethod]:
    """Return the class of a method with values for its own parameters.

    A method declares such parameters by a class attribute ``own``: an instance of a `ptl.keys.Group`, whose values are
    the defaults.

    Parameters
    ----------
    reference : str
        See `ptl.methods`.
    values : mapping
        Parameters that differ from their defaults.

    Raises
    ------
    UserError
        If there is no such method.
    ConfigurationError
        If it has no such parameter, or a value is not allowed.
    """
    kind = methods.load(reference)
    if not values:
        return kind
    key = f"method_parameters.{methods.identifier(reference)}"
    own = getattr(kind, "own", None)
    if not isinstance(own, Group):
        raise ConfigurationError(key, f"method {reference} has no parameters of its own; leave the key out")
    try:
        chosen = type(own).from_dict({**own.to_dict(), **values})
    except ConfigurationError as error:
        raise ConfigurationError(f"{key}.{error.key}", error.problem) from None
    return type(kind.__name__, (kind,), {"own": chosen, "__module__": kind.__module__, "__doc__": kind.__doc__})


def values_of(text: str) -> dict[str, Any]:
    """Return the method-specific parameters, which a job gets as JSON on its command line."""
    try:
        return msgspec.json.decode(text, type=dict[str, Any])
    except msgspec.DecodeError as error:
        raise UserError(
            f'method parameters: {shortened(text)} is no JSON object ({error}); give one such as {{"weight": 0.1}}'
        ) from None


def sources_of(*modules: str) -> str:
    """Return a digest of the sources of learning (`LEARNING`) that modules depend on."""
    return code_digest(*modules, within=LEARNING)


def learning_code(reference: str, *modules: str) -> str:
    """Return a digest of the sources that a life under a method depends on.

    For a user's method these are its `local_sources` and their imports from this package.

    Parameters
    ----------
    modules : str
        Further modules of this package.
    """
    digest = hashlib.sha256()
    used = {"ptl.learning.life", *modules}
    module = f"ptl.methods.{reference}" if reference in methods.names() else reference.partition(":")[0]
    if not reference.endswith(".py") and counts(module, LEARNING):
        used.add(module)
    else:
        root, paths = local_sources(reference)
        for path in paths:
            source = path.read_bytes()
            digest.update(os.path.relpath(path, root).encode() + b"\0" + source + b"\0")
            used |= imports_of(source.decode("utf-8", "replace"))
    digest.update(sources_of(*sorted(used)).encode())
    return digest.hexdigest()[:16]


def local_sources(reference: str) -> tuple[Path, list[Path]]:
    """Return the folder of a user's method, and its file with all its imports from that folder.

    The current folder counts as well, and of a method that is installed, its package only. A file is read and not run.

    Raises
    ------
    UserError
        If there is no such file, or a file cannot be parsed.
    """
    first = methods.source_file(reference).resolve()
    if not first.is_file():
        raise UserError(f"method {reference}: no such file; check the path")
    levels, module = 0, ""
    if not reference.endswith(".py"):
        module = methods.load(reference).__module__
        levels = module.count(".") + (first.name == "__init__.py")
    root = first.parents[levels]
    installed = root in {Path(sysconfig.get_path(name)).resolve() for name in ("stdlib", "purelib", "platlib")}
    files = {first, *(_files_of(module, root) if module else ())}
    waiting = [*files]
    while waiting:
        for name in _imports(waiting.pop(), root, reference):
            package, _, _ = name.partition(".")
            own = package == module.partition(".")[0]
            if package and (own or not (installed or package == "ptl")):
                new = set(_files_of(name, root)) - files
                files |= new
                waiting += new
    return root, sorted(files)


def _imports(path: Path, root: Path, reference: str) -> Iterator[str]:
    """Yield the full names of what a file imports; whether a last part is a module or in one is not known here."""
    try:
        tree = ast.parse(path.read_bytes(), path)
    except (SyntaxError, ValueError) as error:
        raise methods.fault(error, reference) from error
    package = Path(os.path.relpath(path.parent, root)).parts
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            above = package[: len(package) + 1 - node.level] if node.level else ()
            within = ".".join([*above, *([node.module] if node.module else [])])
            yield from (f"{within}.{alias.name}" for alias in node.names)


def _files_of(name: str, root: Path) -> Iterator[Path]:
    """Yield the files that an import of a module reads, the packages around it included."""
    parts = name.split(".")
    for folder in (root, Path.cwd()):
        for last in range(1, len(parts) + 1):
            place = folder.joinpath(*parts[:last])
            yield from (file for file in (place.with_suffix(".py"), place / "__init__.py") if file.is_file())
