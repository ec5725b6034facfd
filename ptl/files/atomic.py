"""Atomic writing: a path always has either the complete new file or the previous one."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ptl.errors import UserError
from ptl.files.regular import refuse_other

UNFINISHED = ".unfinished-"
"""Prefix of the name of a file while it is being written."""


@contextmanager
def atomic_path(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield a temporary path beside ``path``; rename it to ``path`` if the block succeeds, else remove it.

    Parent folders are made. The temporary name keeps the suffix, because some writers choose their format by it.

    Raises
    ------
    UserError
        When the folder cannot be written, the disk is full, or the path is not an ordinary file.
    """
    path = Path(path)
    temporary = None
    try:
        refuse_other(path)
        path.parent.mkdir(parents=True, exist_ok=True)
        unfinished = path.with_name(f"{UNFINISHED}{os.urandom(6).hex()}-{path.name}")
        unfinished.touch(exist_ok=False)
        temporary = unfinished
        yield temporary
        temporary.replace(path)
    except OSError as error:
        reason = error.strerror or str(error)
        raise UserError(f"{path}: cannot be written ({reason}); free some space or choose a writable folder") from error
    finally:
        if temporary is not None:
            temporary.unlink(missing_ok=True)


def write_text(path: str | os.PathLike[str], text: str) -> None:
    """Write UTF-8 text with Unix line ends, atomically."""
    with atomic_path(path) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="\n")


def remove_unfinished(*folders: str | os.PathLike[str]) -> None:
    """Remove incomplete files of killed jobs below these folders."""
    for folder in folders:
        for path in Path(folder).rglob(f"{UNFINISHED}*"):
            path.unlink(missing_ok=True)
