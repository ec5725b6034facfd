"""Figures 9 to 11: the f*d metric of subgoal discovery, original and incremental, task by task."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
from matplotlib.colors import Normalize
from matplotlib.lines import Line2D

from ptl.errors import UserError
from ptl.jobs.learn import tasks_in
from ptl.report.figures import cells, style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ptl.files.store import Result
    from ptl.jobs.learn import TaskView
    from ptl.report.script import Script
    from ptl.world.gridworld import GridWorld

METRICS = ("original", "incremental")
MIN_PANEL_WIDTH, MIN_HEIGHT = 2.3, 3.2
"""Minimum width of a panel (for its title) and height of all (for the label of the colour bar), in inches."""
DOT = (0.35, 0.95)
"""Diameter of a dot for one seed and for all seeds, in sides of a cell: no dot reaches into another cell."""


@dataclass(frozen=True)
class Discoveries:
    """The metrics of one environment: its world, and the plotted numbers as `collect` describes them."""

    environment: str
    world: GridWorld
    frame: pd.DataFrame


def make(script: Script) -> tuple[Figure, pd.DataFrame]:
    """Draw the metrics of the tasks that the configuration names, the last three by default."""
    [(name, entry)] = script.environments.items()
    discoveries = collect(script.results(script.input.learning), entry.discovery_tasks)
    return draw(discoveries, script.titles[name]), discoveries.frame


def collect(results: Iterable[Result], tasks: Sequence[str]) -> Discoveries:
    """Compute the mean of both metrics over seeds, and how many seeds chose each state.

    Parameters
    ----------
    results : iterable of Result
        Learning files, the seeds of one environment and one method that keeps a library.
    tasks : sequence of str
        Tasks to show.

    Returns
    -------
    Discoveries
        The frame has columns environment, method, task, metric, state, row, column, value (mean over seeds of
        f*d, 0 to 1), chosen (seeds whose subgoal this state is) and seeds. The original metric chooses its
        argmax, the incremental metric what was added to the library, which may be nothing.
    """
    sums: dict[tuple[str, str], np.ndarray] = {}
    chosen: dict[tuple[str, str], np.ndarray] = {}
    job = world = None
    seeds = 0
    for result in results:
        job, world = result.job, result.world
        views = tasks_in(result)
        for task in tasks:
            for metric in METRICS:
                values = getattr(views[task], metric)
                sums[task, metric] = sums.get((task, metric), 0) + values
                counts = chosen.setdefault((task, metric), np.zeros(len(values), dtype=int))
                subgoal = _choice(views[task], metric, values)
                if subgoal >= 0:
                    counts[subgoal] += 1
        seeds += 1
    if job is None or world is None:
        raise UserError("no learning file to draw; name at least one")
    rows, columns = world.cells.T
    parts = []
    for (task, metric), total in sums.items():
        part = pd.DataFrame({"state": range(world.n_states), "row": rows, "column": columns, "value": total / seeds})
        heads = ("environment", job.environment), ("method", job.method), ("task", task), ("metric", metric)
        for place, (name, value) in enumerate(heads):
            part.insert(place, name, value)
        parts.append(part.assign(chosen=chosen[task, metric], seeds=seeds))
    return Discoveries(job.environment, world, pd.concat(parts, ignore_index=True))


def _choice(view: TaskView, metric: str, values: np.ndarray) -> int:
    if metric == "incremental":
        return view.subgoal
    return int(values.argmax()) if values.max() > 0 else -1


@style.styled
def draw(discoveries: Discoveries, title: str) -> Figure:
    """Draw tasks by metrics on one colour scale; dots mark peaks and subgoals, larger ones those of more seeds."""
    world, frame = discoveries.world, discoveries.frame
    tasks = list(dict.fromkeys(frame["task"]))
    # Wide maps get one row per task, others one column, whichever makes larger cells on a slide.
    by_row, by_column = (len(tasks), len(METRICS)), (len(METRICS), len(tasks))
    sides = {shape: _cell_side(world, *shape) for shape in (by_row, by_column)}
    shape = max(sides, key=lambda shape: sides[shape])
    side = sides[shape]
    room = rows, columns = cells.roomy(world, side, MIN_PANEL_WIDTH, MIN_HEIGHT / shape[0])
    width = shape[1] * (side * columns + 0.25) + 1.5
    height = shape[0] * (side * rows + 0.45) + 1.35
    figure = style.new_figure(max(width, 8.5), height, compress=True)
    panels = figure.subplots(*shape, squeeze=False)
    if shape == by_column:
        panels = panels.T
    norm = Normalize(0, max(float(frame["value"].max()), 0.01))
    seeds = int(frame["seeds"].iloc[0])
    groups = dict(list(frame.groupby(["task", "metric"], sort=False)))
    for row, task in zip(panels, tasks, strict=True):
        for axes, metric in zip(row, METRICS, strict=True):
            part = groups[task, metric]
            heat = cells.draw_heat(axes, world, part["value"].to_numpy(), norm)
            cells.draw_world(axes, world, room=room)
            cells.draw_places(axes, world, side, goals=[task])
            marked = part[part["chosen"] > 0]
            sizes = _diameter(marked["chosen"].to_numpy(), seeds, side)
            cells.draw_dots(axes, world, marked["state"].tolist(), sizes)
            axes.set_title(f"task {task}, {metric}", fontsize=15)
            if (count := int(part["chosen"].sum())) < seeds:
                words = "subgoal stored" if metric == "incremental" else "peak"
                axes.set_xlabel(f"{words} in {count} of {seeds} seeds", loc="left", fontsize=13)
    bar = figure.colorbar(heat, ax=panels.ravel().tolist(), shrink=0.9, aspect=24, pad=0.015)
    bar.set_label("metric f·d, mean over seeds")
    bar.outline.set_visible(False)
    figure.suptitle(
        f"{title}: subgoal discovery, {seeds} seed{'s' if seeds > 1 else ''}",
        x=0.09 / figure.get_figwidth(),
        ha="left",
        fontsize=18,
        fontweight="bold",
    )
    figure.legend(
        handles=_legend(seeds, side),
        loc="outside lower left",
        ncols=3,
        columnspacing=1.6,
        title="original: its peak, incremental: the stored subgoal",
        title_fontsize=14,
        alignment="left",
    )
    return figure


def _cell_side(world: GridWorld, rows: int, columns: int) -> float:
    width = (style.SLIDE_WIDTH - 1.5) / columns - 0.25
    height = (7.5 - 1.35) / rows - 0.45
    return cells.cell_side(world, width, height)


def _diameter(count: np.ndarray, seeds: int, side: float) -> np.ndarray:
    """Return the diameter of dots in points for cells of a side in inches; the area grows linearly with the count."""
    small, large = (share * side * cells.POINTS_PER_INCH for share in DOT)
    share = (np.asarray(count, dtype=float) - 1) / max(seeds - 1, 1)
    if seeds == 1:
        return np.full(np.shape(share), large)
    return np.sqrt(small**2 + share * (large**2 - small**2))


def _legend(seeds: int, side: float) -> list[Line2D]:
    """Return dots of three sizes."""
    counts = sorted({1, (seeds + 1) // 2, seeds})
    words = [f"in {count} seed{'s' if count > 1 else ''}" for count in counts]
    sizes = _diameter(np.array(counts), seeds, side)
    return [
        Line2D([], [], linestyle="none", marker="o", markersize=size, label=text, **cells.DOT_LOOK)
        for size, text in zip(sizes, words, strict=True)
    ]
