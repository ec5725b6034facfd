"""Growth of the library: a line of two slopes through its size against tasks learned (the article's figure 14)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

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
