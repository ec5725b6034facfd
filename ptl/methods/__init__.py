"""The compared methods, one file each, and the loading of users' methods.

A method is named by a reference:

``ptl``                        a file of this folder,
``methods/my_agent.py``        a file anywhere,
``my_package.agents:MyAgent``  a class that Python can import,

or, in Python, by the class itself or a function that makes an instance. A file defines a class ``Method``, and
Python looks for what it imports in its folder too, and in the current one as for a class. The identifier in files,
tables and random streams is the file's name without ``.py``; a class with another name and a function say it in an
attribute ``name``.
"""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import cache
from importlib import import_module
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from traceback import extract_tb
from types import ModuleType
from typing import TypeAlias

import msgspec
import numpy as np

from ptl.config import Name, Parameters
from ptl.errors import UserError
from ptl.keys import allowed
from ptl.methods._base import BaseMethod
from ptl.world.gridworld import GridWorld

Maker: TypeAlias = Callable[[GridWorld, Parameters, np.random.Generator], BaseMethod]
"""A subclass of `BaseMethod`, or a function with the same arguments."""


def names() -> list[str]:
    """Return the identifiers of the built-in methods, in alphabetical order."""
    return list(_names())


@cache
def _names() -> tuple[str, ...]:
    return tuple(sorted(path.stem for path in Path(__file__).parent.glob("*.py") if not path.stem.startswith("_")))


def load(reference: str) -> type[BaseMethod]:
    """Return the class of a method.

    Raises
    ------
    UserError
        One line: there is no such method, file or class, it cannot be imported, or it is no subclass of `BaseMethod`.
    """
    if reference.endswith(".py"):
        if not Path(reference).is_file():
            raise UserError(f"method {reference}: no such file; check the path")
        _look_in(Path.cwd(), Path(reference).resolve().parent)
        module, attribute = _imported(reference, lambda: _module_from_file(Path(reference))), "Method"
    elif ":" in reference:
        place, attribute = reference.rsplit(":", 1)
        _look_in(Path.cwd())
        module = _imported(reference, lambda: import_module(place))
    elif reference in names():
        module, attribute = import_module(f"ptl.methods.{reference}"), "Method"
    else:
        raise UserError(
            f"unknown method {reference!r}; known are {', '.join(names())}, or give a file that ends in .py or"
            " package.module:Class"
        )
    kind = getattr(module, attribute, None)
    if not (isinstance(kind, type) and issubclass(kind, BaseMethod)):
        raise UserError(f"method {reference}: defines no class {attribute} derived from ptl.methods.BaseMethod")
    return kind


def identifier(method: str | Maker) -> str:
    """Return the identifier of a method in files, tables and random streams.

    Raises
    ------
    UserError
        If it is missing, has other characters than lower-case letters, digits and _, or is that of a built-in method.
    """
    name: str | None
    built_in = False
    if isinstance(method, str) and method.endswith(".py"):
        name = Path(method).stem
    elif isinstance(method, str) and ":" not in method:
        name, built_in = method, True
    else:
        made = load(method) if isinstance(method, str) else method
        unnamed = isinstance(made, type) and made.__name__ == "Method"
        name = made.__module__.rpartition(".")[2] if unnamed else getattr(made, "name", None)
        built_in = made.__module__ == f"ptl.methods.{name}"
    try:
        checked: str = msgspec.convert(name, Name)
    except msgspec.ValidationError:
        problem = "has no identifier" if name is None else f"the identifier {name!r} is not allowed"
        raise UserError(
            f"method {shown(method)}: {problem}; give {allowed(Name)} as the file's name or the attribute name"
        ) from None
    if checked in names() and not built_in:
        raise UserError(f"method {shown(method)}: {name} is a built-in method; give the file or the class another name")
    return checked


def by_identifier(references: Iterable[str]) -> dict[str, str]:
    """Return the references by identifier, in the order given.

    Raises
    ------
    UserError
        If two references have one identifier.
    """
    by_name: dict[str, str] = {}
    for reference in references:
        name = identifier(reference)
        if name in by_name:
            raise UserError(f"methods {by_name[name]} and {reference} are both called {name}; rename one of them")
        by_name[name] = reference
    return by_name


def source_file(reference: str) -> Path:
    """Return the file that defines a method, for digests."""
    return Path(reference) if reference.endswith(".py") else Path(str(sys.modules[load(reference).__module__].__file__))


def fault(error: BaseException, method: str | Maker) -> UserError:
    """Return an error in a method's code as one line that names the place."""
    if isinstance(error, SyntaxError):
        place = f"{error.filename}, line {error.lineno}"
    else:
        frame = [frame for frame in extract_tb(error.__traceback__) if frame.filename.endswith(".py")][-1]
        place = f"{frame.filename}, line {frame.lineno}"
    try:
        message = error.msg if isinstance(error, SyntaxError) else str(error)
    except Exception:  # the text of an error is the user's code too
        message = "an error without a text"
    return UserError(f"method {shown(method)}: {type(error).__name__}: {message} ({place})")


@contextmanager
def reporting_errors_of(method: str | Maker) -> Iterator[None]:
    """Report any failure of a user's method in this block as a one-line `UserError` that names the method."""
    try:
        yield
    except UserError:
        raise
    except (Exception, SystemExit) as error:
        if method in names():
            raise
        raise fault(error, method) from error


def shown(method: str | Maker) -> str:
    """Return how messages name a method."""
    return method if isinstance(method, str) else getattr(method, "__qualname__", repr(method))


def _look_in(*folders: Path) -> None:
    """Let Python look for modules in these folders, after all others."""
    sys.path.extend(str(folder) for folder in folders if str(folder) not in sys.path)


def _imported(reference: str, load_module: Callable[[], ModuleType]) -> ModuleType:
    try:
        return load_module()
    except ImportError as error:
        raise UserError(f"method {reference}: cannot be imported ({error})") from error
    except (Exception, SystemExit) as error:  # whatever the user's file does
        raise fault(error, reference) from error


def _module_from_file(path: Path) -> ModuleType:
    # Entered in sys.modules, which dataclasses and msgspec look up, under a name that shadows no other module.
    path = path.resolve()
    name = f"method_{hashlib.sha256(bytes(path)).hexdigest()[:16]}.{path.stem}"
    if name not in sys.modules:
        description = spec_from_file_location(name, path)
        assert description is not None and description.loader is not None  # the path ends in .py
        module = module_from_spec(description)
        sys.modules[name] = module
        try:
            description.loader.exec_module(module)
        except BaseException:
            del sys.modules[name]
            raise
    return sys.modules[name]
