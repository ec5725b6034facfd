"""Methods as a run's configuration names them: parameters of their own, digests of their sources, and their records."""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import msgspec

from ptl import methods
from ptl.errors import UserError
from ptl.files.provenance import PACKAGE, code_digest, imports_of
from ptl.keys import ConfigurationError, Group, shortened
from ptl.methods import BaseMethod

RECORD = "method"
"""Key under which a learning file's ``parameters`` say where a method from elsewhere comes from."""


def configured(reference: str, values: Mapping[str, Any]) -> type[BaseMethod]:
    """Return the class of a method with parameters of its own.

    A method declares such parameters by a class attribute ``own``: an instance of a `ptl.keys.Group`, whose values are
    the defaults.

    Parameters
    ----------
    reference : str
        See `ptl.methods`.
    values : mapping
        Parameters that shall differ from their defaults.

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
    """Return the parameters of a method's own, which a job gets as JSON on its command line."""
    try:
        return msgspec.json.decode(text, type=dict[str, Any])
    except msgspec.DecodeError as error:
        raise UserError(
            f'method parameters: {shortened(text)} is no JSON object ({error}); give one such as {{"weight": 0.1}}'
        ) from None


def record(reference: str, kind: type[BaseMethod]) -> dict[str, Any]:
    """Return what a learning file's ``parameters`` say on a method from elsewhere; nothing on a built-in one."""
    own = getattr(kind, "own", None)
    if reference in methods.names():
        return {}
    return {RECORD: {"reference": reference, "parameters": own.to_dict() if isinstance(own, Group) else {}}}


def learning_code(reference: str, *modules: str) -> str:
    """Return a digest of the sources that a life under a method depends on.

    Of a method from elsewhere these are the file that defines it and what that file imports from this package.

    Parameters
    ----------
    modules : str
        Further modules of this package.
    """
    modules = ("ptl.learning.life", *modules)
    if reference in methods.names():
        return code_digest(*modules, f"ptl.methods.{reference}")
    if reference.endswith(".py"):
        path = Path(reference)
    else:
        module = sys.modules[methods.load(reference).__module__]
        path = Path(str(module.__file__))
        if path.is_relative_to(PACKAGE):
            return code_digest(*modules, module.__name__)
    source = path.read_bytes()
    shared = code_digest(*modules, *sorted(imports_of(source.decode("utf-8"))))
    return hashlib.sha256(source + shared.encode()).hexdigest()[:16]
