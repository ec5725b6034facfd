"""Tables as CSV with six significant digits."""

from __future__ import annotations

import gzip
import io
import os
import zlib
from typing import TYPE_CHECKING, Any

from ptl.errors import UserError
from ptl.files import regular
from ptl.files.atomic import atomic_path, write_text

if TYPE_CHECKING:
    import pandas as pd

SIGNIFICANT_DIGITS = 6
"""Digits of every number in a CSV file: enough for a reader, too few to show another processor's last bit."""


def write_csv(frame: pd.DataFrame, path: str | os.PathLike[str]) -> None:
    """Write a data frame as CSV, numbers with six significant digits, missing values as empty cells.

    A name that ends in ``.gz`` gives a compressed file, without the time at which it was made.
    """
    text = frame.to_csv(index=False, float_format=format_number, lineterminator="\n")
    if str(path).endswith(".gz"):
        with atomic_path(path) as temporary:
            temporary.write_bytes(gzip.compress(text.encode(), mtime=0))
    else:
        write_text(path, text)


def read_csv(path: str | os.PathLike[str], **options: Any) -> pd.DataFrame:
    """Read a CSV file with pandas (and its ``options``).

    Raises
    ------
    UserError
        If it is missing or is not a table.
    """
    import pandas as pd

    try:
        content = regular.read_bytes(path, regular.MAX_BYTES)
        return pd.read_csv(io.BytesIO(gzip.decompress(content) if str(path).endswith(".gz") else content), **options)
    except regular.NotReadable as error:
        remedy = "run the workflow to make it, or check the path" if error.missing else "check the path"
        raise UserError(f"{path}: cannot be read as CSV ({error.reason}); {remedy}") from error
    except (EOFError, gzip.BadGzipFile, zlib.error) as error:
        raise UserError(f"{path}: cannot be decompressed ({error}); make it again") from error
    except ValueError as error:  # pandas' own errors are ValueErrors
        raise UserError(f"{path}: cannot be read as CSV ({error}); remove it and run the workflow again") from error


def format_number(value: float) -> str:
    """Format a number with six significant digits; large ones without an exponent, which is easily misread."""
    text = f"{value:.{SIGNIFICANT_DIGITS}g}"
    return f"{float(text):.0f}" if "e+" in text else text
