"""How cost grows with the states of a map, the skills of a library and the tasks of a life."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from scipy import stats

from benchmarks.surveys import EVERY_STEP, METHODS, NO_LIMIT, costs
from ptl.agent._kernel import Dynamics, Learner
from ptl.agent._selection import SkillSelection
from ptl.agent.selection import prior
from ptl.agent.skills import Skill, SkillLibrary
from ptl.agent.subgoals import discover
from ptl.config import Parameters
from ptl.learning.growth import grow_library
from ptl.report.figures import style
from ptl.world import mazes
from ptl.world.gridworld import GridWorld
from ptl.world.transitions import TransitionGraph

TRAJECTORIES = Parameters().subgoals.trajectories
LIFE = 10
"""Tasks of a life on maps of growing size."""

GOALS = 5
"""Goals of a sampled start, enough to make the cost of a start negligible."""

Costs = Iterator[tuple[str, float]]
"""Quantities, each with its value; times are CPU seconds."""


@dataclass(frozen=True)
class Sizes:
    """Sizes to measure, and how much of the larger work is timed.

    Attributes
    ----------
    states, skills, tasks, episodes : tuple of int
        States of a map, skills of a library, tasks of a life, episodes of a task.
    library_states : int
        States of the map on which libraries and lives of many tasks or episodes are measured.
    steps : int
        Steps over which the time of one is measured.
    goals, starts, lives : int
        Goals of the survey with trees, starts of the survey with every step simulated, and lives: each divided by the
        number of states, but at least 3.
    """

    states: tuple[int, ...] = (300, 1000, 3000, 10_000)
    skills: tuple[int, ...] = (1, 10, 100, 300, 1000)
    tasks: tuple[int, ...] = (10, 30, 100, 300, 1000)
    episodes: tuple[int, ...] = (10, 30, 100, 300, 1000, 3000)
    library_states: int = 2000
    steps: int = 10**7
    goals: int = 40_000
    starts: int = 60_000
    lives: int = 30_000


QUICK = Sizes((60, 120), (1, 5), (2, 4), (2, 4), 100, 20_000, 1, 1, 1)

FITTED_FROM = {"states": 900, "skills": 100, "tasks": 10, "episodes": 100}
"""Minimum sizes for the fit of exponents; below them constant costs hide the growth."""

PANELS = {
    "Work around the episodes": ("states", ("read the map", "lay out the tables", "discovery and library update")),
    "One step of learning": ("states", ("one step, every step simulated", "one step, with the shortcut")),
    "Subgoals of all pairs": ("states", METHODS),
    "A life of ten tasks": ("states", ("life of ten tasks",)),
    "Library": ("skills", ("prior of a task", "one selection", "likelihood", "discovery and library update")),
    "A life of many tasks": ("tasks", ("life",)),
    "Ten tasks of many episodes": ("episodes", ("life of ten tasks",)),
}
"""Panels of the figure: the size along which cost grows, and the quantities."""


def measure(plan: Sizes, say: Callable[[str], None] = lambda _: None) -> pd.DataFrame:
    """Make all measurements of a plan.

    Returns
    -------
    DataFrame
        Columns ``part`` (states, skills, tasks or episodes: along which size), ``kind`` of map, ``size``, ``quantity``,
        ``value``, and the exponent of the fitted power law with its 95% interval and the smallest size that was fitted.
    """
    rows: list[tuple[str, str, int, str, float]] = []

    def add(part: str, kind: str, size: int, found: Iterable[tuple[str, float]]) -> None:
        say(f"cost by {part}: {kind}, {size}")
        rows.extend((part, kind, size, quantity, value) for quantity, value in found)

    for kind in ("rooms", "maze"):
        for states in plan.states:
            world = world_of(kind, states)
            add("states", kind, world.n_states, by_states(world, plan))
    world = world_of("rooms", plan.library_states)
    for skills in plan.skills:
        add("skills", "rooms", skills, by_skills(world, skills))
    for tasks in plan.tasks:
        seconds = least_seconds(partial(grow_library, world, tasks, Parameters(), 0, "benchmark", 0), 1)
        add("tasks", "rooms", tasks, [("life, s", seconds)])
    for episodes in plan.episodes:
        longer = Parameters().replace(learning__episodes=episodes)
        seconds = least_seconds(partial(grow_library, world, LIFE, longer, 0, "benchmark", 0), 3)
        add("episodes", "rooms", episodes, [("life of ten tasks, s", seconds)])
    return with_exponents(pd.DataFrame(rows, columns=["part", "kind", "size", "quantity", "value"]))


def world_of(kind: str, states: int) -> GridWorld:
    """Return a square cut at random into small rooms, or a perfect maze, of about this many states, with goal A."""
    random = np.random.default_rng(states)
    grid = {"rooms": mazes.rooms, "maze": mazes.maze}[kind](random, states)
    return GridWorld.from_text(mazes.to_text(mazes.with_letters(random, grid, "A")), kind)


def least_seconds(work: Callable[[], Any], repeats: int = 3, calls: int = 1) -> float:
    """Return the CPU seconds of a call: the mean of a number of calls, the minimum over repeats."""
    seconds = []
    for _ in range(repeats):
        begin = time.process_time()
        for _ in range(calls):
            work()
        seconds.append((time.process_time() - begin) / calls)
    return min(seconds)


def by_states(world: GridWorld, plan: Sizes) -> Costs:
    """Yield the costs of a map: reading, tables, a step, discovery, figure 8's survey and a life.

    A survey is timed on a sample of all pairs and scaled up; the relative standard error comes from the sample.
    """
    parameters, goal, text, n = Parameters(), world.goals["A"], world.text, world.n_states
    yield "read the map, s", least_seconds(lambda: GridWorld.from_text(text))
    yield "lay out the tables, s", least_seconds(lambda: Learner(Dynamics(world.successors), goal, np.random.SFC64(0)))
    for name, shortcut in (("every step simulated", False), ("with the shortcut", True)):
        yield f"one step, {name}, s", _seconds_a_step(world, shortcut, plan.steps)

    everything = np.full(n, 15, dtype=np.uint8)  # all four actions of each state were taken
    paths = [_shortest_path(world, goal)] * TRAJECTORIES

    def discovery() -> None:
        graph = TransitionGraph(world.successors, everything)
        library = SkillLibrary(novelty=0.0)
        library.update(discover(paths, graph, [], 2), graph, 0)

    yield "discovery and library update, s", least_seconds(discovery)
    for method in METHODS:
        number = max(3, (plan.starts if method == EVERY_STEP else plan.goals) // n)
        taken = costs(world, method, _sample(world, method, min(number, n)), TRAJECTORIES)
        seconds, _, pairs = taken.sum(axis=0)
        means = taken[:, 0] / taken[:, 2]
        yield f"{method}, s", n * (n - 1) / pairs * seconds
        yield f"{method}, relative standard error", means.std(ddof=1) / means.mean() / len(means) ** 0.5
    lives = max(3, plan.lives // n)
    unlimited = parameters.replace(learning__max_steps=NO_LIMIT)
    numbers = iter(range(lives))
    seconds = least_seconds(lambda: grow_library(world, LIFE, unlimited, 0, "benchmark", next(numbers)), 1, lives)
    yield "life of ten tasks, s", seconds


def by_skills(world: GridWorld, size: int) -> Costs:
    """Yield the costs of a library with a number of skills: the prior, a selection, the likelihood and an update."""
    random = np.random.default_rng(0)
    subgoals = random.choice(world.n_states, size=size, replace=False).tolist()
    goal, policy = world.goals["A"], np.zeros(world.n_states, dtype=np.int8)
    skills = [Skill(subgoal, policy.copy(), 0) for subgoal in subgoals]
    graph = TransitionGraph(world.successors)
    paths = [_shortest_path(world, goal)] * TRAJECTORIES

    def begin_task() -> SkillSelection:
        return SkillSelection(prior(world.cells, [world.start, *subgoals], goal, world.diagonal))

    def update() -> None:
        library = SkillLibrary(novelty=0.0, threshold=0.0, skills=list(skills))
        library.update(discover(paths, graph, library.subgoals, 2), graph, 0)

    selection = begin_task()
    works: tuple[tuple[str, Callable[[], Any], int], ...] = (
        ("prior of a task", begin_task, 100),
        ("one selection", lambda: selection.draw(random), 300),
        ("likelihood", lambda: selection.record([0], 100), 300),
        ("discovery and library update", update, 3),
    )
    for name, work, times in works:
        yield f"{name}, s", least_seconds(work, 7, times)


def with_exponents(measured: pd.DataFrame) -> pd.DataFrame:
    """Add the exponent of each curve, with its interval, to its rows."""
    parts = []
    for (part, _, _), curve in measured.groupby(["part", "kind", "quantity"], sort=False):
        large = curve[curve["size"] >= FITTED_FROM[str(part)]]
        exponent, low, high = power_law(large["size"].to_numpy(float), large["value"].to_numpy(float))
        first = large["size"].min()
        parts.append(curve.assign(exponent=exponent, exponent_low=low, exponent_high=high, fitted_from=first))
    return pd.concat(parts, ignore_index=True)


def power_law(sizes: np.ndarray, values: np.ndarray) -> tuple[float, float, float]:
    """Return the exponent of the power law through positive values, with its 95% interval.

    Least squares on logarithms; the interval is Student's, which assumes that the scatter around the line is noise.
    With fewer than two sizes the exponent is undefined (nan), with two the interval.
    """
    if len(sizes) < 2:
        return np.nan, np.nan, np.nan
    fit = stats.linregress(np.log(sizes), np.log(values))
    half = stats.t.ppf(0.975, len(sizes) - 2) * fit.stderr if len(sizes) > 2 else np.nan
    return float(fit.slope), float(fit.slope - half), float(fit.slope + half)


@style.styled
def draw(frame: pd.DataFrame) -> Figure:
    """Draw the panels of `PANELS` from the table of `measure`, all axes logarithmic."""
    figure = style.new_figure(style.SLIDE_WIDTH, 21.2)
    cells = figure.subplots(4, 2).flatten()
    for axes in cells[len(PANELS) :]:
        axes.remove()
    for axes, (title, (part, quantities)) in zip(cells, PANELS.items(), strict=False):
        for colour, quantity in zip(style.CATEGORIES, quantities, strict=False):
            curves = frame[(frame["part"] == part) & (frame["quantity"] == f"{quantity}, s")]
            for kind, curve in curves.groupby("kind", sort=False):
                marker, line = {"rooms": ("o", "-"), "maze": ("D", "--")}[str(kind)]
                power = f"{curve['exponent'].iloc[0]:.2f}".replace("-", "−")
                label = f"{quantity}, {kind}: p = {power}"
                axes.plot(curve["size"], curve["value"], marker + line, color=colour, markersize=7, label=label)
        axes.set(xscale="log", yscale="log", xlabel=part, ylabel="CPU seconds")
        low, high = axes.get_ylim()
        low = 10 ** np.floor(np.log10(low))  # a whole power of ten, so that flat curves have two ticks
        axes.set_ylim(low, high * (high / low) ** 0.9)  # room for the legend above the curves
        axes.set_title(title)
        axes.minorticks_off()
        axes.legend(loc="upper left", fontsize=12, title="cost ∝ sizeᵖ", title_fontsize=12, alignment="left")
    return figure


def _seconds_a_step(world: GridWorld, shortcut: bool, steps: int) -> float:
    """Return CPU seconds of a step from starts all over the map, while Q stays zero (alpha is 0)."""
    stretch = 10_000  # steps before the walk goes on elsewhere, unless it reaches the goal
    learner = Learner(
        Dynamics(world.successors),
        world.goals["A"],
        np.random.SFC64(1),
        alpha=0.0,
        shortcut=shortcut,
        max_steps=NO_LIMIT,
    )
    starts = np.random.default_rng(0).integers(0, world.n_states, steps // stretch).tolist()
    rates = []
    for _ in range(4):  # the first brings the tables into the caches
        taken, begin = 0, time.process_time()
        for start in starts:
            learner.begin_episode(start)
            learner.explore(budget=stretch)
            taken += learner.steps
        rates.append((time.process_time() - begin) / taken)
    return min(rates)


def _shortest_path(world: GridWorld, goal: int) -> np.ndarray:
    policy, path = world.transitions.shortest_path_policy(goal), [world.start]
    while path[-1] != goal:
        path.append(int(world.successors[path[-1], policy[path[-1]]]))
    return np.array(path)


def _sample(world: GridWorld, method: str, number: int) -> list[tuple[int, np.ndarray]]:
    """Draw some goals with all their starts for the trees, or some starts with `GOALS` goals each."""
    random, states = np.random.default_rng(0), np.arange(world.n_states)
    groups = [(int(state), np.delete(states, state)) for state in random.choice(states, number, replace=False)]
    if method == EVERY_STEP:
        groups = [(start, random.choice(goals, GOALS, replace=False)) for start, goals in groups]
    return groups
