"""Reader of the tables that the workflow's jobs hand to each other."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import pandas as pd

from ptl.errors import UserError
from ptl.files.csv import read_csv
from ptl.files.remedies import make_again

NAMES = ("environment", "task", "method")
"""Columns whose values are text, whatever they look like."""


def read_table(path: str | Path, columns: Iterable[str], *, counts: bool = False) -> pd.DataFrame:
    """Read a CSV table; only empty cells are missing values.

    Parameters
    ----------
    columns : iterable of str
        Columns that must be there.
    counts : bool
        Whether they must hold numbers from 0 up.

    Raises
    ------
    UserError
        When the file cannot be read, lacks one of the columns or holds something else in it.
    """
    frame = read_csv(path, dtype=dict.fromkeys(NAMES, str), keep_default_na=False, na_values=[""])
    for column in columns:
        if column not in frame:
            raise UserError(f"{path}: no column {column!r}; {make_again(path)}")
        if counts and len(frame) and not (pd.api.types.is_numeric_dtype(frame[column]) and (frame[column] >= 0).all()):
            raise UserError(f"{path}: column {column!r} must hold numbers from 0 up; {make_again(path)}")
    return frame
