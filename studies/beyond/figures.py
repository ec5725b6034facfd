"""The figures of the second study. Each function draws a frame of `studies.beyond.summary`."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
from matplotlib.colors import LogNorm

from ptl.report.figures import style
from ptl.text import number
from studies.beyond.lives import NO_CHANGE

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PANELS = 3
"""Panels in a row."""

TICKS = [1, 2, 5, 10, 20, 50, 100, 200, 500]
RATIO_TICKS = [0.01, 0.03, 0.1, 0.3, 1, 3, 10, 30, 100]


@dataclass(frozen=True)
class Look:
    """Label and colour of a method.

    ``knows`` says what it is told about the goal, whether it relies on certain moves, and what it keeps from task to
    task.
    """

    label: str
    colour: str
    dashed: bool = False
    knows: tuple[str, str, str] = ("not stated", "not stated", "not stated")


def _panels(families: Sequence[str], height: float, titles: Mapping[str, str], legend: float = 0.0) -> tuple:
    rows = -(-len(families) // PANELS)
    columns = min(PANELS, len(families))
    figure = style.new_figure(style.SLIDE_WIDTH, height * rows + legend)
    grid = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    axes = dict(zip(families, grid.flat, strict=False))
    for family, ax in axes.items():
        ax.set_title(titles[family], fontsize=15)
    for ax in list(grid.flat)[len(families) :]:
        ax.set_visible(False)
    return figure, axes, grid


def _cost_axis(ax: Axes, axis: str, low: float, high: float, ticks: Sequence[float] = TICKS) -> None:
    ticks = [tick for tick in ticks if low / 1.3 <= tick <= high * 1.3]
    getattr(ax, f"set_{axis}scale")("log")
    getattr(ax, f"set_{axis}ticks")(ticks, [f"{tick:g}" for tick in ticks])
    getattr(ax, f"{axis}axis").minorticks_off()
    getattr(ax, f"set_{axis}lim")(low / 1.15, high * 1.15)


def _label_sides(grid: np.ndarray, families: Sequence[str], x: str, y: str) -> None:
    columns = grid.shape[1]
    for index, ax in enumerate(grid.flat):
        below = index + columns < len(families)
        if index < len(families):
            ax.set_xlabel("" if below else x, fontsize=14)
            ax.tick_params(labelbottom=not below)
        if index % columns == 0:
            ax.set_ylabel(y, fontsize=14)


def _legend(figure: Figure, ax: Axes, columns: int = 4) -> None:
    handles, labels = ax.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=columns, fontsize=12.5, handlelength=1.8)


def _curves(
    frame: pd.DataFrame,
    x: str,
    looks: Mapping[str, Look],
    titles: Mapping[str, str],
    value: str,
    finish: Callable[[Axes], None],
    labels: tuple[str, str],
) -> Figure:
    """Draw one panel a family with a curve and its interval for each method."""
    families = list(dict.fromkeys(frame["family"]))
    shown = [method for method in looks if method in set(frame["method"])]
    figure, axes, grid = _panels(families, 3.0, titles, legend=0.35 * -(-len(shown) // 4) + 0.3)
    for family, ax in axes.items():
        for method in shown:
            part = frame[(frame["family"] == family) & (frame["method"] == method)].sort_values(x)
            look = looks[method]
            ax.fill_between(part[x], part["low"], part["high"], color=look.colour, alpha=0.15, linewidth=0)
            ax.plot(
                part[x], part[value], color=look.colour, label=look.label, linestyle="--" if look.dashed else "-",
                linewidth=2,
            )  # fmt: skip
        finish(ax)
    _label_sides(grid, families, *labels)
    _legend(figure, axes[families[0]])
    return figure


def _by_family(costs: pd.DataFrame, families: Sequence[str]) -> pd.DataFrame:
    """Return costs with a row for each method, in the order of its mean cost, and a column for each family."""
    table = costs.pivot(index="method", columns="family", values="cost").reindex(columns=families)
    return table.loc[np.log(table).mean(axis=1).sort_values().index]


@style.styled
def strip(costs: pd.DataFrame, looks: Mapping[str, Look], titles: Mapping[str, str]) -> Figure:
    """Draw the cost of every method in every family as a coloured number, methods in the order of their mean cost.

    A sign of similarity stands before a cost whose ratio to that of the base may be 1.
    """
    table = _by_family(costs, list(titles))
    unclear = costs[(costs["ratio_low"] <= 1) & (costs["ratio_high"] >= 1)]
    unclear = set(zip(unclear["method"], unclear["family"], strict=True))
    rows, columns = table.shape
    figure = style.new_figure(style.SLIDE_WIDTH, 0.33 * rows + 1.6)
    ax = figure.add_subplot()
    norm = LogNorm(1, max(float(np.nanmax(table.to_numpy())), 2))
    ax.pcolormesh(table.to_numpy(), cmap=style.PALE_HEAT, norm=norm, edgecolor="white", linewidth=1.5)
    for row, method in enumerate(table.index):
        for column, value in enumerate(table.loc[method]):
            if np.isfinite(value):
                near = "≈ " if (method, table.columns[column]) in unclear else ""
                ax.text(column + 0.5, row + 0.5, near + number(round(value, 1 if value < 100 else 0)), ha="center",
                        va="center", fontsize=12)  # fmt: skip
    ax.set_yticks(np.arange(rows) + 0.5, [looks[method].label for method in table.index], fontsize=12)
    for label, method in zip(ax.get_yticklabels(), table.index, strict=True):
        label.set_color(looks[method].colour)
        label.set_fontweight("bold" if method == "ptl" else "normal")
    ax.set_xticks(np.arange(columns) + 0.5, [title.replace(" ", "\n", 1) for title in titles.values()], fontsize=12)
    ax.tick_params(length=0, labeltop=True, labelbottom=False)
    ax.invert_yaxis()
    ax.grid(False)
    ax.spines[:].set_visible(False)
    return figure


@style.styled
def overview(costs: pd.DataFrame, looks: Mapping[str, Look], titles: Mapping[str, str]) -> Figure:
    """Draw the ratio of every method to PTL on the same maps, one panel a family; the cost where PTL was not run."""
    value, low, high = ("ratio", "ratio_low", "ratio_high") if costs["ratio"].notna().any() else ("cost", "low", "high")
    costs = costs.dropna(subset=[value])
    families = list(dict.fromkeys(costs["family"]))
    methods = list(_by_family(costs, families).index)
    figure, axes, grid = _panels(families, 0.28 * len(methods) + 0.8, titles)
    ends = costs[[value, low, high]]
    for family, ax in axes.items():
        own = costs[costs["family"] == family].set_index("method").reindex(methods)
        places = np.arange(len(methods))[::-1]
        colours = [looks[method].colour for method in methods]
        ax.axvline(1, color=style.INK, linewidth=1)
        ax.hlines(places, own[low], own[high], color=colours, linewidth=4, alpha=0.35)
        ax.scatter(own[value], places, color=colours, s=42, zorder=3)
        _cost_axis(ax, "x", float(ends.min().min()), float(ends.max().max()), RATIO_TICKS)
        ax.set_yticks(places, [looks[method].label for method in methods], fontsize=11.5)
        ax.grid(axis="y", visible=False)
    _label_sides(grid, families, "cost, × PTL’s" if value == "ratio" else "cost, × optimum", "")
    return figure


@style.styled
def library_size(frame: pd.DataFrame, costs: pd.DataFrame, looks: Mapping[str, Look], titles: Mapping[str, str],
                 lines: Iterable[str], points: Iterable[str]) -> Figure:  # fmt: skip
    """Draw the cost against the size of the library: a curve for each finder.

    Parameters
    ----------
    frame : DataFrame
        As `by_library_size` makes it.
    costs : DataFrame
        Not used for curves; gives the families their order.
    lines, points : methods
        Methods without a library, drawn as lines across, and methods whose library size is not set.
    """
    families = [family for family in dict.fromkeys(costs["family"]) if family in set(frame["family"])]
    curves = [method for method in looks if method in set(frame.loc[frame["per_task"] > 0, "method"])]
    figure, axes, grid = _panels(families, 3.1, titles, legend=1.1)
    for family, ax in axes.items():
        own = frame[frame["family"] == family]
        for method in curves:
            part = own[(own["method"] == method) & (own["per_task"] > 0)].sort_values("library_size")
            look = looks[method]
            ax.fill_between(part["library_size"], part["low"], part["high"], color=look.colour, alpha=0.15, linewidth=0)
            ax.plot(part["library_size"], part["cost"], color=look.colour, marker="o", markersize=5, label=look.label)
        as_is = own[own["per_task"] == 0].set_index("method")
        for method in (method for method in points if method in as_is.index):
            look, row = looks[method], as_is.loc[method]
            ax.errorbar(
                row["library_size"], row["cost"], yerr=[[row["cost"] - row["low"]], [row["high"] - row["cost"]]],
                color=look.colour, marker="D" if method in curves else "s", markersize=8, markeredgecolor="white",
                linestyle="none", label=f"{look.label}, as it is" if method in curves else look.label,
            )  # fmt: skip
        for method in (method for method in lines if method in as_is.index):
            ax.axhline(as_is.loc[method, "cost"], color=looks[method].colour, linestyle="--", linewidth=1.8,
                       label=f"{looks[method].label} (no library)")  # fmt: skip
        ax.set_xscale("log")
        ax.set_xticks([1, 3, 10, 30, 100, 300], ["1", "3", "10", "30", "100", "300"])
        ax.minorticks_off()
        _cost_axis(ax, "y", 1.0, frame["cost"].max())
    _label_sides(grid, families, "skills in the library", "cost, × optimum")
    _legend(figure, axes[families[0]], 3)
    return figure


@style.styled
def slips(frame: pd.DataFrame, looks: Mapping[str, Look], titles: Mapping[str, str]) -> Figure:
    """Draw the cost of methods in each world: a curve over the slips, points where the map changes.

    Parameters
    ----------
    frame : DataFrame
        The costs that `by_world` makes, of all worlds.
    """
    families = [family for family in titles if family in set(frame["family"])]
    worlds = list(dict.fromkeys(frame["world"]))
    changed = set(frame.loc[frame["change"] != NO_CHANGE, "world"])
    shown = [method for method in looks if method in set(frame["method"])]
    figure, axes, grid = _panels(families, 3.2, titles, legend=0.35 * -(-len(shown) // 4) + 0.9)
    slipping = [place for place, world in enumerate(worlds) if world not in changed]
    for family, ax in axes.items():
        for shift, method in zip(np.linspace(-0.18, 0.18, len(shown)), shown, strict=True):
            part = frame[(frame["family"] == family) & (frame["method"] == method)].set_index("world").reindex(worlds)
            places, look = np.arange(len(worlds)) + shift, looks[method]
            ax.vlines(places, part["low"], part["high"], color=look.colour, linewidth=2, alpha=0.5)
            ax.plot(places, part["cost"], "o", color=look.colour, markersize=5)
            ax.plot(
                places[slipping], part["cost"].iloc[slipping], color=look.colour, label=look.label, linewidth=1.6,
                linestyle="--" if look.dashed else "-",
            )  # fmt: skip
        _cost_axis(ax, "y", 1.0, float(frame[["cost", "high"]].max().max()))
        ax.set_xticks(range(len(worlds)), worlds, rotation=35, ha="right", fontsize=12)
        ax.grid(axis="x", visible=False)
    _label_sides(grid, families, "", "cost, × optimum")
    _legend(figure, axes[families[0]])
    return figure


@style.styled
def profile(frame: pd.DataFrame, looks: Mapping[str, Look], titles: Mapping[str, str]) -> Figure:
    """Draw performance profiles: the share of lives within each multiple of the optimum."""

    def finish(ax: Axes) -> None:
        _cost_axis(ax, "x", 1.0, 100.0)
        ax.set_ylim(-0.02, 1.02)

    return _curves(frame, "threshold", looks, titles, "share", finish, ("τ, × optimum", "share of lives ≤ τ"))


@style.styled
def tasks(frame: pd.DataFrame, looks: Mapping[str, Look], titles: Mapping[str, str]) -> Figure:
    """Draw the cost of each task in its place of the life."""

    def finish(ax: Axes) -> None:
        _cost_axis(ax, "y", 1.0, frame["cost"].max())
        ax.set_xticks(range(1, int(frame["task"].max()) + 1))

    return _curves(frame, "task", looks, titles, "cost", finish, ("task", "cost, × optimum"))


@style.styled
def hardness(
    frame: pd.DataFrame, measures: Mapping[str, str], looks: Mapping[str, Look], titles: Mapping[str, str]
) -> Figure:
    """Draw the cost on each map against its hardness: a row for each method, a column for each measure.

    Parameters
    ----------
    frame : DataFrame
        As `studies.beyond.summary.hardness` makes it.
    measures : mapping
        Label of the axis of each measure.
    """
    methods = [method for method in looks if method in frame]
    figure = style.new_figure(style.SLIDE_WIDTH, 2.6 * len(methods) + 0.8)
    grid = figure.subplots(len(methods), len(measures), sharex="col", sharey=True, squeeze=False)
    families = list(dict.fromkeys(frame["family"]))
    for method, row in zip(methods, grid, strict=True):
        for (measure, label), ax in zip(measures.items(), row, strict=True):
            for family, colour in zip(families, style.CATEGORIES * 2, strict=False):
                part = frame[frame["family"] == family]
                ax.scatter(part[measure], part[method], s=18, color=colour, alpha=0.7, linewidth=0,
                           label=titles[family])  # fmt: skip
            _cost_axis(ax, "y", 1.0, float(frame[methods].max().max()))
            ax.set_xlabel(label if method == methods[-1] else "", fontsize=14)
            ax.set_title(looks[method].label, fontsize=15)
        row[0].set_ylabel("cost, × optimum", fontsize=14)
    _legend(figure, grid[0, 0], 6)
    return figure
