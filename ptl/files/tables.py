"""Reader of CSV tables, those of the workflow and those of other programs."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pandas as pd

from ptl.errors import UserError
from ptl.files.csv import read_csv
from ptl.keys import shortened

NAMES = ("environment", "task", "method", "metric")
"""Columns whose values are always text, even if they look like numbers."""


def read_table(path: str | Path, columns: Iterable[str], texts: Iterable[str] = ()) -> pd.DataFrame:
    """Read a CSV table; only empty cells are missing values.

    Parameters
    ----------
    columns : iterable of str
        Columns that it must have.
    texts : iterable of str
        Columns whose values are text, in addition to `NAMES`.

    Raises
    ------
    UserError
        When the file cannot be read or lacks one of the columns.
    """
    frame = read_csv(path, dtype=dict.fromkeys((*NAMES, *texts), str), keep_default_na=False, na_values=[""])
    for column in columns:
        if column not in frame:
            raise UserError(f"{path}: no column {column!r}; remove the table and run the workflow again")
    return frame


def check_numbers(
    frame: pd.DataFrame, path: str | Path, columns: Iterable[str], *, low: float | None = None, missing: bool = False
) -> None:
    """Check the numbers of a table that another program may have written: they must be finite.

    Parameters
    ----------
    low : float, optional
        Minimum of whole numbers; without it any numbers are allowed.
    missing : bool
        Whether cells may be empty.

    Raises
    ------
    UserError
        Naming the first other value, with its row and column.
    """
    wanted = "a number" if low is None else f"a whole number from {low:g} up"
    for column in columns:
        cells = frame[column]
        values = pd.to_numeric(cells.astype(str), errors="coerce")  # as text, because True is no number
        wrong = ~np.isfinite(values)
        if low is not None:
            wrong |= (values < low) | (values != np.floor(values))
        if missing:
            wrong &= cells.notna()
        if wrong.any():
            row = int(wrong.to_numpy().argmax())
            value = "" if pd.isna(cells.iloc[row]) else shortened(str(cells.iloc[row]))
            raise UserError(f"{path}: row {row + 1}: {column} {value!r} is not allowed; give {wanted}")
