"""Figures 5 to 7: a map with its start and goals."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

from ptl.report.figures import cells, style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ptl.report.script import Script
    from ptl.world.gridworld import GridWorld


def make(script: Script) -> tuple[Figure, pd.DataFrame]:
    """Draw the map of the environment."""
    [(name, world)] = script.worlds.items()
    return draw(world, script.titles[name]), places(world)


def places(world: GridWorld) -> pd.DataFrame:
    """Return the columns letter, state, row, column (from 0), shortest_path (steps from the start)."""
    distance = world.distances_to(world.start)
    rows = []
    for letter, state in [("I", world.start), *world.goals.items()]:
        row, column = world.cells[state]
        rows.append((letter, state, int(row), int(column), int(distance[state])))
    return pd.DataFrame(rows, columns=["letter", "state", "row", "column", "shortest_path"])


@style.styled
def draw(world: GridWorld, title: str) -> Figure:
    """Draw walls, free cells, the start I and the goals; rows and columns are numbered from 0."""
    rows, columns = world.shape
    side = cells.cell_side(world, style.SLIDE_WIDTH - 1.2, 7.0)
    figure = style.new_figure(max(side * columns + 1.2, 6.0), side * rows + 1.15)
    axes = figure.add_subplot()
    cells.draw_world(axes, world, ticks=True)
    cells.draw_floor(axes, world)
    cells.draw_places(axes, world, side, filled=True)
    axes.set_title(f"{title}: {world.n_states} states")
    return figure
