"""Tables as CSV: six significant digits, and a checksum beside those that other jobs read."""

from __future__ import annotations

import hashlib
import io
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ptl.errors import UserError
from ptl.files import regular
from ptl.files.atomic import write_text
from ptl.files.remedies import make, make_again

if TYPE_CHECKING:
    import pandas as pd

SIGNIFICANT_DIGITS = 6
"""Digits of every number in a CSV file: enough for a reader, too few to show another processor's last bit."""


LONGEST_SEAL = 1000


def write_csv(frame: pd.DataFrame, path: str | os.PathLike[str], *, sealed: bool = False) -> None:
    """Write a data frame as CSV, numbers with six significant digits, missing values as empty cells.

    ``sealed`` puts its checksum beside it, as ``<path>.sha256``: for tables that other jobs read with `read_csv`.
    """
    text = frame.to_csv(index=False, float_format=format_number, lineterminator="\n")
    write_text(path, text)
    if sealed:
        seal(Path(path))


def read_csv(path: str | os.PathLike[str], **options: Any) -> pd.DataFrame:
    """Read a CSV file with pandas (and its ``options``), after checking it against its seal if it has one.

    Raises
    ------
    UserError
        When it is missing, differs from its seal or is not a table.
    """
    import pandas as pd

    try:
        content = regular.read_bytes(path, regular.MOST_BYTES)
    except regular.NotReadable as error:
        raise UserError(f"{path}: cannot be read as CSV ({error.reason}); {make(path)}") from error
    if broken_seal(path, content):
        raise UserError(f"{path}: damaged (differs from its checksum in {seal_of(path).name}); {make_again(path)}")
    try:
        return pd.read_csv(io.BytesIO(content), **options)
    except ValueError as error:  # pandas' own errors are ValueErrors
        raise UserError(f"{path}: cannot be read as CSV ({error}); {make_again(path)}") from error


def seal(path: Path) -> None:
    """Write the checksum of a file beside it."""
    write_text(seal_of(path), f"{regular.sha256(path)}  {path.name}\n")


def seal_of(path: str | os.PathLike[str]) -> Path:
    """Return the path of the checksum of a sealed file."""
    return Path(f"{path}.sha256")


def broken_seal(path: str | os.PathLike[str], content: bytes) -> bool:
    """Return whether a file has a seal that does not match this content."""
    seal = seal_of(path)
    if not os.path.lexists(seal):
        return False
    return regular.read_bytes(seal, LONGEST_SEAL) != f"{_sha256(content)}  {Path(path).name}\n".encode()


def _sha256(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def format_number(value: float) -> str:
    """Format a number with six significant digits; large ones without an exponent, which people misread."""
    text = f"{value:.{SIGNIFICANT_DIGITS}g}"
    return f"{float(text):.0f}" if "e+" in text else text
