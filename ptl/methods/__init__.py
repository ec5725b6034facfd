"""The methods that are compared, one file each.

A method is a file of this folder that defines a class ``Method``; its identifier is the name of the file. Adding a
file and naming it in the configuration is all it takes to bring a new method into every table and figure.
"""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

from ptl.errors import UserError
from ptl.methods._base import BaseMethod


def names() -> list[str]:
    """Identifiers of all methods, in alphabetical order."""
    return sorted(path.stem for path in Path(__file__).parent.glob("*.py") if not path.stem.startswith("_"))


def load(identifier: str) -> type[BaseMethod]:
    """The class of a method.

    Raises
    ------
    UserError
        If no method has this identifier.
    """
    if identifier not in names():
        raise UserError(f"configuration key methods: unknown method {identifier!r}; known are {', '.join(names())}")
    return import_module(f"ptl.methods.{identifier}").Method
