"""Drawing of maps: cells, walls, letters, heat and dots."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.colors import Colormap, ListedColormap, Normalize
from matplotlib.patches import PathPatch
from matplotlib.path import Path
from matplotlib.patheffects import withStroke

from ptl.report.figures import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import QuadMesh

    from ptl.world.gridworld import GridWorld

POINTS_PER_INCH = 72
LETTER: dict[str, Any] = {
    "fontfamily": "DejaVu Sans Mono", "fontweight": "bold",
    "ha": "center", "va": "center_baseline", "zorder": 6,
}  # fmt: skip
"""Type of the letters on maps; with serifs the start's I cannot be mistaken for a bar."""
DOT_LOOK: dict[str, Any] = {"markerfacecolor": "white", "markeredgecolor": style.INK, "markeredgewidth": 1.2}
"""Dots that are seen on light and on dark cells."""
MAX_CELL_SIDE = 0.42
"""Maximum side of a drawn cell in inches; without it the cells of a tiny map would fill a slide."""


def _paint(axes: Axes, values: np.ndarray, **look: Any) -> QuadMesh:
    rows, columns = values.shape
    edges = np.arange(columns + 1) - 0.5, np.arange(rows + 1) - 0.5
    return axes.pcolormesh(*edges, values, shading="flat", **look)


def roomy(world: GridWorld, side: float, width: float, height: float) -> tuple[float, float]:
    """Return the rows and columns of a panel of at least this width and height in inches, with cells of this side."""
    rows, columns = world.shape
    return max(rows, height / side), max(columns, width / side)


def draw_world(axes: Axes, world: GridWorld, ticks: bool = False, room: tuple[float, float] | None = None) -> None:
    """Draw the walls of a map and set the axes to its cells, row 0 on top.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    world : GridWorld
    ticks : bool
        Number rows and columns (counted from 0, as in the CSV files).
    room : (rows, columns), optional
        Size of the panel in cells if it is larger than the map, which is then in its upper left corner.
    """
    rows, columns = room or world.shape
    # the thin rim closes the hairlines that viewers of SVG files leave between neighbouring pieces
    look: dict[str, Any] = {
        "facecolor": style.WALL,
        "edgecolor": style.WALL,
        "linewidth": 0.15,
        "joinstyle": "miter",
    }
    axes.add_patch(PathPatch(_outline(world.walls), zorder=2, **look))
    axes.set(xlim=(-0.5, columns - 0.5), ylim=(rows - 0.5, -0.5), aspect="equal", facecolor=style.FLOOR)
    axes.grid(False)
    axes.spines[:].set_visible(False)
    if ticks:
        axes.set_xticks(range(0, world.shape[1], 5))
        axes.set_yticks(range(0, world.shape[0], 5))
        axes.tick_params(length=3, labelsize=12, labelcolor=style.MUTED)
        axes.set_xlabel("column", fontsize=13, color=style.MUTED)
        axes.set_ylabel("row", fontsize=13, color=style.MUTED)
    else:
        axes.set_xticks([])
        axes.set_yticks([])


def _outline(cells: np.ndarray) -> Path:
    """Return one path with a rectangle for every run of marked cells in a row, which keeps SVG files small."""
    corners: list[tuple[float, float]] = []
    codes: list[Any] = []
    for row, line in enumerate(cells):
        changes = np.flatnonzero(np.diff(np.concatenate([[0], line, [0]])))
        for begin, end in changes.reshape(-1, 2) - 0.5:
            top, bottom = row - 0.5, row + 0.5
            corners += [(begin, top), (end, top), (end, bottom), (begin, bottom), (begin, top)]
            codes += [Path.MOVETO, Path.LINETO, Path.LINETO, Path.LINETO, Path.CLOSEPOLY]
    return Path(np.reshape(corners, (-1, 2)), codes)


def draw_floor(axes: Axes, world: GridWorld) -> None:
    """Draw the outline of every free cell, so that steps can be counted."""
    floor = np.ma.masked_where(world.walls, np.ones(world.shape))
    _paint(axes, floor, cmap=ListedColormap([style.FLOOR]), edgecolor=style.RULE, linewidth=0.7, zorder=1)


