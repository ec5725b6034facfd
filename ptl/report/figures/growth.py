"""Figure 14: the size of the skill library against the number of tasks, with two fits."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from matplotlib.ticker import MaxNLocator

from ptl.measures.growth import TwoSlopes, fit_saturation, fit_two_slopes
from ptl.measures.run_files import read_sizes
from ptl.measures.sample_size import MIN_FOR_INTERVAL
from ptl.report.figures import style
from ptl.report.figures.bands import interval, mean_band, resampling_weights
from ptl.text import interval as limits
from ptl.text import number, percent, place_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ptl.report.script import Script


def make(script: Script) -> tuple[Figure, pd.DataFrame]:
    """Draw the growth of the library."""
    statistics, growth = script.groups.statistics, script.groups.growth
    sizes = read_sizes(str(script.input.growth))
    frame = growth_frame(sizes, growth.breakpoint, statistics.confidence, statistics.resamples)
    return draw(frame), frame


def growth_frame(sizes: np.ndarray, bend: float, confidence: float, resamples: int) -> pd.DataFrame:
    """Return the plotted numbers.

    Parameters
    ----------
    sizes : float array (runs, tasks + 1)
    bend : float
        Number of tasks at which the slope changes.
    confidence, resamples
        See `ptl.report.figures.bands.mean_band`.

    Returns
    -------
    DataFrame
        Columns tasks, mean, ci_low, ci_high, fit, saturation, runs, confidence and, the same in every row, breakpoint,
        intercept, slope_before and slope_after (skills a task) with the ends of their bootstrap intervals over runs,
        and saturation_half, the tasks after which the saturating curve has half its limit.
    """
    mean, low, high = mean_band(sizes, confidence, resamples)
    line = fit_two_slopes(mean, bend)
    tasks = np.arange(len(mean))
    frame = pd.DataFrame(
        {"tasks": tasks, "mean": mean, "ci_low": low, "ci_high": high, "fit": line(tasks), "runs": len(sizes)}
    )
    curve = fit_saturation(mean)
    frame.insert(list(frame).index("runs"), "saturation", curve(tasks))
    frame = frame.assign(confidence=confidence, breakpoint=bend, intercept=line.intercept, saturation_half=curve.half)
    lines = fit_two_slopes(resampling_weights(len(sizes), resamples) @ sizes, bend)
    enough = len(sizes) >= MIN_FOR_INTERVAL
    for side in ("before", "after"):
        ends = interval(getattr(lines, side), confidence) if enough else (np.nan, np.nan)
        frame[f"slope_{side}"] = getattr(line, side)
        frame[f"slope_{side}_low"], frame[f"slope_{side}_high"] = ends
    return frame


@style.styled
def draw(frame: pd.DataFrame) -> Figure:
    """Draw mean and interval of the library size, the fit and its slopes, as `growth_frame` gives them."""
    figure = style.new_figure(10.4, 6.8)
    axes = figure.add_subplot()
    first = frame.iloc[0]
    bend, last = first["breakpoint"], float(frame["tasks"].max())
    fit = TwoSlopes(bend, first["intercept"], first["slope_before"], first["slope_after"])
    colour, _ = style.method_look("ptl")
    tasks = frame["tasks"]
    band = f", {percent(first['confidence'])} interval" if frame["ci_low"].notna().any() else ""
    shade = axes.fill_between(tasks, frame["ci_low"], frame["ci_high"], color=colour, alpha=0.25, linewidth=0)
    runs = f"{int(first['runs'])} runs" if first["runs"] > 1 else "1 run"
    (dots,) = axes.plot(tasks, frame["mean"], "o", color=colour, markersize=7.5, clip_on=False)
    corners = np.array([float(tasks.min()), bend, last])
    (line,) = axes.plot(corners, fit(corners), color=style.INK, linewidth=2.2)
    (curve,) = axes.plot(tasks, frame["saturation"], color=style.GOAL, linewidth=1.9, linestyle=(0, (4, 2)))
    axes.axvline(bend, color=style.MUTED, linewidth=1.4, linestyle=(0, (4, 3)), zorder=1)
    top = 1.05 * max(float(np.nanmax(frame[["mean", "ci_high"]].to_numpy())), float(fit(corners).max()), 1.0)
    axes.set(xlim=(0, last * 1.02), ylim=(0, top), xlabel="tasks learned", ylabel="skills in the library")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator("auto", steps=[1, 2, 5, 10], integer=True))
    # the curve bends downwards, so the area below it, right of the bend, is free for text
    arrow = {"arrowstyle": "-", "color": style.MUTED, "shrinkA": 4, "shrinkB": 5}
    for name, x, place in (
        ("before", 0.6 * bend, (0.31, 0.10)),
        ("after", bend + 0.62 * (last - bend), (0.66, 0.33)),
    ):
        slope, low, high = (first[f"slope_{name}{end}"] for end in ("", "_low", "_high"))
        text = "\n".join(filter(None, (f"{number(slope, place_of(low, high))} skills a task", limits(low, high))))
        axes.annotate(
            text, (x, float(fit(np.array(x)))), place, textcoords="axes fraction", fontsize=16, va="center",
            arrowprops=arrow,
        )  # fmt: skip
    handles: list[Any] = [(shade, dots) if band else dots, line, curve]
    labels = [f"mean of {runs}{band}", f"two slopes, bend at {number(bend)} tasks (fit)"]
    labels.append(f"no bend: share t / (t + {first['saturation_half']:.0f}) of a limit (fit)")
    figure.legend(handles, labels, loc="outside lower center", ncols=2)
    return figure
