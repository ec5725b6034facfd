"""Writing products so that a name either holds a whole file or nothing new."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from ptl.errors import UserError

if TYPE_CHECKING:
    import pandas as pd

SIGNIFICANT_DIGITS = 6
"""Digits of every number in a CSV file: enough for a reader, too few to show another processor's last bit."""


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
        handle, name = tempfile.mkstemp(prefix=f".{path.stem}.", suffix=path.suffix, dir=path.parent)
        os.close(handle)
        temporary = Path(name)
        yield temporary
        temporary.chmod(0o666 & ~_umask())
        temporary.replace(path)
    except OSError as error:
        reason = error.strerror or str(error)
        raise UserError(f"{path}: cannot be written ({reason}); free some space or choose a writable folder") from error
    finally:
        if temporary is not None:
            temporary.unlink(missing_ok=True)


def _umask() -> int:
    current = os.umask(0)
    os.umask(current)
    return current


def write_text(path: str | os.PathLike[str], text: str) -> None:
    """Write UTF-8 text with Unix line ends, whole or not at all."""
    with atomic_path(path) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="\n")


def write_csv(frame: pd.DataFrame, path: str | os.PathLike[str]) -> None:
    """Write a data frame as CSV, numbers with six significant digits, missing values as empty cells."""
    with atomic_path(path) as temporary:
        frame.to_csv(temporary, index=False, float_format=format_number, lineterminator="\n")


def format_number(value: float) -> str:
    """A number with six significant digits; large ones without an exponent, which people misread."""
    text = f"{value:.{SIGNIFICANT_DIGITS}g}"
    return f"{float(text):.0f}" if "e+" in text else text
