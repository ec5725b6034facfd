"""Growth of the library against tasks learned: a line of two slopes (the article's figure 14), and a smooth rival."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.optimize import minimize_scalar

from ptl.errors import UserError


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
    """Fit a line of two slopes by least squares (the bend is given; the form of the fit is our choice).

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
    return TwoSlopes(bend, *np.moveaxis(sizes @ _least_squares(last, bend).T, -1, 0))


@lru_cache(maxsize=1024)  # `best_bend` tries the same bends on every resampled curve
def _least_squares(last: int, bend: float) -> np.ndarray:
    """Return the matrix (3, last + 1) from sizes after 0, 1, ... tasks to intercept and slopes."""
    tasks = np.arange(last + 1.0)
    return np.linalg.pinv(np.column_stack([np.ones_like(tasks), np.minimum(tasks, bend), np.maximum(tasks - bend, 0)]))


STEP = 0.25
"""Distance in tasks of the bends that `best_bend` tries."""


def best_bend(size: np.ndarray) -> float:
    """Return the bend, in steps of a quarter of a task, at which two slopes fit a curve (tasks + 1,) best.

    Both pieces have two tasks or more.

    Raises
    ------
    UserError
        When the curve is too short.
    """
    bends = np.arange(2.0, len(size) - 3 + STEP, STEP)
    if not bends.size:
        raise UserError(f"growth.tasks: {len(size) - 1} is not enough for two slopes; give 4 or more")
    return float(min(bends, key=lambda bend: squared_error(size, fit_two_slopes(size, bend))))


def squared_error(size: np.ndarray, curve: TwoSlopes | Saturation) -> float:
    """Return the sum of the squared deviations of a curve from the sizes after 0, 1, ... tasks, (tasks + 1,)."""
    return float(np.square(size - curve(np.arange(len(size), dtype=float))).sum())


@dataclass(frozen=True)
class Saturation:
    """A curve without a bend: ``limit * t / (t + half)`` at t tasks; after ``half`` tasks it has half its limit."""

    limit: float
    half: float

    def __call__(self, tasks: np.ndarray) -> np.ndarray:
        """Return the height of the curve, float array of the shape of ``tasks``."""
        return self.limit * tasks / (tasks + self.half)


def fit_saturation(sizes: np.ndarray) -> Saturation:
    """Fit a saturating curve by least squares to the sizes after 0, 1, ... tasks, float array (tasks + 1,)."""
    tasks = np.arange(len(sizes), dtype=float)

    def limit(half: float) -> float:
        shape = tasks / (tasks + half)
        return float(shape @ sizes / (shape @ shape))

    def error(log_half: float) -> float:
        half = np.exp(log_half)
        return float(np.square(sizes - limit(half) * tasks / (tasks + half)).sum())

    half = float(np.exp(minimize_scalar(error, bounds=(-3, 10), method="bounded").x))
    return Saturation(limit(half), half)
