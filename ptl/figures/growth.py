"""Figure 14: the size of the skill library against the number of tasks, with a fit of two slopes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
from matplotlib.ticker import MaxNLocator

from ptl.errors import UserError
from ptl.figures import style
from ptl.figures.bands import interval, mean_band, resampling_weights
from ptl.files import read_csv

if TYPE_CHECKING:
    from matplotlib.figure import Figure


RESAMPLES = 2000


@dataclass(frozen=True)
class TwoSlopes:
    """A continuous line of two pieces: ``intercept + before * min(t, bend) + after * max(t - bend, 0)``."""

    bend: float
    intercept: float
    before: float
    after: float

    def __call__(self, tasks: np.ndarray) -> np.ndarray:
        """Height of the line, float array of the shape of ``tasks``."""
        tasks = np.asarray(tasks, dtype=float)
        first, second = np.minimum(tasks, self.bend), np.maximum(tasks - self.bend, 0)
        return self.intercept + self.before * first + self.after * second


def fit_two_slopes(tasks: np.ndarray, sizes: np.ndarray, bend: float) -> TwoSlopes:
    """Least-squares fit of a continuous line with one bend (the bend is given; form of the fit: our choice).

    Parameters
    ----------
    tasks, sizes : arrays, shape (points,)
    bend : float
        Number of tasks at which the slope changes; points on both sides are needed.

    Raises
    ------
    UserError
        When there are fewer than two points up to the bend or none beyond it.
    """
    return TwoSlopes(bend, *map(float, _projector(tasks, bend) @ np.asarray(sizes, dtype=float)))


def _projector(tasks: np.ndarray, bend: float) -> np.ndarray:
    tasks = np.asarray(tasks, dtype=float)
    if np.count_nonzero(tasks <= bend) < 2 or not np.any(tasks > bend):
        raise UserError(
            f"growth: a fit that bends at {bend:g} tasks needs two points up to there and one beyond, but the"
            f" tasks go from {tasks.min():g} to {tasks.max():g}; let lives have more tasks or move"
            " growth.breakpoint"
        )
    design = np.column_stack([np.ones_like(tasks), np.minimum(tasks, bend), np.maximum(tasks - bend, 0)])
    return np.linalg.pinv(design)


def read_growth(path: str | Path) -> tuple[np.ndarray, np.ndarray]:
    """Tasks (points,) and library sizes (runs, points) of a file with columns run, tasks, library_size."""
    frame = read_csv(path)
    for column in ("run", "tasks", "library_size"):
        if column not in frame:
            raise UserError(f"{path}: no column {column!r}; give the growth table")
    sizes = frame.pivot_table(index="run", columns="tasks", values="library_size")
    if sizes.empty or sizes.isna().any(axis=None):
        raise UserError(f"{path}: runs with different numbers of tasks, or none; make all runs of one configuration")
    return sizes.columns.to_numpy(), sizes.to_numpy(dtype=float)


def growth_frame(tasks: np.ndarray, sizes: np.ndarray, bend: float, confidence: float = 0.95) -> pd.DataFrame:
    """The plotted numbers.

    Columns tasks, mean, ci_low, ci_high, fit, runs, and, the same in every row, breakpoint, slope_before and
    slope_after (skills per task) with the ends of their bootstrap intervals over runs.
    """
    mean, low, high = mean_band(sizes, confidence)
    fit = fit_two_slopes(tasks, mean, bend)
    frame = pd.DataFrame(
        {"tasks": tasks, "mean": mean, "ci_low": low, "ci_high": high, "fit": fit(tasks), "runs": len(sizes)}
    )
    ends = np.full((2, 3), np.nan)
    if len(sizes) > 1:
        # the fit is linear in the sizes, so the fits of all resamples are one product
        fits = resampling_weights(len(sizes), RESAMPLES) @ sizes @ _projector(tasks, bend).T
        ends = np.stack(interval(fits, confidence))
    frame = frame.assign(confidence=confidence, breakpoint=bend, intercept=fit.intercept)
    for index, name in ((1, "before"), (2, "after")):
        frame[f"slope_{name}"] = getattr(fit, name)
        frame[f"slope_{name}_low"], frame[f"slope_{name}_high"] = ends[:, index]
    return frame


@style.styled
def draw(frame: pd.DataFrame) -> Figure:
    """Mean and interval of the library size, the fit and its slopes, all as `growth_frame` gives them."""
    figure = style.new_figure(10.4, 6.4)
    axes = figure.add_subplot()
    first = frame.iloc[0]
    bend, last = float(first["breakpoint"]), float(frame["tasks"].max())
    fit = TwoSlopes(bend, float(first["intercept"]), float(first["slope_before"]), float(first["slope_after"]))
    colour, _ = style.method_look("ptl")
    tasks = frame["tasks"]
    band = f", {100 * first['confidence']:g} % interval" if frame["ci_low"].notna().any() else ""
    shade = axes.fill_between(tasks, frame["ci_low"], frame["ci_high"], color=colour, alpha=0.25, linewidth=0)
    runs = f"{int(first['runs'])} runs" if first["runs"] > 1 else "1 run"
    (dots,) = axes.plot(tasks, frame["mean"], "o", color=colour, markersize=7.5, clip_on=False)
    corners = np.array([float(tasks.min()), bend, last])
    (line,) = axes.plot(corners, fit(corners), color=style.INK, linewidth=2.2)
    axes.axvline(bend, color=style.MUTED, linewidth=1.4, linestyle=(0, (4, 3)), zorder=1)
    top = 1.12 * max(float(np.nanmax(frame[["mean", "ci_high"]].to_numpy())), float(fit(corners).max()), 1.0)
    axes.set(xlim=(0, last * 1.02), ylim=(0, top), xlabel="tasks learned", ylabel="skills in the library")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator("auto", steps=[1, 2, 5, 10], integer=True))
    # the curve bends downwards, so below it, right of the bend, there is room for words
    arrow = {"arrowstyle": "-", "color": style.MUTED, "shrinkA": 4, "shrinkB": 5}
    for name, x, place in (
        ("before", 0.6 * bend, (0.31, 0.10)),
        ("after", bend + 0.62 * (last - bend), (0.66, 0.33)),
    ):
        slope, low, high = (first[f"slope_{name}{end}"] for end in ("", "_low", "_high"))
        text = f"{slope:.2f} skills per task"
        if np.isfinite(low):
            text += f"\n[{low:.2f}, {high:.2f}]"
        axes.annotate(
            text, (x, float(fit(np.array(x)))), place, textcoords="axes fraction", fontsize=16, va="center",
            arrowprops=arrow,
        )  # fmt: skip
    handles = [(shade, dots) if band else dots, line]
    labels = [f"mean of {runs}{band}", f"two slopes, bend at {bend:g} tasks"]
    axes.legend(handles, labels, loc="upper left", frameon=True, framealpha=1, edgecolor="none")
    return figure
