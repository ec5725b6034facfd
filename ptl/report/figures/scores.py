"""Ranks of printed values in their predictive distributions, by measure."""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING

from ptl.measures.measures import BY_NAME
from ptl.measures.scoring import CONDITIONAL, DISTRIBUTIONS, MEAN, PRIOR, STATISTICS
from ptl.report.figures import style
from ptl.text import percent

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TITLES = {PRIOR: "All settings", CONDITIONAL: "Where most claims hold"}
ROW_HEIGHT = 0.9
LANES = 0.7
"""Part of a row over which its environments and statistics are spread."""


@style.styled
def draw(scores: pd.DataFrame) -> Figure:
    """Draw a row for each measure and a dot for each printed value (columns `ptl.measures.scoring.SCORE_COLUMNS`).

    A rank is the share of the prediction below the printed value. Dots are filled for means, open for standard
    deviations; the shades are the ranges of 50 and 90%.
    """
    measures = [name for name in BY_NAME if name in set(scores["measure"])]
    figure = style.new_figure(style.SLIDE_WIDTH, 2.6 + ROW_HEIGHT * len(measures))
    panels = figure.subplots(1, len(DISTRIBUTIONS), sharey=True)
    for axes, distribution in zip(panels, DISTRIBUTIONS, strict=True):
        _panel(axes, scores[scores["distribution"] == distribution], measures, list(scores["environment"].unique()))
        axes.set_title(TITLES[distribution])
    panels[0].set_yticks(range(len(measures)), [_label(name) for name in measures])
    panels[0].set_ylim(len(measures) - 0.5, -0.5)
    marks, labels = panels[0].get_legend_handles_labels()
    figure.legend(marks, labels, loc="outside lower center", ncols=max(1, len(marks) // len(STATISTICS)))
    return figure


def _panel(axes: Axes, own: pd.DataFrame, measures: list[str], environments: list[str]) -> None:
    axes.axvspan(0.05, 0.95, color=style.RULE, alpha=0.5, linewidth=0)
    axes.axvspan(0.25, 0.75, color=style.RULE, linewidth=0)
    axes.axvline(0.5, color=style.MUTED, linewidth=1.2)
    there = set(zip(own["environment"], own["statistic"], strict=True))
    lanes = [lane for lane in product(environments, STATISTICS) if lane in there]
    for lane, (environment, statistic) in enumerate(lanes):
        dots = own[(own["environment"] == environment) & (own["statistic"] == statistic)]
        colour = style.CATEGORIES[environments.index(environment) % len(style.CATEGORIES)]
        height = LANES * ((lane + 0.5) / len(lanes) - 0.5)
        axes.plot(
            dots["rank"],
            dots["measure"].map(measures.index) + height,
            "o",
            color=colour,
            markerfacecolor=colour if statistic == MEAN else "none",
            markersize=6,
            alpha=0.7,
            clip_on=False,
            label=f"{environment}, {statistic}",
        )
    axes.grid(axis="y", visible=False)
    axes.set(xlim=(0, 1), xticks=[0.05, 0.25, 0.5, 0.75, 0.95])
    axes.set_xlabel("rank of the printed value")
    axes.xaxis.set_major_formatter(lambda share, _: percent(share))


def _label(name: str) -> str:
    measure = BY_NAME[name]
    return f"{measure.heading},\n{measure.unit}"
