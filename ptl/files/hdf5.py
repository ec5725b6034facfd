"""HDF5 files with an origin and a checksum: written atomically, checked whenever they are opened.

Equal runs give equal bytes: nothing in a file depends on when or where it was written. The root attribute ``format``
says what a file is, and ``versions`` which packages made it.

After the end of the HDF5 data, where HDF5 readers ignore it, a line holds the sha256 of all bytes before it. It is
checked before the HDF5 library opens a file, because that library can crash on damage or never return.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py
import numpy as np

import ptl
from ptl.errors import UserError
from ptl.files.atomic import atomic_path
from ptl.files.remedies import make_again, rebuild_command

SEAL = b"\nsha256 of all bytes before this line: "
"""Begins the line after the end of the HDF5 data."""


@contextmanager
def new_file(path: str | os.PathLike[str], kind: str, origin: Mapping[str, Any]) -> Iterator[h5py.File]:
    """Write a file of a kind; the block fills it.

    Parameters
    ----------
    kind : str
        Value of the root attribute ``format``.
    origin : mapping
        Other root attributes: what is needed to make the file again. Dictionaries and lists are written as JSON.
    """
    versions = {"ptl": ptl.__version__, "numpy": np.__version__, "h5py": h5py.__version__}
    # Composed in memory, because the HDF5 library crashes when the disk is full.
    with h5py.File("in memory", "w", driver="core", backing_store=False, libver="v110") as file:
        file.attrs["format"] = kind
        for name, value in {**origin, "versions": versions}.items():
            file.attrs[name] = json.dumps(value, sort_keys=True) if isinstance(value, dict | list) else value
        yield file
        file.flush()
        image = file.id.get_file_image()
    with atomic_path(path) as temporary:
        temporary.write_bytes(sealed(image))


def sealed(image: bytes) -> bytes:
    """Return the bytes of an HDF5 file followed by the line with their checksum."""
    return image + SEAL + hashlib.sha256(image).hexdigest().encode() + b"\n"


def _seal_fault(path: Path) -> str | None:
    """Return how a file disagrees with its checksum line; None if it agrees."""
    length = len(sealed(b""))
    with path.open("rb") as file:
        rest = file.seek(0, os.SEEK_END) - length
        if rest < 0:
            return "too short"
        digest = hashlib.sha256()
        file.seek(0)
        while rest:
            block = file.read(min(rest, 2**20))
            digest.update(block)
            rest -= len(block)
        line = file.read()
    if not line.startswith(SEAL):
        return "without the checksum at its end"
    return None if line == SEAL + digest.hexdigest().encode() + b"\n" else "its bytes do not match its checksum"


@contextmanager
def open_file(path: str | os.PathLike[str], *kinds: str) -> Iterator[h5py.File]:
    """Open a file of one of several kinds for reading.

    Raises
    ------
    UserError
        If it is missing, damaged or of another kind; the line ends with the command that makes it again.
    """
    if not Path(path).is_file():
        raise UserError(f"{path}: no such file; run '{rebuild_command(path)}' to make it")
    try:
        if fault := _seal_fault(Path(path)):
            raise UserError(f"{path}: damaged or not an HDF5 file of ours ({fault}); {make_again(path)}")
        file = h5py.File(path, "r")
    except OSError as error:
        raise UserError(f"{path}: damaged or not an HDF5 file ({_first_line(error)}); {make_again(path)}") from error
    with file:
        try:
            found = file.attrs.get("format")
        except Exception as error:  # HDF5 reports damage by exceptions of many types
            raise UserError(f"{path}: damaged ({_first_line(error)}); {make_again(path)}") from error
        if found not in kinds:
            raise UserError(f"{path}: is not a {_any_of(kinds)} file (format {found!r}); {make_again(path)}")
        yield file


def _any_of(kinds: Collection[str]) -> str:
    return " or ".join(kinds) if len(kinds) <= 2 else "result"


def _first_line(error: Exception) -> str:
    return (str(error) or type(error).__name__).splitlines()[0]
