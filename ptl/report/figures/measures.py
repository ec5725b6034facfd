"""Figure 13: the measures of transfer on real curves."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from ptl.errors import UserError
from ptl.measures.measures import Steps
from ptl.report.figures import style
from ptl.report.figures.bands import mean_band
from ptl.text import number, percent
from ptl.world.optimum import optimum

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ptl.config import Statistics
    from ptl.report.script import Script

DIMENSION_STEP = 1.75
"""Ratio of the heights of two dimension lines on the log scale."""
LEVELLED = 0.98
"""Share of the steps saved that the linear panel shows; the episodes after that are left out."""


def trailing_mean(values: np.ndarray, window: int) -> np.ndarray:
    """Return the mean of the last ``window`` values at every point, NaN where there are fewer; arrays (points,)."""
    sums = np.cumsum(np.concatenate([[0.0], values]))
    means = np.full(len(values), np.nan)
    means[window - 1 :] = (sums[window:] - sums[:-window]) / window
    return means


def make(script: Script) -> tuple[Figure, pd.DataFrame]:
    """Draw the measures on the last task of the environment, with the first method as the base."""
    [(name, world)] = script.worlds.items()
    task, settings = script.last_tasks[name], script.groups.measures
    best = optimum(world, world.goal(task))
    from ptl.measures.run_files import read_steps  # here, so that curves of any runs can be drawn without files

    steps = read_steps(script.input.steps)
    given = (best, settings.window, settings.threshold_factor, script.groups.statistics)
    frame = measures(steps, name, task, script.methods, *given)
    return draw(frame, f"{script.titles[name]}, task {task}"), frame


def measures(
    steps: Steps,
    environment: str,
    task: str,
    methods: Sequence[str],
    best: float,
    window: int,
    threshold_factor: float,
    statistics: Statistics,
) -> pd.DataFrame:
    """Compute the mean curve of two methods with its band, and the measures of these curves.

    Measures of the tables are means of per-seed measures; those here are measures of the mean curve, because
    these are visible in the figure. All but the time to threshold and the transfer ratio are the same in both; the
    ratio here is that of the means.

    Returns
    -------
    DataFrame
        Columns environment, task, method, episode, mean, ci_low, ci_high, trailing_mean (of ``window`` episodes), and,
        the same in all rows of a method, jump_start, asymptotic, threshold (steps), threshold_episode (empty:
        not reached), steps_saved, transfer_ratio, window and seeds.
    """
    threshold = threshold_factor * best
    runs = {method: steps[environment, method, task] for method in methods}
    curves = {method: values.mean(axis=0) for method, values in runs.items()}
    base = curves[methods[0]]
    parts = []
    for method, mean in curves.items():
        if len(mean) < window:
            raise UserError(
                f"measures.window: {len(mean)} episodes are too few for a window of {window}; learn for more"
                " episodes or make measures.window smaller"
            )
        trailing = trailing_mean(mean, window)
        below = np.flatnonzero(trailing <= threshold)
        _, low, high = mean_band(runs[method], statistics.confidence, statistics.resamples)
        part = pd.DataFrame({"episode": range(1, len(mean) + 1), "mean": mean, "ci_low": low, "ci_high": high})
        part["trailing_mean"] = trailing
        for place, (name, value) in enumerate((("environment", environment), ("task", task), ("method", method))):
            part.insert(place, name, value)
        parts.append(
            part.assign(
                jump_start=base[0] - mean[0],
                asymptotic=trailing[-1],
                threshold=threshold,
                threshold_episode=below[0] + 1 if below.size else np.nan,
                steps_saved=base.sum() - mean.sum(),
                transfer_ratio=1 - mean.sum() / base.sum(),
                window=window,
                seeds=len(runs[method]),
            )
        )
    return pd.concat(parts, ignore_index=True)


@style.styled
def draw(frame: pd.DataFrame, title: str) -> Figure:
    """Draw the mean curves twice: on a log scale with their moving means, and on a linear one with their area."""
    figure = style.new_figure(style.SLIDE_WIDTH, 6.4)
    left, right = figure.subplots(1, 2, width_ratios=[1.35, 1])
    episodes, window = int(frame["episode"].max()), int(frame["window"].iloc[0])
    for method, curve in frame.groupby("method", sort=False):
        colour, label = style.method_look(str(method))
        for axes in (left, right):
            axes.fill_between(curve["episode"], curve["ci_low"], curve["ci_high"], color=colour, alpha=0.2, linewidth=0)
        left.plot(curve["episode"], curve["mean"], color=colour, linewidth=1.0, alpha=0.6)
        left.plot(curve["episode"], curve["trailing_mean"], color=colour, linewidth=3.4, label=label)
        right.plot(curve["episode"], curve["mean"], color=colour, linewidth=2.2)
    left.set_yscale("log")
    left.set(xlim=(1, episodes * 1.01), xlabel="episode", ylabel="steps per episode (log scale)")
    seeds = int(frame["seeds"].iloc[0])
    left.set_title(f"{title}, {f'mean of {seeds} seeds' if seeds > 1 else '1 seed'}")
    _threshold(left, frame, episodes)
    _asymptotic(left, frame, episodes, window)
    _area(right, frame)
    # below the axes, because inside them a short curve may run anywhere
    figure.legend(
        *left.get_legend_handles_labels(),
        loc="outside lower center",
        ncols=2,
        title=f"thick: mean of the last {window} episodes",
        title_fontsize=14,
    )
    return figure


def _area(axes: Axes, frame: pd.DataFrame) -> None:
    """Draw the jump start, and the area between the curves, on a linear scale."""
    base, own = (part.reset_index(drop=True) for _, part in frame.groupby("method", sort=False))
    saved = (base["mean"] - own["mean"]).cumsum()
    levelled = int((saved < LEVELLED * saved.iloc[-1]).sum()) + 1
    last = max(min(levelled, len(base)), 2)
    axes.fill_between(
        base["episode"], own["mean"], base["mean"], facecolor="none", edgecolor=style.MUTED, hatch="//", linewidth=0,
        zorder=1,
    )  # fmt: skip
    heights = base["mean"][:last], own["mean"][:last]
    top = 1.3 * max(float(max(part.max() for part in heights)), float(frame["ci_high"].fillna(0).max()))
    axes.set(xlim=(1, last), ylim=(0, top), xlabel="episode", ylabel="steps per episode (linear scale)")
    axes.yaxis.set_major_formatter(style.GROUPED)
    arrow = {"arrowstyle": "<->", "color": style.INK, "linewidth": 2.2, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", (1, own["mean"][0]), (1, base["mean"][0]), arrowprops=arrow, annotation_clip=False, zorder=6)
    row = own.iloc[0]
    words = (
        f"arrow: jump start, {number(round(row['jump_start']))} steps\n"
        f"hatched: {number(round(row['steps_saved']))} steps saved,\n"
        f"{percent(round(row['transfer_ratio'], 2))} of those without transfer"
    )
    axes.text(0.99, 0.99, words, transform=axes.transAxes, ha="right", va="top", fontsize=14, zorder=7)


def _threshold(axes: Axes, frame: pd.DataFrame, episodes: int) -> None:
    """Draw the threshold and the episode at which each curve reaches it."""
    level = float(frame["threshold"].iloc[0])
    axes.axhline(level, color=style.INK, linewidth=1.3, linestyle=(0, (4, 3)), zorder=1)
    lowest = min(level, float(frame["mean"].min()))
    # the longest way comes first (undefined ones before it), so that no line crosses text
    order = frame.drop_duplicates("method").sort_values("threshold_episode", ascending=False, na_position="first")
    methods = order["method"].tolist()
    axes.set_ylim(bottom=lowest / DIMENSION_STEP ** (len(methods) + 0.8))
    for line, method in enumerate(methods, start=1):
        row = frame[frame["method"] == method].iloc[0]
        colour, _ = style.method_look(method)
        height = lowest / DIMENSION_STEP**line
        if np.isnan(row["threshold_episode"]):
            axes.text(0.02 * episodes + 1, height, "threshold not reached", color=colour, va="center", fontsize=15)
            continue
        episode = float(row["threshold_episode"])
        axes.plot([episode, episode], [level, height], color=colour, linewidth=1.6, zorder=2)
        axes.plot(episode, level, "o", color=colour, markersize=9, zorder=5)
        arrow = {"arrowstyle": "<->", "color": colour, "linewidth": 1.8, "shrinkA": 0, "shrinkB": 0}
        axes.annotate("", (episode, height), (1, height), arrowprops=arrow)
        words = f"time to threshold: episode {number(round(episode))}"
        if episode < 0.55 * episodes:
            axes.text(episode + 0.012 * episodes, height, words, color=colour, va="center", fontsize=15)
        else:
            axes.text(episode / 2, height * 1.06, words, color=colour, ha="center", va="bottom", fontsize=15)
    beside = axes.get_yaxis_transform()
    axes.text(1.012, level, f"threshold\n{number(level)} steps", transform=beside, va="center", fontsize=15)


def _asymptotic(axes: Axes, frame: pd.DataFrame, episodes: int, window: int) -> None:
    """Mark the last episodes and the end of each curve."""
    ends = frame[frame["episode"] == episodes]
    axes.axvspan(episodes - window + 0.5, episodes + 0.5, color=style.RULE, alpha=0.7, linewidth=0, zorder=0)
    for method, end in zip(ends["method"], ends["asymptotic"], strict=True):
        colour, _ = style.method_look(method)
        axes.plot(episodes, end, "s", color=colour, markersize=9, zorder=6, clip_on=False)
    words = f"asymptotic performance\n(last {window} episodes, shaded)"
    axes.text(0.98, 0.98, words, transform=axes.transAxes, ha="right", va="top", fontsize=15)
