"""Figure 12: steps per episode of several methods, one panel per environment and task."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from matplotlib.lines import Line2D

from ptl.measures.measures import Steps
from ptl.report.figures import style
from ptl.report.figures.bands import mean_band

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ptl.config import Statistics
    from ptl.report.script import Script
    from ptl.world.gridworld import GridWorld

MEDIAN: dict[str, Any] = {"linewidth": 1.3, "linestyle": (0, (3, 1.2))}
"""Line of the medians, which the few long runs of heavy tails do not move."""


MAX_HEIGHT = 300.0
"""Maximum height in inches of all panels; matplotlib draws no more than 2^16 pixels."""


def make(script: Script) -> tuple[Figure, pd.DataFrame]:
    """Draw the curves of the last task of each environment of the article, and of every task elsewhere."""
    from ptl.config import of_article
    from ptl.measures.run_files import read_steps  # here, so that curves of any runs can be drawn without files

    methods = [*script.methods, *script.foreign]
    every = {name: entry.tasks for name, entry in script.environments.items()}
    tasks = script.last_tasks if of_article(script.environments) else every
    frame = curves(read_steps(script.input.steps), script.worlds, tasks, methods, script.groups.statistics)
    return draw(frame, script.titles, script.looks), frame


def curves(
    steps: Steps,
    worlds: Mapping[str, GridWorld],
    tasks: Mapping[str, str],
    methods: Sequence[str],
    statistics: Statistics,
) -> pd.DataFrame:
    """Compute mean and median steps per episode over seeds, the mean with pointwise intervals.

    Parameters
    ----------
    steps : mapping
        See `ptl.measures.run_files.Steps`.
    worlds : mapping of environment name to GridWorld
        Panels come in this order.
    tasks : mapping of environment name to goal letters
        The tasks to show of each environment.
    methods : sequence of method identifiers
    statistics : Statistics
        Confidence and resamples of the intervals.

    Returns
    -------
    DataFrame
        Columns environment, task, method, episode (from 1), mean, ci_low, ci_high, median, seeds, shortest_path,
        confidence.
    """
    parts = []
    for environment, world in worlds.items():
        for task, method in product(tasks[environment], methods):
            if (environment, method, task) not in steps:  # another program need not have run everywhere
                continue
            values = steps[environment, method, task]
            mean, low, high = mean_band(values, statistics.confidence, statistics.resamples)
            part = pd.DataFrame({"episode": range(1, len(mean) + 1), "mean": mean, "ci_low": low, "ci_high": high})
            part["median"] = np.median(values, axis=0)
            for place, (name, value) in enumerate((("environment", environment), ("task", task), ("method", method))):
                part.insert(place, name, value)
            shortest = world.shortest_path_length(world.start, world.goal(task))
            parts.append(part.assign(seeds=len(values), shortest_path=shortest, confidence=statistics.confidence))
    return pd.concat(parts, ignore_index=True)


@style.styled
def draw(frame: pd.DataFrame, titles: Mapping[str, str], looks: Mapping[str, tuple[str, str]]) -> Figure:
    """Draw one panel per environment and task, log scale; ``titles`` and ``looks`` give names, labels and colours."""
    shown = frame.groupby(["environment", "task"], sort=False)
    columns = min(len(shown), 3)
    rows = math.ceil(len(shown) / columns)
    figure = style.new_figure(
        max(4.6 * columns, 9.5) if columns < 3 else style.SLIDE_WIDTH + 0.7, 0.9 + min(5.2 * rows, MAX_HEIGHT)
    )
    panels = figure.subplots(rows, columns, squeeze=False)
    for axes in panels.flat[len(shown) :]:
        axes.remove()
    for axes, ((environment, task), part) in zip(panels.flat, shown, strict=False):
        _panel(axes, part, looks)
        axes.set_title(f"{titles.get(environment, environment)}, task {task}")
        axes.set_xlabel("episode")
    for axes in panels[:, 0]:
        axes.set_ylabel("steps per episode")
    named = [zip(*axes.get_legend_handles_labels(), strict=True) for axes in panels.flat]
    lines = {label: line for pairs in named for line, label in pairs}
    lines["median"] = Line2D([], [], **MEDIAN, color=style.INK)
    figure.legend(
        lines.values(), lines.keys(), loc="outside lower center", ncols=6 if columns == 3 else 3, handlelength=1.6
    )
    return figure


def _panel(axes: Axes, part: pd.DataFrame, looks: Mapping[str, tuple[str, str]]) -> None:
    for method, curve in part.groupby("method", sort=False):
        label, colour = looks[str(method)]
        axes.fill_between(curve["episode"], curve["ci_low"], curve["ci_high"], color=colour, alpha=0.22, linewidth=0)
        axes.plot(curve["episode"], curve["mean"], color=colour, linewidth=1.9, label=label)
        axes.plot(curve["episode"], curve["median"], color=colour, zorder=2.5, **MEDIAN)
    shortest = part["shortest_path"].iloc[0]
    axes.axhline(shortest, color=style.INK, linewidth=1.1, linestyle=(0, (1, 1.6)), label="shortest path", zorder=1)
    axes.set_yscale("log")
    axes.set_xlim(1, part["episode"].max())
    axes.set_ylim(bottom=shortest / 1.5)
