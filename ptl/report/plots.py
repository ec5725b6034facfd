"""Drawings of a map, of action values and of learning curves on matplotlib axes, for notebooks and scripts."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.colors import LogNorm

from ptl.agent.policies import greedy_policy
from ptl.report.figures import cells, style
from ptl.world.gridworld import MOVES

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ptl.learning.life import TaskRecord
    from ptl.world.gridworld import GridWorld


def plot_map(axes: Axes, world: GridWorld, subgoals: Iterable[int] = ()) -> None:
    """Draw walls, start and goals of a map, and dots on subgoals (states)."""
    cells.draw_world(axes, world)
    cells.draw_floor(axes, world)
    cells.draw_places(axes, world, _side(axes, world), filled=True)
    states = list(subgoals)
    cells.draw_dots(axes, world, states, np.full(len(states), 9.0))


def plot_values(axes: Axes, world: GridWorld, q: np.ndarray) -> None:
    """Colour each state by its greatest action value, on a log scale, with an arrow for the greedy action.

    Parameters
    ----------
    q : float array, shape (n_states, 4)
        Action values, say those of a `TaskRecord`. States where all four are equal have no arrow.
    """
    values = q.max(axis=1)
    cells.draw_world(axes, world)
    if (values > 0).any():
        norm = LogNorm(values[values > 0].min(), max(values.max(), values[values > 0].min() * 1.01))
        cells.draw_heat(axes, world, np.maximum(values, 0), norm, style.PALE_HEAT)
    policy = greedy_policy(q)
    informed = np.flatnonzero(policy >= 0)
    row, column = world.cells[informed].T
    down, right = MOVES[policy[informed]].T
    axes.quiver(
        column, row, right, down, angles="xy", scale_units="xy", scale=1.6, pivot="middle", color=style.INK, zorder=3
    )


def plot_curve(axes: Axes, record: TaskRecord, label: str | None = None, **look: object) -> None:
    """Draw the steps of each episode of a learned task, on a log scale; ``look`` goes to ``axes.plot``."""
    episodes = np.arange(1, len(record.steps) + 1)
    axes.plot(episodes, record.steps, label=f"task {record.task.name}" if label is None else label, **look)  # type: ignore[arg-type]
    axes.set(yscale="log", xlabel="episode", ylabel="steps", xlim=(1, max(2, len(episodes))))


def _side(axes: Axes, world: GridWorld) -> float:
    """Return the side in inches of a cell on axes."""
    figure = axes.get_figure()
    assert figure is not None
    box = axes.get_window_extent().transformed(figure.dpi_scale_trans.inverted())
    return cells.cell_side(world, box.width, box.height)
