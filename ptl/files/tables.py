"""Reader of the tables that the workflow's jobs hand to each other, and what their columns can hold."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from ptl.errors import UserError
from ptl.files.csv import read_csv
from ptl.files.store import AGAIN
from ptl.keys import shortened

NAMES = ("environment", "task", "method")
"""Columns whose values are text, whatever they look like."""


@dataclass(frozen=True)
class Numbers:
    """What a column of numbers can hold; infinity never.

    Attributes
    ----------
    low, high : float
        Least and greatest value.
    whole : bool
    missing : bool
        Whether cells may be empty.
    """

    low: float = -math.inf
    high: float = math.inf
    whole: bool = False
    missing: bool = False

    def __str__(self) -> str:
        kind = "whole numbers" if self.whole else "numbers"
        ends = [f"from {self.low:g} up"] if math.isfinite(self.low) else []
        ends = [f"from {self.low:g} to {self.high:g}"] if ends and math.isfinite(self.high) else ends
        ends = ends or [f"up to {self.high:g}"] * math.isfinite(self.high)
        return " ".join([kind, *ends]) + " or nothing" * self.missing

    def hold(self, column: pd.Series) -> bool:
        """Return whether all values of a column are such numbers."""
        if column.empty:
            return True
        if not pd.api.types.is_numeric_dtype(column) or pd.api.types.is_bool_dtype(column):
            return self.missing and bool(column.isna().all())
        values = column.to_numpy(dtype=float)
        if self.missing:
            values = values[~np.isnan(values)]
        fit = np.isfinite(values) & (values >= self.low) & (values <= self.high)
        return bool(np.all(fit & (values == np.floor(values)) if self.whole else fit))


COUNT, STATE = Numbers(0, whole=True), Numbers(-1, whole=True)
STEPS, SHARE = Numbers(1), Numbers(high=1, missing=True)

COLUMNS = {
    "seed": COUNT, "run": COUNT, "tasks": COUNT, "library_size": COUNT, "skills": COUNT, "operations": COUNT,
    "states": COUNT, "bytes": COUNT, "truncated": COUNT, "parts": COUNT, "parts_holding": COUNT,
    "first_episode": STEPS, "asymptotic": STEPS, "total_steps": STEPS, "steps": STEPS,
    "threshold_episode": Numbers(1, whole=True, missing=True),
    "jump_start": Numbers(missing=True), "transfer_ratio": SHARE,
    "subgoal": STATE, "incremental_peak": STATE, "original_peak": STATE,
    "row": Numbers(0, whole=True, missing=True), "column": Numbers(0, whole=True, missing=True),
    "novelty": Numbers(0), "metric_value": Numbers(0),
}  # fmt: skip
"""Columns of numbers, by their names in every table; -1 stands for no state."""


def read_table(path: str | Path, columns: Iterable[str], texts: Iterable[str] = ()) -> pd.DataFrame:
    """Read a CSV table; only empty cells are missing values.

    Parameters
    ----------
    columns : iterable of str
        Columns that must be there.
    texts : iterable of str
        Columns whose values are text, beside `NAMES`.

    Raises
    ------
    UserError
        When the file cannot be read, lacks one of the columns or holds in one of them what it cannot hold.
    """
    frame = read_csv(path, dtype=dict.fromkeys((*NAMES, *texts), str), keep_default_na=False, na_values=[""])
    for column in columns:
        if column not in frame:
            raise UserError(f"{path}: no column {column!r}; {AGAIN}")
        if column in COLUMNS and not COLUMNS[column].hold(frame[column]):
            raise UserError(f"{path}: column {column!r} must hold {COLUMNS[column]}; {AGAIN}")
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
