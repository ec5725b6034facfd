"""The experiment of Fernandez and Veloso: mean gain against trials, with the values of their figure."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from ptl.report.figures import style
from ptl.report.figures.bands import mean_band
from ptl.text import number, percent
from studies.fv_check.jobs import Gains

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ptl.config import Statistics

POINTS = 400
"""Number of points of a curve; more would not be visible."""


def gain_frame(gains: Sequence[Gains], statistics: Statistics) -> pd.DataFrame:
    """Return the plotted numbers.

    Columns name, library, trials (k), gain (mean over seeds of the mean gain over the first k trials), ci_low,
    ci_high, seeds, published (at the last trial only), confidence.
    """
    parts = []
    for item in gains:
        trials = item.gain.shape[1]
        shown = np.unique(np.linspace(1, trials, min(POINTS, trials)).round().astype(int))
        mean, low, high = mean_band(item.mean_gain[:, shown - 1], statistics.confidence, statistics.resamples)
        published = np.full(len(shown), np.nan)
        published[-1] = np.nan if item.library.published is None else item.library.published
        parts.append(
            pd.DataFrame(
                {
                    "name": item.library.name,
                    "library": item.library.label,
                    "trials": shown,
                    "gain": mean,
                    "ci_low": low,
                    "ci_high": high,
                    "seeds": len(item.gain),
                    "published": published,
                    "confidence": statistics.confidence,
                }
            )
        )
    return pd.concat(parts, ignore_index=True)


@style.styled
def draw(frame: pd.DataFrame) -> Figure:
    """Draw the mean gain with its interval for every library; diamonds are the published values."""
    figure = style.new_figure(style.SLIDE_WIDTH, 6.8)
    axes = figure.add_subplot()
    last = float(frame["trials"].max())
    baseline, _ = style.method_look("no_transfer")
    colours = iter(style.CATEGORIES)
    ends = []
    for name, part in frame.groupby("name", sort=False):
        colour = baseline if name == "q_learning" else next(colours)
        axes.fill_between(part["trials"], part["ci_low"], part["ci_high"], color=colour, alpha=0.2, linewidth=0)
        axes.plot(part["trials"], part["gain"], color=colour)
        end = part.iloc[-1]
        if np.isfinite(end["published"]):
            axes.plot(
                last,
                end["published"],
                "D",
                color=colour,
                markersize=11,
                clip_on=False,
                markeredgecolor="white",
                zorder=4,
            )
        ends.append((end, colour))
    top = 1.12 * float(np.nanmax(frame[["gain", "ci_high", "published"]].to_numpy()))
    _label_ends(axes, ends, last, top)
    axes.xaxis.set_major_formatter(style.GROUPED)
    first = frame.iloc[0]
    axes.set(xlim=(0, last), ylim=(0, top), xlabel="trials", ylabel="mean gain W over the first trials")
    band = f", {percent(first['confidence'])} interval" if frame["ci_low"].notna().any() else ""
    handles = [
        axes.plot([], [], color=style.INK, label=f"this package: mean of {first['seeds']} seeds{band}")[0],
        axes.plot([], [], "D", color=style.INK, markersize=9, label="published, read off a figure")[0],
    ]
    axes.legend(handles=handles, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
    return figure


def _label_ends(axes, ends: list, last: float, top: float) -> None:
    """Write the names of the curves to their right, moved apart where they would touch."""
    gap = 0.125 * top
    ends = sorted(ends, key=lambda item: item[0]["gain"])
    heights = np.array([float(end["gain"]) for end, _ in ends])
    places = heights.copy()
    for _ in range(200):
        for index in range(1, len(places)):
            overlap = gap - (places[index] - places[index - 1])
            if overlap > 0:
                places[index] += overlap / 2
                places[index - 1] -= overlap / 2
    for (end, colour), place in zip(ends, places, strict=True):
        text = f"{end['library']}\n{number(end['gain'])}"
        if np.isfinite(end["published"]):
            text += f" (published {number(end['published'])})"
        axes.annotate(
            text,
            (last, float(end["gain"])),
            (last * 1.035, place),
            textcoords="data",
            color=colour,
            va="center",
            fontsize=14,
            annotation_clip=False,
            fontweight="bold",
            linespacing=1.25,
            arrowprops={"arrowstyle": "-", "color": colour, "linewidth": 1, "shrinkA": 2, "shrinkB": 8},
        )
