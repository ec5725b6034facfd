"""Figure 13: jump start, asymptotic performance and time to threshold on real curves."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from ptl.errors import UserError
from ptl.measures.measures import Steps
from ptl.report.figures import style
from ptl.text import number

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ptl.report.script import Script

DIMENSION_STEP = 1.75
"""Ratio of the heights of two dimension lines on the log scale."""


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
    shortest = world.shortest_path_length(world.start, world.goal(task))
    from ptl.measures.run_files import read_steps  # here, so that curves of any runs can be drawn without files

    steps = read_steps(script.input.steps)
    frame = measures(steps, name, task, script.methods, shortest, settings.window, settings.threshold_factor)
    return draw(frame, f"{script.titles[name]}, task {task}"), frame


def measures(
    steps: Steps,
    environment: str,
    task: str,
    methods: Sequence[str],
    shortest_path: int,
    window: int,
    threshold_factor: float,
) -> pd.DataFrame:
    """Compute the mean curve of two methods and the three measures of these curves.

    Measures of the tables are means of per-seed measures; those here are measures of the mean curve, because
    these are visible in the figure. Jump start and asymptotic performance are the same in both.

    Returns
    -------
    DataFrame
        Columns environment, task, method, episode, mean, trailing_mean (of ``window`` episodes), and, the
        same in all rows of a method, jump_start, asymptotic, threshold (steps), threshold_episode (empty:
        not reached), window and seeds.
    """
    threshold = threshold_factor * shortest_path
    runs = {method: steps[environment, method, task] for method in methods}
    curves = {method: values.mean(axis=0) for method, values in runs.items()}
    parts = []
    for method, mean in curves.items():
        if len(mean) < window:
            raise UserError(
                f"measures.window: {len(mean)} episodes are too few for a window of {window}; learn for more"
                " episodes or make measures.window smaller"
            )
        trailing = trailing_mean(mean, window)
        below = np.flatnonzero(trailing <= threshold)
        part = pd.DataFrame({"episode": range(1, len(mean) + 1), "mean": mean, "trailing_mean": trailing})
        for place, (name, value) in enumerate((("environment", environment), ("task", task), ("method", method))):
            part.insert(place, name, value)
        parts.append(
            part.assign(
                jump_start=curves[methods[0]][0] - mean[0],
                asymptotic=trailing[-1],
                threshold=threshold,
                threshold_episode=below[0] + 1 if below.size else np.nan,
                window=window,
                seeds=len(runs[method]),
            )
        )
    return pd.concat(parts, ignore_index=True)


@style.styled
def draw(frame: pd.DataFrame, title: str) -> Figure:
    """Draw mean steps per episode (thin) and their moving mean (thick), from which two measures are made."""
    figure = style.new_figure(style.SLIDE_WIDTH * 0.86, 6.6)
    axes = figure.add_subplot()
    episodes, window = int(frame["episode"].max()), int(frame["window"].iloc[0])
    firsts = []
    for method, curve in frame.groupby("method", sort=False):
        colour, label = style.method_look(str(method))
        axes.plot(curve["episode"], curve["mean"], color=colour, linewidth=1.0, alpha=0.55)
        axes.plot(curve["episode"], curve["trailing_mean"], color=colour, linewidth=3.4, label=label)
        axes.plot(1, curve["mean"].iloc[0], "o", color=colour, markersize=9, zorder=5, clip_on=False)
        firsts.append(float(curve["mean"].iloc[0]))
    axes.set_yscale("log")
    axes.set_xlim(-0.05 * episodes, episodes * 1.01)
    axes.set(xlabel="episode", ylabel="steps per episode")
    seeds = int(frame["seeds"].iloc[0])
    axes.set_title(f"{title}, {f'mean of {seeds} seeds' if seeds > 1 else '1 seed'}")
    _jump_start(axes, firsts, episodes)
    _threshold(axes, frame, episodes)
    _asymptotic(axes, frame, episodes, window)
    # below the axes, because inside them a short curve may run anywhere
    figure.legend(
        *axes.get_legend_handles_labels(),
        loc="outside lower center",
        ncols=2,
        title=f"thick: mean of the last {window} episodes",
        title_fontsize=14,
    )
    return figure


def _jump_start(axes: Axes, firsts: list[float], episodes: int) -> None:
    """Draw the arrow between the first episodes."""
    arrow = {"arrowstyle": "<->", "color": style.INK, "linewidth": 1.8, "shrinkA": 7, "shrinkB": 7}
    axes.annotate("", (1, firsts[1]), (1, firsts[0]), arrowprops=arrow)
    middle = float(np.sqrt(firsts[0] * firsts[1]))
    axes.text(-0.012 * episodes, middle, "jump start", rotation=90, ha="right", va="center", fontsize=17)


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
            axes.text(0, height, "threshold not reached", color=colour, va="center", fontsize=15)
            continue
        episode = float(row["threshold_episode"])
        axes.plot([episode, episode], [level, height], color=colour, linewidth=1.6, zorder=2)
        axes.plot(episode, level, "o", color=colour, markersize=9, zorder=5)
        arrow = {"arrowstyle": "<->", "color": colour, "linewidth": 1.8, "shrinkA": 0, "shrinkB": 0}
        axes.annotate("", (episode, height), (0, height), arrowprops=arrow)
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
    axes.annotate(
        f"asymptotic performance\n(last {window} episodes)", (episodes - window / 2 + 0.5, 0.95), (1.0, 1.02),
        xycoords=axes.get_xaxis_transform(), textcoords="axes fraction", ha="right", va="bottom", fontsize=17,
        arrowprops={"arrowstyle": "->", "color": style.INK, "linewidth": 1.8, "relpos": (0.9, 0)},
    )  # fmt: skip
