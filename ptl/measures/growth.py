"""Growth of the library: its size against the number of tasks, and a line of two slopes (the article's figure 14)."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from ptl.errors import UserError
from ptl.files.store import AGAIN, Result
from ptl.files.tables import read_table

COLUMNS = ("run", "tasks", "library_size")


def library_sizes(results: Iterable[Result]) -> pd.DataFrame:
    """Return the size of the library after every task of each growth file, columns `COLUMNS`."""
    parts = []
    for result in results:
        sizes = result.arrays["library_size"]
        parts.append(pd.DataFrame({"run": result.job.seed, "tasks": range(len(sizes)), "library_size": sizes}))
    return pd.concat(parts, ignore_index=True)


def read_sizes(path: str | Path) -> np.ndarray:
    """Read the table of `library_sizes` as float array (runs, tasks + 1); column t is the size after t tasks.

    Raises
    ------
    UserError
        When the file cannot be read or a run lacks a number of tasks that others have.
    """
    frame = read_table(path, COLUMNS)
    sizes = frame.pivot_table(index="run", columns="tasks", values="library_size")
    if not sizes.size == len(frame) > 0 or sizes.columns.tolist() != list(range(sizes.shape[1])):
        raise UserError(f"{path}: runs with different numbers of tasks, or none; {AGAIN}")
    return sizes.to_numpy(dtype=float)


@dataclass(frozen=True)
class TwoSlopes:
    """A line of two pieces: ``intercept + before * min(t, bend) + after * max(t - bend, 0)`` at t tasks.

    Intercept and slopes (skills a task) are arrays of the same shape, one element for each line.
    """

    bend: float
    intercept: np.ndarray
    before: np.ndarray
    after: np.ndarray

    def __call__(self, tasks: np.ndarray) -> np.ndarray:
        """Return the height of a single line, float array of the shape of ``tasks``."""
        return (
            self.intercept + self.before * np.minimum(tasks, self.bend) + self.after * np.maximum(tasks - self.bend, 0)
        )


def fit_two_slopes(sizes: np.ndarray, bend: float) -> TwoSlopes:
    """Fit a line of two slopes by least squares (the bend is given; form of the fit: our choice).

    Parameters
    ----------
    sizes : float array (..., tasks + 1)
        Size after 0, 1, ... tasks; a line is fitted to each row.
    bend : float
        Number of tasks at which the slope changes.

    Raises
    ------
    UserError
        When there are fewer than two points up to the bend or none beyond it.
    """
    last = sizes.shape[-1] - 1
    if not 1 <= bend < last:
        raise UserError(f"growth.breakpoint: {bend:g} is not allowed for lives of {last} tasks; give 1 to {last - 1}")
    tasks = np.arange(last + 1.0)
    design = np.column_stack([np.ones_like(tasks), np.minimum(tasks, bend), np.maximum(tasks - bend, 0)])
    return TwoSlopes(bend, *np.moveaxis(sizes @ np.linalg.pinv(design).T, -1, 0))
