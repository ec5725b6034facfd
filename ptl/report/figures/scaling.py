"""Growth of cost with the states of a map, the skills of a library and the tasks of a life, and on larger worlds."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from ptl.report.figures import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

KINDS = {"chain": ("o", "-"), "rooms": ("s", "--"), "maze": ("D", "-."), "ring": ("^", ":")}
"""Marker and line of each kind of map."""

WORK = {
    "read the map, s": "read the map",
    "lay out the tables, s": "lay out the tables",
    "discovery and library update, s": "discovery and update",
}
STEP = {
    "one step, every step simulated, s": "every step simulated",
    "one step, with the shortcut, s": "with the shortcut",
}
LIBRARY = {
    "prior of a task, s": "prior of a task",
    "one selection, s": "one selection",
    "likelihood after an episode, s": "likelihood, an episode",
    "discovery and library update, s": "discovery and update",
}
SURVEY = {
    "survey, every step simulated, s": "every step simulated",
    "survey, with trees, s": "with trees",
}
LIFE = {"life of ten tasks, s": "CPU seconds", "life of ten tasks, memory, MiB": "memory, MiB"}

TEN_MINUTES = 600


@style.styled
def draw(frame: pd.DataFrame) -> Figure:
    """Draw six panels from the table of `ptl.benchmark.scaling.measure`, all axes logarithmic."""
    figure = style.new_figure(style.SLIDE_WIDTH, 15.9)
    work, step, library, tasks, survey, life = figure.subplots(3, 2).flat
    _curves(work, frame[frame["part"] == "states"], WORK)
    _dress(work, "Work around the episodes", "states of the map", "CPU seconds")
    _curves(step, frame[frame["part"] == "states"], STEP, scale=1e9)
    _dress(step, "One step of learning", "states of the map", "CPU nanoseconds")
    step.set_ylim(0.5, 100)
    _curves(library, frame[frame["part"] == "library"], LIBRARY, kinds_in_legend=False)
    _dress(library, "Library", "skills in the library", "CPU seconds")
    _tasks(tasks, frame[frame["part"] == "tasks"])
    _curves(survey, frame[frame["part"] == "survey"], SURVEY)
    _mark_ten_minutes(survey)
    _dress(survey, "Subgoals of all pairs on larger maps", "states of the map", "CPU seconds, scaled from a sample")
    _curves(life, frame[frame["part"] == "life"], LIFE)
    _dress(life, "A life of ten tasks on larger maps", "states of the map", "value, unit in the legend")
    return figure


def _curves(
    axes: Axes, part: pd.DataFrame, names: dict[str, str], scale: float = 1.0, kinds_in_legend: bool = True
) -> None:
    for colour, (quantity, name) in zip(style.CATEGORIES, names.items(), strict=False):
        exponents = []
        for kind, curve in part[part["quantity"] == quantity].groupby("kind", sort=False):
            marker, line = KINDS[str(kind)]
            axes.plot(curve["size"], scale * curve["value"], marker=marker, linestyle=line, color=colour, markersize=7)
            exponents.append(_exponent(curve))
        axes.plot([], [], color=colour, label=f"{name}: p = {', '.join(exponents)}")
    if kinds_in_legend:
        for kind in part["kind"].unique():
            marker, line = KINDS[str(kind)]
            axes.plot([], [], marker=marker, linestyle=line, color=style.MUTED, label=f"{kind}")


def _mark_ten_minutes(axes: Axes) -> None:
    axes.axhline(TEN_MINUTES, color=style.MUTED, linewidth=1)
    axes.annotate(
        "ten minutes",
        (0, TEN_MINUTES),
        (6, 5),
        ("axes fraction", "data"),
        "offset points",
        color=style.MUTED,
        fontsize=13,
    )


def _tasks(axes: Axes, part: pd.DataFrame) -> None:
    for colour, quantity, name, scale in (
        (style.CATEGORIES[0], "one task, s", "one task, milliseconds", 1e3),
        (style.CATEGORIES[1], "memory, MiB", "memory, MiB", 1.0),
        (style.CATEGORIES[2], "skills in the library, count", "skills in the library", 1.0),
    ):
        curve = part[part["quantity"] == quantity]
        axes.plot(
            curve["size"],
            scale * curve["value"],
            "o-",
            color=colour,
            markersize=7,
            label=f"{name}: p = {_exponent(curve)}",
        )
    _dress(axes, "One life of many tasks", "tasks learned", "value, unit in the legend")


def _exponent(curve: pd.DataFrame) -> str:
    return f"{curve['exponent'].iloc[0]:.2f}".replace("-0.00", "0.00").replace("-", "−")


def _dress(axes: Axes, title: str, x: str, y: str) -> None:
    axes.set(xscale="log", yscale="log", xlabel=x, ylabel=y)
    low, high = axes.get_ylim()
    axes.set_ylim(low, high * (high / low) ** 0.62)  # room for the legend above the curves
    axes.set_title(title)
    axes.legend(loc="upper left", fontsize=13, title="cost ∝ sizeᵖ", title_fontsize=13, alignment="left")
    axes.minorticks_off()
    if np.isfinite(low) and axes.get_ylim()[1] / axes.get_ylim()[0] > 1e7:
        axes.locator_params(axis="y", numticks=7)
