"""Figure 1: two clusters of states and the one subgoal between them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
from matplotlib.collections import LineCollection

from ptl.learning.life import learn_life
from ptl.report.figures import CLUSTER_LIVES, cells, style
from ptl.world.drawing import chain_of_rooms
from ptl.world.gridworld import GridWorld

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ptl.config import Parameters
    from ptl.report.script import Script

ROOMS, SIZE, SEED = 2, 7, 1
"""Rooms of the map and cells on their sides, and the root seed of the lives."""

COLOURS = ("#8fb8d8", "#e3b27a")
"""Colours of the two clusters."""

SMALLEST, LARGEST = 40, 520
"""Areas of the dots in square points, where the metric is 0 and where it is greatest."""


def make(script: Script) -> tuple[Figure, pd.DataFrame]:
    """Learn to go from one room to the other, and draw every state with its metric."""
    world = GridWorld.from_text(chain_of_rooms(SIZE, rooms=ROOMS), "two rooms")
    frame = clusters(world, script.parameters)
    return draw(world, frame), frame


def clusters(world: GridWorld, parameters: Parameters) -> pd.DataFrame:
    """Return the states with their cluster and what was found about them.

    Parameters
    ----------
    world : GridWorld
        Two rooms side by side with a door.

    Returns
    -------
    DataFrame
        Columns state, row, column, cluster (0 left, 1 right of the door, missing in it), metric (mean of the original
        FD metric over the lives) and subgoals (lives whose skill ends in the state).
    """
    records = [
        learn_life(world, "A", "ptl", parameters, SEED, "clusters", seed).records[0] for seed in range(CLUSTER_LIVES)
    ]
    found = [record.update.subgoal for record in records if record.update.subgoal >= 0]
    rows, columns = world.cells.T
    door = SIZE + 1
    return pd.DataFrame(
        {
            "state": range(world.n_states),
            "row": rows,
            "column": columns,
            "cluster": pd.Series(np.where(columns < door, 0, 1), dtype="Int64").mask(columns == door),
            "metric": np.mean([record.discovery.original.product for record in records], axis=0),
            "subgoals": np.bincount(found, minlength=world.n_states),
        }
    )


@style.styled
def draw(world: GridWorld, frame: pd.DataFrame) -> Figure:
    """Draw the graph of states, with dots as large as the metric, and a ring around the subgoal of most lives."""
    side = cells.cell_side(world, 0.6 * style.SLIDE_WIDTH, 4.6)
    rows, columns = world.shape
    figure = style.new_figure(side * columns + 0.4, side * rows + 0.2)
    axes = figure.add_subplot()
    place = frame[["column", "row"]].to_numpy(dtype=float)
    own = np.repeat(np.arange(world.n_states), world.successors.shape[1])
    moves = np.column_stack([own, world.successors.ravel()])
    moves = moves[moves[:, 0] < moves[:, 1]]
    axes.add_collection(LineCollection(list(place[moves]), colors=style.RULE, linewidths=1.4, zorder=1))
    area = SMALLEST + (LARGEST - SMALLEST) * frame["metric"] / frame["metric"].max()
    colours = [style.MUTED if pd.isna(number) else COLOURS[number] for number in frame["cluster"]]
    axes.scatter(place[:, 0], place[:, 1], s=area, c=colours, edgecolors=style.INK, linewidths=0.8, zorder=2)
    subgoal = place[frame["subgoals"].idxmax()]
    axes.scatter(
        subgoal[0], subgoal[1], s=LARGEST * 2.2, facecolors="none", edgecolors=style.GOAL, linewidths=3, zorder=3
    )
    axes.annotate(
        "subgoal", subgoal, (SIZE + 1, subgoal[1] + 1.65), color=style.GOAL, ha="center", fontsize=13,
        fontweight="bold",
        arrowprops={"arrowstyle": "-", "color": style.GOAL, "linewidth": 1.6, "shrinkB": 17},
    )  # fmt: skip
    cells.draw_places(axes, world, side)
    axes.set(xlim=(0.3, columns - 1.3), ylim=(rows - 0.9, 0.3), aspect="equal")
    axes.axis("off")
    for number, name in enumerate(("one cluster", "another cluster")):
        middle = float(frame.loc[frame["cluster"] == number, "column"].mean())
        axes.text(middle, rows - 1.45, name, ha="center", va="top", fontsize=15, color=style.INK)
    return figure
