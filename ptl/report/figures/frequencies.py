"""Figure 8: how often each state is chosen as the subgoal, over all pairs of start and goal."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from matplotlib.colors import PowerNorm

from ptl.report.figures import cells, style
from ptl.text import number

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ptl.files.store import Result
    from ptl.report.script import Script
    from ptl.world.gridworld import GridWorld

GAP = 1.75
"""Width in inches for the colour bar of a map."""
MIN_ASPECT = 0.6
"""Minimum ratio of width to height of a panel."""
MIN_HEIGHT = 5.2
"""Minimum height of the figure in inches, for the label of the colour bar."""
HEAD = 1.0
"""Inches above and below a map for its title and margins."""


@dataclass(frozen=True)
class Frequencies:
    """Contents of one file of subgoal frequencies; ``counts`` has shape (n_states,)."""

    environment: str
    world: GridWorld
    counts: np.ndarray
    pairs: int
    unresolved: int
    trajectories: int


def make(script: Script) -> tuple[Figure, pd.DataFrame]:
    """Draw a heat map for each environment."""
    items = read(script.results(script.input.survey))
    frame = frequency_frame(items)
    return draw(items, frame, script.titles), frame


def read(results: Iterable[Result]) -> list[Frequencies]:
    """Return the contents of files of subgoal frequencies, one per environment."""
    return [
        Frequencies(
            result.job.environment,
            result.world,
            result.arrays["counts"],
            int(result.arrays["pairs"]),
            int(result.arrays["unresolved"]),
            result.job.trajectories,
        )
        for result in results
    ]


def frequency_frame(items: Sequence[Frequencies]) -> pd.DataFrame:
    """Return the plotted numbers.

    Columns environment, state, row, column, count, share (percent of pairs), pairs, unresolved, trajectories.
    """
    parts = []
    for item in items:
        rows, columns = item.world.cells.T
        part = pd.DataFrame({"state": range(item.world.n_states), "row": rows, "column": columns, "count": item.counts})
        part.insert(0, "environment", item.environment)
        part = part.assign(share=100 * item.counts / item.pairs, pairs=item.pairs, unresolved=item.unresolved)
        parts.append(part.assign(trajectories=item.trajectories))
    return pd.concat(parts, ignore_index=True)


@style.styled
def draw(items: Sequence[Frequencies], frame: pd.DataFrame, titles: Mapping[str, str]) -> Figure:
    """Draw a heat map for each environment, on one colour scale (square root), so that they can be compared."""
    worlds = [item.world for item in items]
    # panels get room for the words above and below even if the map is a narrow tower
    rooms = [(rows, max(columns, MIN_ASPECT * rows)) for rows, columns in (world.shape for world in worlds)]
    arrangement = cells.pack(rooms)
    sides, heights = [], []
    for row in arrangement:
        shapes = [rooms[index] for index in row]
        width = style.SLIDE_WIDTH - GAP - 0.35 * len(row)
        scale = sum(columns / rows for rows, columns in shapes)
        height = min(width / scale, *(cells.MAX_CELL_SIDE * rows for rows, _ in shapes), 6.0)
        sides.append([height / rows for rows, _ in shapes])
        heights.append(height + HEAD)
    figure = style.new_figure(style.SLIDE_WIDTH, max(sum(heights), MIN_HEIGHT))
    halves: Any = figure.subfigures(1, 2, width_ratios=[style.SLIDE_WIDTH - GAP, GAP])
    maps, edge = halves
    bands = np.atleast_1d(maps.subfigures(len(arrangement), 1, height_ratios=heights))
    norm = PowerNorm(0.5, 0, max(float(frame["share"].max()), 0.01))
    shares = {name: part["share"].to_numpy() for name, part in frame.groupby("environment", sort=False)}
    for band, row, row_sides in zip(bands, arrangement, sides, strict=True):
        ratios = [rooms[index][1] / rooms[index][0] for index in row]
        panels = band.subplots(1, len(row), width_ratios=ratios, squeeze=False)[0]
        for axes, index, side in zip(panels, row, row_sides, strict=True):
            item = items[index]
            heat = cells.draw_heat(axes, item.world, shares[item.environment], norm)
            cells.draw_world(axes, item.world, room=rooms[index])
            cells.draw_places(axes, item.world, side)
            axes.set_title(titles.get(item.environment, item.environment))
            axes.set_xlabel(f"{number(item.pairs)} pairs, T = {item.trajectories}", loc="left", fontsize=14)
    bar = edge.colorbar(heat, cax=edge.subplots())
    bar.set_label("share of the (start, goal) pairs with\nthis subgoal, % (square-root scale)")
    bar.outline.set_visible(False)
    return figure
