"""Read ordinary files only: a pipe, a device or a folder in place of a file is refused without waiting for it."""

from __future__ import annotations

import hashlib
import os
import stat
from collections.abc import Iterator
from pathlib import Path

from ptl.errors import UserError

BLOCK = 2**20
MAX_BYTES = 2**31
"""Maximum size in bytes of a file that is read whole."""


class NotReadable(UserError):
    """The path is not an ordinary file or cannot be read; ``reason`` describes this in a few words.

    Attributes
    ----------
    reason : str
    missing : bool
        Whether the path does not exist.
    """

    def __init__(self, path: str | os.PathLike[str], reason: str, *, missing: bool = False) -> None:
        super().__init__(f"{path}: cannot be read ({reason})")
        self.reason, self.missing = reason, missing


def kind_of(mode: int) -> str:
    """Return a description of a path that is not an ordinary file; empty for an ordinary file."""
    if stat.S_ISREG(mode):
        return ""
    kinds = {
        stat.S_ISDIR: "a folder", stat.S_ISFIFO: "a pipe", stat.S_ISSOCK: "a socket", stat.S_ISLNK: "a symbolic link",
    }  # fmt: skip
    return next((name for test, name in kinds.items() if test(mode)), "a device")


def refuse_other(*paths: str | os.PathLike[str]) -> None:
    """Refuse to write to an existing path that is not an ordinary file: a pipe would wait for a reader.

    Raises
    ------
    UserError
        Naming the first such path and its type.
    """
    for path in paths:
        if os.path.lexists(path) and (other := kind_of(os.lstat(path).st_mode)):
            raise UserError(f"{path}: is {other}, and no file is written in its place; name another file or remove it")


def read_bytes(path: str | os.PathLike[str], limit: int) -> bytes:
    """Return the content of an ordinary file.

    Raises
    ------
    NotReadable
        If it does not exist, is not an ordinary file, or has more than ``limit`` bytes.
    """
    return b"".join(_blocks(path, limit))


def sha256(path: str | os.PathLike[str]) -> str:
    """Return the hex sha256 of an ordinary file; errors as in `read_bytes`."""
    digest = hashlib.sha256()
    for block in _blocks(path, None):
        digest.update(block)
    return digest.hexdigest()


def _blocks(path: str | os.PathLike[str], limit: int | None) -> Iterator[bytes]:
    try:
        # O_NONBLOCK: opening a pipe would wait for a writer. Looked at before, because opening a device can act on it.
        if other := kind_of(Path(path).stat().st_mode):
            raise NotReadable(path, f"{other}, not a file")
        descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
        with os.fdopen(descriptor, "rb", buffering=0) as file:
            status = os.fstat(descriptor)
            if other := kind_of(status.st_mode):
                raise NotReadable(path, f"{other}, not a file")
            if limit is not None and status.st_size > limit:
                raise NotReadable(path, f"more than {limit} bytes")
            rest = status.st_size  # no more, though some files of the system never end
            while rest and (block := file.read(min(rest, BLOCK))):
                rest -= len(block)
                yield block
    except (OSError, ValueError) as error:  # a ValueError: a null byte in the path
        reason = getattr(error, "strerror", None) or str(error)
        raise NotReadable(path, reason, missing=isinstance(error, FileNotFoundError)) from error


def below(folder: Path) -> Iterator[Path]:
    """Yield everything below a folder that is no folder, behind symbolic links too, each folder once."""
    seen = set()
    for place, folders, files in os.walk(folder, followlinks=True):
        kept = []
        for name in folders:
            status = os.stat(os.path.join(place, name))  # noqa: PTH116, PTH118 - a walk of many files
            if (status.st_dev, status.st_ino) not in seen:
                seen.add((status.st_dev, status.st_ino))
                kept.append(name)
        folders[:] = kept
        yield from (Path(place, name) for name in files)
