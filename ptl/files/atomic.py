"""Atomic writing: a name holds a complete file or the one that was there before."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from ptl.errors import UserError

UNFINISHED = ".unfinished-"
"""Begins the name under which a file is written until it is whole."""


@contextmanager
def atomic_path(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield a temporary path beside ``path``; rename it to ``path`` if the block succeeds, else remove it.

    Parent folders are made. The temporary name keeps the suffix, because some writers choose their format by it.

    Raises
    ------
    UserError
        When the folder cannot be written or the disk is full.
    """
    path = Path(path)
    temporary = None
    try:
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


def expand_numbers(paths: Iterable[str | os.PathLike[str]]) -> list[Path]:
    """Write out ranges of numbers in paths: ``seed_[0-29].h5`` stands for seed_000.h5 to seed_029.h5.

    A command line cannot hold the names of thousands of files.
    """
    found = []
    for path in map(str, paths):
        before, _, rest = path.rpartition("[")
        numbers, closed, after = rest.partition("]")
        first, _, last = numbers.partition("-")
        if closed and first.isdecimal() and last.isdecimal():
            found += [Path(f"{before}{number:03d}{after}") for number in range(int(first), int(last) + 1)]
        else:
            found.append(Path(path))
    return found


def write_text(path: str | os.PathLike[str], text: str) -> None:
    """Write UTF-8 text with Unix line ends, atomically."""
    with atomic_path(path) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="\n")


def remove_unfinished(*folders: str | os.PathLike[str]) -> None:
    """Remove incomplete files of killed jobs below these folders."""
    for folder in folders:
        for path in Path(folder).rglob(f"{UNFINISHED}*"):
            path.unlink(missing_ok=True)