def draw_heat(
    axes: Axes, world: GridWorld, values: np.ndarray, norm: Normalize, colours: Colormap = style.HEAT
) -> QuadMesh:
    """Colour the free cells by a value per state, array (n_states,); give the result to a colour bar.

    Cells with the value 0 are left white, which is also the colour of 0.
    """
    grid = np.ma.masked_equal(world.to_grid(values, fill=0.0), 0.0)
    # edgecolor="face": as for the walls
    return _paint(axes, grid, cmap=colours, norm=norm, edgecolor="face", linewidth=0.15, zorder=1)


def draw_places(
    axes: Axes, world: GridWorld, cell: float, goals: Iterable[str] | None = None, filled: bool = False
) -> None:
    """Letter the start and goals.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    world : GridWorld
    cell : float
        Side of a drawn cell in inches, for the size of the letters.
    goals : iterable of str, optional
        Goals to name; all goals of the map when left out.
    filled : bool
        Fill the cells with colour and write on it (for plain maps); otherwise write with a white rim
        (for heat maps, whose colours must stay visible).
    """
    named = [("I", world.start, style.START)]
    for goal in world.goals if goals is None else goals:
        named.append((goal, world.goal(goal), style.GOAL))
    size = float(np.clip(0.85 * cell * POINTS_PER_INCH, 10, 17))
    for letter, state, colour in named:
        row, column = world.cells[state]
        if filled:
            axes.text(
                column, row, letter, fontsize=max(size, 12), color="white", **LETTER,
                bbox={"boxstyle": "round,pad=0.16,rounding_size=0.15", "facecolor": colour, "linewidth": 0},
            )  # fmt: skip
        else:
            rim = withStroke(linewidth=max(2.5, size / 4.5), foreground="white")
            axes.text(column, row, letter, fontsize=size, color=style.INK, path_effects=[rim], **LETTER)


def draw_dots(axes: Axes, world: GridWorld, states: Sequence[int], sizes: np.ndarray) -> None:
    """Draw white dots with a dark rim in states; ``sizes`` are diameters in points."""
    for state, size in zip(states, sizes, strict=True):
        row, column = world.cells[state]
        axes.plot(column, row, "o", markersize=size, zorder=5, **DOT_LOOK)


def cell_side(world: GridWorld, width: float, height: float = math.inf) -> float:
    """Return the side in inches of a cell when the map fills a box of this size, at most `MAX_CELL_SIDE`."""
    rows, columns = world.shape
    return min(width / columns, height / rows, MAX_CELL_SIDE)


def pack(shapes: Sequence[tuple[float, float]], target: float = 1.9, narrowest: float = 0.27) -> list[list[int]]:
    """Arrange maps in rows of panels, in order, so that the whole comes close to the shape of a slide.

    All maps in a row get the same height and a row fills the width, as in a wall of photographs.

    Parameters
    ----------
    shapes : sequence of (rows, columns)
    target : float
        Wanted ratio of width to height.
    narrowest : float
        Minimum share of the width that a panel beside others gets, so that there is room for its title.

    Returns
    -------
    list of list of int
        For each row of panels the indices of its maps.
    """
    aspects = [columns / rows for rows, columns in shapes]
    n = len(aspects)
    best: tuple[float, list[list[int]]] | None = None
    for breaks in range(1 << (n - 1)):
        rows: list[list[int]] = [[0]]
        for index in range(1, n):
            if breaks >> (index - 1) & 1:
                rows.append([index])
            else:
                rows[-1].append(index)
        shares = [min(aspects[i] for i in row) / sum(aspects[i] for i in row) for row in rows if len(row) > 1]
        if min(shares, default=1.0) < narrowest:
            continue
        height = sum(1 / sum(aspects[i] for i in row) for row in rows)
        miss = abs(math.log(target * height))
        if best is None or miss < best[0] - 1e-12:
            best = miss, rows
    assert best is not None  # one map in each row is always allowed
    return best[1]
