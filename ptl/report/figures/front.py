"""The picture on the first page: steps relative to no transfer on all tasks, and how far the claims hold."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from matplotlib.colors import to_rgb
from matplotlib.patches import Patch
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

from ptl.measures.relative_steps import relative_steps
from ptl.measures.statistics import Resampling
from ptl.report.figures import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure

    from ptl.report.script import Script

SPREAD = 0.62
"""Width of a task on the axis that its methods take."""
GAP = 0.45
"""Extra room between all tasks together and the single ones."""
TICKS = (1, 3)
"""Marks of the axis in each power of ten."""
NARROW = 5.3
"""Width in inches of the arrangement for a phone."""
ANGLE = 50
"""Slope in degrees of the labels of claims."""


def make(script: Script, narrow: bool = False) -> tuple[Figure, pd.DataFrame]:
    """Draw the picture of a run, the claims if there are any."""
    from ptl.files.csv import read_csv  # here, so that the picture can be drawn without files
    from ptl.measures.run_files import read_per_seed

    statistics = script.groups.statistics
    tasks = {name: entry.tasks for name, entry in script.environments.items()}
    how = Resampling(statistics.confidence, statistics.resamples)
    frame = relative_steps(read_per_seed(script.input.per_seed), tasks, how)
    path = getattr(script.input, "claims", None)
    claims = None if path is None else in_order(read_csv(path)[["id", "class"]])
    picture = draw(frame, claims, script.titles, script.looks, narrow)
    return picture, frame if claims is None else pd.concat([frame, claims], ignore_index=True)


def in_order(claims: pd.DataFrame) -> pd.DataFrame:
    """Sort claims (columns id and class) by class from the strongest on, in their own order within a class."""
    places = claims["class"].map(list(style.CLASS_COLOURS).index)
    return claims.loc[places.sort_values(kind="stable").index].reset_index(drop=True)


@style.styled
def draw(
    frame: pd.DataFrame,
    claims: pd.DataFrame | None,
    titles: Mapping[str, str],
    looks: Mapping[str, tuple[str, str]],
    narrow: bool = False,
) -> Figure:
    """Draw a panel for each environment, and below them a strip of the claims.

    Parameters
    ----------
    frame : DataFrame
        As of `ptl.measures.relative_steps.relative_steps`.
    claims : DataFrame or None
        As of `in_order`.
    titles, looks : mapping
        Names of environments; label and colour of each method.
    narrow : bool
        Put the panels below each other.
    """
    environments = list(dict.fromkeys(frame["environment"]))
    columns = 1 if narrow else min(len(environments), 3)
    rows = math.ceil(len(environments) / columns)
    width = style.SLIDE_WIDTH if claims is not None else max(style.SLIDE_WIDTH * columns / 3, 7.5)
    width = NARROW if narrow else width
    upper = rows * (3.4 if narrow else 4.3) + (1.5 if narrow else 0.7)
    lower = 0.0 if claims is None else _strip_height(len(claims), narrow)
    figure = style.new_figure(width, upper + lower)
    if claims is None:
        _panels(figure, frame, environments, (rows, columns), titles, looks)
    else:
        parts: Any = figure.subfigures(2, 1, height_ratios=[upper, lower])
        panels, strip = parts
        _panels(panels, frame, environments, (rows, columns), titles, looks)
        (_list if narrow else _strip)(strip, claims)
    return figure


def _panels(
    figure: Figure | SubFigure,
    frame: pd.DataFrame,
    environments: Sequence[str],
    shape: tuple[int, int],
    titles: Mapping[str, str],
    looks: Mapping[str, tuple[str, str]],
) -> None:
    panels = figure.subplots(*shape, squeeze=False, sharey=True)
    for axes in panels.flat[len(environments) :]:
        axes.remove()
    methods = [name for name in looks if name in set(frame["method"])]
    ends = frame[["ratio", "low", "high"]].to_numpy()
    bottom, top = min(np.nanmin(ends), 1) / 1.5, max(np.nanmax(ends), 1) * 1.5
    for axes, environment in zip(panels.flat, environments, strict=False):
        _panel(axes, frame[frame["environment"] == environment], methods, looks)
        axes.set(yscale="log", ylim=(bottom, top))
        axes.yaxis.set_major_locator(FixedLocator(_marks(bottom, top)))
        axes.yaxis.set_minor_locator(NullLocator())
        axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"× {value:g}"))
        axes.set_title(titles.get(environment, environment))
    words = "steps relative to\nno transfer" if shape[1] == 1 else "total steps relative to no transfer"
    for axes in panels[:, 0]:
        axes.set_ylabel(words)
    handles, labels = panels.flat[0].get_legend_handles_labels()
    figure.legend(
        handles,
        labels,
        loc="outside lower center",
        ncols=2 if shape[1] == 1 else 5,
        handlelength=1.2,
        columnspacing=1.4,
    )


def _marks(bottom: float, top: float) -> list[float]:
    powers = range(math.floor(math.log10(bottom)), math.ceil(math.log10(top)) + 1)
    return [digit * 10.0**power for power in powers for digit in TICKS if bottom <= digit * 10.0**power <= top]


def _panel(axes: Axes, part: pd.DataFrame, methods: Sequence[str], looks: Mapping[str, tuple[str, str]]) -> None:
    cases = list(dict.fromkeys(part["tasks"]))
    together = [len(case) > 1 for case in cases]
    places = np.arange(len(cases)) + GAP * (np.array(together, dtype=int).cumsum().max() - np.array(together))
    place_of = dict(zip(cases, places, strict=True))
    offsets = SPREAD * (np.linspace(-0.5, 0.5, len(methods)) if len(methods) > 1 else np.zeros(1))
    last = places[-1]
    axes.axvspan(last - 0.5, last + 0.5, color=style.RULE, alpha=0.55, linewidth=0, zorder=0)
    if any(together):
        axes.axvline(places[0] + 0.5 + GAP / 2, color=style.MUTED, linewidth=1, zorder=1)
    axes.axhline(1, color=style.INK, linewidth=1.4, zorder=1)
    for method, offset in zip(methods, offsets, strict=True):
        own = part[part["method"] == method]
        label, colour = looks[method]
        at = np.array([place_of[case] for case in own["tasks"]]) + offset
        axes.vlines(at, own["low"], own["high"], color=colour, linewidth=2.2, zorder=3)
        axes.plot(at, own["ratio"], "o", color=colour, markersize=5.5, label=label, zorder=4)
    axes.set_xlim(places[0] - 0.6, last + 0.6)
    axes.set_xticks(places, [_case(case, case == cases[-1]) for case in cases])
    axes.tick_params(axis="x", length=0)
    axes.grid(False, axis="x")


def _case(case: str, is_last: bool) -> str:
    if len(case) > 1:
        return f"{case[0]} to {case[-1]}\ntogether"
    return f"{case}\nlast" if is_last else case


# -- claims --------------------------------------------------------------------------------------------------


def _strip_height(claims: int, narrow: bool) -> float:
    return 0.31 * math.ceil(claims / 2) + 2.4 if narrow else 2.75


def _look(name: str) -> dict[str, Any]:
    hatch = {"hatch": "////"} if name == "by construction" else {}
    return {"facecolor": style.CLASS_COLOURS[name], "edgecolor": style.MUTED, "linewidth": 0.8, **hatch}


def _on(colour: str) -> str:
    """Return the colour of text on a ground."""
    return "white" if np.dot(to_rgb(colour), [0.30, 0.59, 0.11]) < 0.5 else style.INK


def _bare(axes: Axes, title: str) -> None:
    axes.set_title(title)
    axes.spines[:].set_visible(False)
    axes.grid(False)


def _legend(figure: Figure | SubFigure, claims: pd.DataFrame, columns: int) -> None:
    counts = claims["class"].value_counts()
    classes = [name for name in style.CLASS_COLOURS if name in counts]
    figure.legend(
        [Patch(**_look(name)) for name in classes],
        [f"{name} ({counts[name]})" for name in classes],
        loc="outside lower center", ncols=columns, fontsize=12, handlelength=1.1, columnspacing=1.0,
    )  # fmt: skip


def _strip(figure: SubFigure, claims: pd.DataFrame) -> None:
    """Draw the claims from left to right with their names below."""
    axes = figure.subplots()
    for place, name in enumerate(claims["class"]):
        axes.bar(place, 1, 1, align="center", **_look(name))
    for name, places in claims.groupby("class", sort=False).indices.items():
        colour = style.CLASS_COLOURS[str(name)]
        box = {"facecolor": colour, "edgecolor": "none", "pad": 2}
        axes.text(
            places.mean(), 0.5, str(len(places)), color=_on(colour), ha="center", va="center", fontweight="bold",
            bbox=box,
        )  # fmt: skip
    axes.set(xlim=(-0.5, len(claims) - 0.5), ylim=(0, 1), yticks=[])
    axes.set_xticks(range(len(claims)), claims["id"], rotation=ANGLE, ha="right", rotation_mode="anchor", fontsize=12)
    axes.tick_params(axis="x", length=0)
    _bare(axes, f"The article's {len(claims)} claims: how far they hold")
    _legend(figure, claims, 6)


def _list(figure: SubFigure, claims: pd.DataFrame) -> None:
    """Draw the claims in two columns with their names beside."""
    axes = figure.subplots()
    rows = math.ceil(len(claims) / 2)
    for place, (claim, name) in enumerate(zip(claims["id"], claims["class"], strict=True)):
        column, row = divmod(place, rows)
        axes.barh(row, 0.14, 0.8, left=column, **_look(name))
        axes.text(column + 0.19, row, claim, va="center", fontsize=13)
    axes.set(xlim=(0, 2), ylim=(rows - 0.5, -0.5), xticks=[], yticks=[])
    _bare(axes, f"How far the {len(claims)} claims hold")
    _legend(figure, claims, 1)
