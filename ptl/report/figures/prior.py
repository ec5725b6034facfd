"""Figure 3: the prior of a skill for one goal, by the state of the skill's subgoal."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd
from matplotlib.colors import LogNorm

from ptl.agent.selection import prior
from ptl.report.figures import cells, style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ptl.report.script import Script
    from ptl.world.gridworld import GridWorld

MIN_PRIOR = 1e-4
"""Minimum relative prior that the colours resolve."""


def make(script: Script) -> tuple[Figure, pd.DataFrame]:
    """Draw the prior for the last task of the environment."""
    [(name, world)] = script.worlds.items()
    skills = script.groups.skills
    frame = relative_prior(world, script.last_tasks[name], skills.prior_form, skills.prior_width)
    return draw(world, frame, script.titles[name]), frame


def relative_prior(world: GridWorld, goal: str, form: str, width: float) -> pd.DataFrame:
    """Compute the prior of a skill with its subgoal in each state, relative to one whose subgoal is the goal.

    Columns goal, state, row, column, relative_prior.
    """
    state = world.goal(goal)
    chances = prior(world.cells, range(world.n_states), state, world.diagonal, form, width)
    rows, columns = world.cells.T
    return pd.DataFrame(
        {
            "goal": goal,
            "state": range(world.n_states),
            "row": rows,
            "column": columns,
            "relative_prior": chances / chances[state],
        }
    )


@style.styled
def draw(world: GridWorld, frame: pd.DataFrame, title: str) -> Figure:
    """Draw the relative prior of every state on a log scale; it ignores walls."""
    side = cells.cell_side(world, style.SLIDE_WIDTH - 2.2, 6.4)
    room = rows, columns = cells.roomy(world, side, 4.8, 3.6)
    figure = style.new_figure(side * columns + 2.2, side * rows + 1.1, compress=True)
    axes = figure.add_subplot()
    goal = str(frame["goal"].iloc[0])
    values = frame["relative_prior"].to_numpy()
    norm = LogNorm(max(float(values.min()), MIN_PRIOR), 1, clip=True)
    heat = cells.draw_heat(axes, world, values, norm)
    cells.draw_world(axes, world, room=room)
    cells.draw_places(axes, world, side, goals=[goal])
    bar = figure.colorbar(heat, ax=axes, aspect=22, pad=0.02)
    bar.set_label(f"prior of a skill that ends here,\nrelative to one that ends at {goal}")
    bar.outline.set_visible(False)
    axes.set_title(f"{title}: prior for goal {goal}")
    return figure
