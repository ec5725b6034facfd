"""Writing products so that a name either holds a whole file or nothing new."""

from __future__ import annotations

import hashlib
import io
import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ptl.errors import UserError
from ptl.remedies import make_again, rebuild_command

if TYPE_CHECKING:
    import pandas as pd

SIGNIFICANT_DIGITS = 6
"""Digits of every number in a CSV file: enough for a reader, too few to show another processor's last bit."""

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
    """Paths with ranges of numbers written out: ``seed_[0-29].h5`` stands for seed_000.h5 to seed_029.h5.

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
    """Write UTF-8 text with Unix line ends, whole or not at all."""
    with atomic_path(path) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="\n")


def remove_unfinished(*folders: str | os.PathLike[str]) -> None:
    """Remove what killed jobs left half-written below these folders."""
    for folder in folders:
        for path in Path(folder).rglob(f"{UNFINISHED}*"):
            path.unlink(missing_ok=True)


def write_csv(frame: pd.DataFrame, path: str | os.PathLike[str], *, sealed: bool = False) -> None:
    """Write a data frame as CSV, numbers with six significant digits, missing values as empty cells.

    ``sealed`` puts its checksum beside it, as ``<path>.sha256``: for tables that other jobs read with `read_csv`.
    """
    text = frame.to_csv(index=False, float_format=format_number, lineterminator="\n")
    write_text(path, text)
    if sealed:
        write_text(seal_of(path), f"{_sha256(text.encode())}  {Path(path).name}\n")


def read_csv(path: str | os.PathLike[str], **options: Any) -> pd.DataFrame:
    """Read a CSV file with pandas (and its ``options``), after checking it against its seal if it has one.

    Raises
    ------
    UserError
        When it is missing, differs from its seal or is not a table.
    """
    import pandas as pd

    try:
        content = Path(path).read_bytes()
    except OSError as error:
        raise UserError(
            f"{path}: cannot be read as CSV ({error.strerror}); run '{rebuild_command(path)}' to make it"
        ) from error
    if broken_seal(path, content):
        raise UserError(f"{path}: damaged (differs from its checksum in {seal_of(path).name}); {make_again(path)}")
    try:
        return pd.read_csv(io.BytesIO(content), **options)
    except ValueError as error:  # pandas' own errors are ValueErrors
        raise UserError(f"{path}: cannot be read as CSV ({error}); {make_again(path)}") from error


def seal_of(path: str | os.PathLike[str]) -> Path:
    """Where the checksum of a sealed file lies."""
    return Path(f"{path}.sha256")


def broken_seal(path: str | os.PathLike[str], content: bytes) -> bool:
    """Whether a file with this content has a seal that says otherwise."""
    seal = seal_of(path)
    return seal.is_file() and seal.read_bytes() != f"{_sha256(content)}  {Path(path).name}\n".encode()


def _sha256(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def format_number(value: float) -> str:
    """A number with six significant digits; large ones without an exponent, which people misread."""
    text = f"{value:.{SIGNIFICANT_DIGITS}g}"
    return f"{float(text):.0f}" if "e+" in text else text
