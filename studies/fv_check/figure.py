"""The experiment of Fernandez and Veloso: gains under each reading, beside the values of their figure."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
from matplotlib.ticker import MaxNLocator

from ptl.report.figures import style
from ptl.text import number, percent
from studies.fv_check.page import CLASS, READ_OFF
from studies.fv_check.readings import PUBLISHED, SHOWN, SUMMARIES
from studies.fv_check.simulator import MOTIONS, TIES

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LOOKS = {"trials": "o", "arms": "s"}
"""Marker of each summary."""


@style.styled
def draw(frame: pd.DataFrame, confidence: float) -> Figure:
    """Draw a panel for each library, with a row for each motion and rule for ties; the band is the published value.

    Parameters
    ----------
    frame : DataFrame
        As `page.gain_frame` makes it.
    """
    figure = style.new_figure(style.SLIDE_WIDTH, 7.2)
    panels = figure.subplots(1, len(SHOWN), sharey=True, sharex=True)
    rows = list(frame.groupby(["learner", "motion", "ties"], sort=False).groups)
    places, labels = _places(rows)
    for axes, library in zip(panels, SHOWN, strict=True):
        value = PUBLISHED[library.name]
        axes.axvspan(value - READ_OFF, value + READ_OFF, color=style.GOAL, alpha=0.18, linewidth=0)
        axes.axvline(value, color=style.GOAL, linewidth=1.4)
        for row in frame[frame["library"] == library.name].itertuples():
            place = places[row.learner, row.motion, row.ties] + 0.14 * (1 if row.summary == "arms" else -1)
            colour = style.INK if row.learner == CLASS else style.CATEGORIES[list(SUMMARIES).index(row.summary)]
            low, high = (row.ci_low, row.ci_high) if np.isnan(row.order_low) else (row.order_low, row.order_high)
            ends = np.array([[row.gain - low], [high - row.gain]])
            axes.errorbar(
                row.gain,
                place,
                xerr=ends if np.isfinite(ends).all() else None,
                fmt=LOOKS[row.summary],
                color=colour,
                markersize=8,
                linewidth=2.4 if np.isnan(row.order_low) else 1,
            )
        axes.set_title(f"{library.label}\npublished {number(value)}")
        axes.grid(visible=False, axis="y")
    panels[0].set_yticks(range(len(labels)), labels)
    panels[0].tick_params(axis="y", length=0)
    for place in set(range(len(labels))) - set(places.values()):
        panels[0].get_yticklabels()[place].set_fontweight("bold")
    panels[0].set(ylim=(len(labels) - 0.5, -0.5))
    panels[0].set_xlim(left=0)
    panels[0].xaxis.set_major_locator(MaxNLocator(4))
    panels[1].set_xlabel("mean gain W")
    shown = f", {percent(confidence)} interval" if frame["ci_low"].notna().any() else ""
    handles = [panels[0].plot([], [], "o", color=style.INK, markersize=8, label="this package's class")[0]]
    for colour, (name, (label, _)) in zip(style.CATEGORIES, SUMMARIES.items(), strict=False):
        handles += panels[0].plot([], [], LOOKS[name], color=colour, markersize=8, label=f"{label}{shown}")
    handles.append(panels[0].axvspan(np.nan, np.nan, color=style.GOAL, alpha=0.3, label=f"published ± {READ_OFF}"))
    figure.legend(handles=handles, loc="outside upper center", ncols=2)
    return figure


def _places(rows: Iterable[tuple[str, str, str]]) -> tuple[dict[tuple[str, str, str], int], list[str]]:
    """Return the height of each row, and the labels of all heights: those of one motion stand under a heading."""
    places: dict[tuple[str, str, str], int] = {}
    labels: list[str] = []
    before = None
    for learner, motion, ties in rows:
        if (learner, motion) != before:
            who = "this package's class" if learner == CLASS else "simulator"
            labels.append(f"{who}, {MOTIONS[motion].label}")
        before = learner, motion
        places[learner, motion, ties] = len(labels)
        labels.append(TIES[ties])
    return places, labels
