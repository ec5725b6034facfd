"""What the skill library costs: time of one skill selection, and room in memory or on disk."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from ptl.errors import UserError
from ptl.figures import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SELECTION_COLUMNS = ("skills", "seconds")
STORAGE_COLUMNS = ("states", "skills", "bytes")
MICROSECONDS = 1e6
KIBIBYTE = 1024


def read(path: str | Path, columns: Sequence[str]) -> pd.DataFrame:
    """Read these columns of a CSV file, all of them positive numbers."""
    try:
        frame = pd.read_csv(path)
    except (OSError, pd.errors.ParserError, pd.errors.EmptyDataError) as error:
        raise UserError(f"{path}: cannot be read as CSV ({error}); make it again") from error
    for column in columns:
        if column not in frame:
            raise UserError(f"{path}: no column {column!r}; the columns must be {', '.join(columns)}")
        if not pd.api.types.is_numeric_dtype(frame[column]) or not (frame[column] >= 0).all():
            raise UserError(f"{path}: column {column!r} holds something that is not a number from 0 up; make it again")
    return frame[list(columns)]


def cost_frame(selection: pd.DataFrame, storage: pd.DataFrame) -> pd.DataFrame:
    """The plotted numbers.

    Columns kind (selection or storage), states, skills, seconds (median of the repetitions), fit (least-squares
    line through all repetitions, seconds), seconds_per_skill (its slope), bytes.
    """
    if selection["skills"].nunique() < 2:
        raise UserError("time of a selection: a line needs two library sizes; measure another size")
    slope, intercept = np.polyfit(selection["skills"], selection["seconds"], 1)
    times = selection.groupby("skills", as_index=False)["seconds"].median()
    times = times.assign(kind="selection", fit=intercept + slope * times["skills"], seconds_per_skill=slope)
    frame = pd.concat([times, storage.assign(kind="storage")], ignore_index=True)
    frame = frame[["kind", "states", "skills", "seconds", "fit", "seconds_per_skill", "bytes"]]
    return frame.astype({"states": "Int64", "skills": "Int64", "bytes": "Int64"})
