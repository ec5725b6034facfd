"""Figure 4: a small world where the prior misleads and the likelihood recovers."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from matplotlib.colors import LogNorm

from ptl.agent._selection import SkillSelection
from ptl.agent.selection import prior
from ptl.errors import UserError
from ptl.jobs.learn import TaskView, skills_of, tasks_in
from ptl.methods.ptl import allowed_candidates
from ptl.report.figures import cells, style
from ptl.report.figures.bands import mean_band

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ptl.config import Skills, Statistics
    from ptl.files.store import Result
    from ptl.report.script import Script
    from ptl.world.gridworld import GridWorld

NULL_SKILL = "none"
"""Name of the null skill where skills are named by the task that taught them."""


@dataclass(frozen=True)
class Selections:
    """How skills were selected for one task, over many runs.

    Attributes
    ----------
    world : GridWorld
    task : str
        Goal letter.
    frame : DataFrame
        Columns skill (the task that taught it, `NULL_SKILL` for the null skill), episode (from 1),
        probability (mean over runs at the beginning of the episode, so that episode 1 has the prior),
        ci_low, ci_high, subgoal, row, column (of most runs), subgoal_runs (how many), distance (Euclidean,
        subgoal to goal, cells), path (shortest, steps), runs.
    relative_prior : float array, shape (n_states,)
        Prior of a skill with its subgoal in each state, relative to one that ends at the goal.
    """

    world: GridWorld
    task: str
    frame: pd.DataFrame
    relative_prior: np.ndarray


EPISODES = 60
"""Maximum number of episodes in the figure."""
BETWEEN, SHIFT = 8, 2
"""Episodes between two intervals of a skill, and from those of one skill to those of the next: none covers another."""


def make(script: Script) -> tuple[Figure, pd.DataFrame]:
    """Draw the selection of the last task of the map on which the prior misleads."""
    selections = collect(script.results(script.input.misleading_prior), script.groups.statistics)
    return draw(selections, min(EPISODES, int(selections.frame["episode"].max()))), selections.frame


def collect(results: Iterable[Result], statistics: Statistics, task: str | None = None) -> Selections:
    """Compute the selection probabilities of one task from learning files of the method ``ptl``.

    The files contain the skills and the length of each episode, which determine the probabilities.

    Parameters
    ----------
    results : iterable of Result
        Learning files of ``ptl`` on one map.
    statistics : Statistics
        Confidence and resamples of the intervals.
    task : str, optional
        The last task when left out.
    """
    world = settings = None
    runs: list[tuple[dict[str, int], np.ndarray]] = []
    for result in results:
        world, settings = result.world, result.job.settings
        views = tasks_in(result)
        task = task or result.job.tasks[-1]
        subgoals = dict(_candidates(result, views, task))
        runs.append((subgoals, _probabilities(world, settings.skills, views[task], list(subgoals.values()))))
    if world is None or task is None or settings is None:
        raise UserError("no learning file to draw; name at least one")
    skills = settings.skills
    goal = world.goal(task)
    everywhere = prior(world.cells, range(world.n_states), goal, world.diagonal, skills.prior_form, skills.prior_width)
    return Selections(world, task, _frame(world, goal, runs, statistics), everywhere / everywhere[goal])


def _candidates(result: Result, views: Mapping[str, TaskView], task: str) -> Iterator[tuple[str, int]]:
    """Yield the names and subgoals of the null skill and of the skills learned before the task, in order."""
    letters = result.job.tasks
    yield NULL_SKILL, views[task].start
    for skill in skills_of(result.arrays) or []:
        if skill.learned_after < letters.index(task):
            yield letters[skill.learned_after], skill.subgoal


def _probabilities(world: GridWorld, skills: Skills, view: TaskView, subgoals: list[int]) -> np.ndarray:
    """Return the probability of each candidate at the beginning of each episode, float array (candidates, episodes)."""
    allowed = allowed_candidates(len(subgoals), skills.null_skill or len(subgoals) == 1)
    chances = prior(world.cells, subgoals, view.goal, world.diagonal, skills.prior_form, skills.prior_width, allowed)
    selection = SkillSelection(chances, skills.likelihood_exponent, skills.likelihood_weight)
    history = []
    for episode, length in enumerate(view.steps):
        history.append(selection.probabilities())
        selection.record(view.selected_in(episode), int(length))
    return np.array(history).T


def _frame(
    world: GridWorld, goal: int, runs: list[tuple[dict[str, int], np.ndarray]], statistics: Statistics
) -> pd.DataFrame:
    names = sorted({name for subgoals, _ in runs for name in subgoals if name != NULL_SKILL})
    to_goal = world.distances_to(goal)
    parts = []
    for name in [*names, NULL_SKILL]:
        # a run that learned no skill in that task cannot draw it: probability 0
        histories = [
            history[list(subgoals).index(name)] if name in subgoals else np.zeros(history.shape[1])
            for subgoals, history in runs
        ]
        mean, low, high = mean_band(np.array(histories), statistics.confidence, statistics.resamples)
        places = pd.Series([subgoals[name] for subgoals, _ in runs if name in subgoals])
        subgoal = int(places.mode()[0])
        row, column = world.cells[subgoal]
        part = pd.DataFrame({"episode": range(1, len(mean) + 1), "probability": mean, "ci_low": low, "ci_high": high})
        part.insert(0, "skill", name)
        parts.append(
            part.assign(
                subgoal=subgoal,
                row=int(row),
                column=int(column),
                subgoal_runs=int((places == subgoal).sum()),
                distance=float(np.hypot(*(world.cells[subgoal] - world.cells[goal]))),
                path=int(to_goal[subgoal]),
                runs=len(runs),
            )
        )
    return pd.concat(parts, ignore_index=True)


@style.styled
def draw(selections: Selections, episodes: int) -> Figure:
    """Draw the prior with the skills and their paths to the goal (left) and selection over episodes (right)."""
    world = selections.world
    side = cells.cell_side(world, 6.3, 4.6)
    figure = style.new_figure(style.SLIDE_WIDTH, 5.9)
    left, right = figure.subplots(1, 2, width_ratios=[side * world.shape[1] + 1.5, 5.4])
    looks = _looks(list(dict.fromkeys(selections.frame["skill"])), selections.task)
    _map(left, selections, looks, side)
    _history(right, selections.frame, looks, episodes)
    return figure


def _looks(names: list[str], task: str) -> dict[str, tuple[str, str]]:
    """Return colour and label of each skill."""
    looks = {}
    for index, name in enumerate(name for name in names if name != NULL_SKILL):
        looks[name] = style.CATEGORIES[index % len(style.CATEGORIES)], f"skill learned in task {name}"
    looks[NULL_SKILL] = style.MUTED, "null skill"
    return looks


def _map(axes: Axes, selections: Selections, looks: dict[str, tuple[str, str]], side: float) -> None:
    world, task = selections.world, selections.task
    lowest = max(float(selections.relative_prior.min()), 1e-4)
    heat = cells.draw_heat(axes, world, selections.relative_prior, LogNorm(lowest, 1, clip=True), style.PALE_HEAT)
    cells.draw_world(axes, world)
    goal = world.goal(task)
    goal_row, goal_column = world.cells[goal]
    for name, skill in selections.frame.groupby("skill", sort=False):
        if name == NULL_SKILL:
            continue
        colour, _ = looks[str(name)]
        first = skill.iloc[0]
        path = world.cells[_shortest_path(world, int(first["subgoal"]), goal)]
        straight = [first["column"], goal_column], [first["row"], goal_row]
        dots: dict[str, Any] = {"linestyle": (0, (0.1, 1.8)), "dash_capstyle": "round"}
        for width, shade, dotted in ((6.0, "white", {}), (3.2, colour, dots)):
            axes.plot(path[:, 1], path[:, 0], color=shade, linewidth=width, zorder=4)
            axes.plot(*straight, color=shade, linewidth=0.7 * width, zorder=4, **dotted)
        mark: dict[str, Any] = {
            "color": colour,
            "markersize": 15,
            "markeredgecolor": "white",
            "markeredgewidth": 2,
        }
        axes.plot(first["column"], first["row"], "o", zorder=5, **mark)
    cells.draw_places(axes, world, side)
    bar = axes.figure.colorbar(heat, ax=axes, aspect=22, pad=0.02, shrink=0.85)
    bar.set_label(f"prior of a skill that ends here,\nrelative to one that ends at {task}")
    bar.outline.set_visible(False)
    axes.set_title(f"Prior for goal {task}")


def _shortest_path(world: GridWorld, origin: int, target: int) -> list[int]:
    """Return the states of one shortest path, ends included."""
    distance = world.distances_to(target)
    path = [origin]
    while path[-1] != target:
        path.append(min(world.successors[path[-1]].tolist(), key=lambda state: distance[state]))
    return path


def _history(axes: Axes, frame: pd.DataFrame, looks: dict[str, tuple[str, str]], episodes: int) -> None:
    for shift, (name, skill) in enumerate(frame[frame["episode"] <= episodes].groupby("skill", sort=False)):
        colour, label = looks[str(name)]
        if name != NULL_SKILL:
            first = skill.iloc[0]
            label += f"\n(dotted: {first['distance']:.1f} cells, solid: {first['path']} steps)"
        shown = skill.iloc[BETWEEN - 1 + SHIFT * shift :: BETWEEN]
        axes.vlines(shown["episode"], shown["ci_low"], shown["ci_high"], color=colour, linewidth=2)
        axes.plot(skill["episode"], skill["probability"], color=colour, label=label)
        axes.plot(1, skill["probability"].iloc[0], "o", color=colour, markersize=9, clip_on=False, zorder=5)
    axes.set(
        xlim=(1, episodes),
        ylim=(0, 1),
        xlabel="episode (dots: the prior alone)",
        ylabel="probability of selection",
    )
    axes.set_title("Selection: prior times likelihood")
    axes.figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=3, columnspacing=1.8)
