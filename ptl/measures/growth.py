"""Growth of the library against tasks learned: a line of two slopes (the article's figure 14), and a smooth rival."""

from __future__ import annotations

from dataclasses import dataclass

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
    tasks = np.arange(last + 1.0)
    design = np.column_stack([np.ones_like(tasks), np.minimum(tasks, bend), np.maximum(tasks - bend, 0)])
    return TwoSlopes(bend, *np.moveaxis(sizes @ np.linalg.pinv(design).T, -1, 0))


@dataclass(frozen=True)
class PowerLaw:
    """A curve without a bend: ``scale * t ** exponent`` at t tasks."""

    scale: float
    exponent: float

    def __call__(self, tasks: np.ndarray) -> np.ndarray:
        """Return the height of the curve, float array of the shape of ``tasks``."""
        return self.scale * np.asarray(tasks, dtype=float) ** self.exponent


def fit_power_law(sizes: np.ndarray) -> PowerLaw:
    """Fit a power law with an exponent of up to 2 by least squares to the sizes after 0, 1, ... tasks, (tasks + 1,)."""
    tasks = np.arange(len(sizes), dtype=float)

    def scale(exponent: float) -> float:
        powers = tasks**exponent
        return float(powers @ sizes / (powers @ powers))

    def error(exponent: float) -> float:
        return float(np.square(sizes - scale(exponent) * tasks**exponent).sum())

    best = float(minimize_scalar(error, bounds=(1e-6, 2.0), method="bounded").x)
    return PowerLaw(scale(best), best)
