"""The figures of the multiverse."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from ptl.claims.reading import LAST_TASK, TRANSFER_TASKS
from ptl.report.figures import style
from studies.multiverse.curves import CLAIMED, levels
from studies.multiverse.design import Unknown

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TOGETHER, LAST, OTHERS, PRINTED = "#0f7f8c", "#c2571a", "#6a2c91", "#22262b"
"""Colours of the shares: read on B to F together, on task F, given the other claims, and of printed tables."""

HEADINGS = {
    "jump_start": "First episode saved by PTL (%)",
    "transfer_ratio": "Steps saved by PTL over the whole task (%)",
    "threshold_episode": "Episodes of PTL to the threshold",
}
FLOOR = {"jump_start": -100.0, "transfer_ratio": -100.0}
"""Least value shown of a saving; a setting below it is drawn there."""

ROWS = 5
"""Unknowns below a specification curve, those it depends on most."""


@style.styled
def draw_shares(ledger: pd.DataFrame) -> Figure:
    """Draw the share of settings in which each claim holds, with intervals, and its class as a strip at the left."""
    figure = style.new_figure(style.SLIDE_WIDTH, 0.38 * len(ledger) + 1.6)
    strip, ax = figure.subplots(1, 2, sharey=True, width_ratios=[0.035, 1])
    places = np.arange(len(ledger))
    strip.barh(places, 1, height=0.86, color=[style.CLASS_COLOURS[name] for name in ledger["class"]])
    strip.set_xlim(0, 1)
    strip.set_xticks([])
    strip.grid(False)
    for spine in strip.spines.values():
        spine.set_visible(False)
    strip.set_yticks(places, ledger["claim"], fontsize=12.5)
    strip.tick_params(length=0)
    strip.invert_yaxis()
    for shift, name, label, colour in (
        (-0.18, "", "task F, or as stated", LAST),
        (0.06, "_together", "tasks B to F together, or as stated", TOGETHER),
    ):
        low, middle, high = (100 * ledger[f"{part}{name}"].to_numpy() for part in ("low", "share", "high"))
        ax.errorbar(middle, places + shift, xerr=[middle - low, high - middle], fmt="o", color=colour, ms=6,
                    elinewidth=1.6, label=f"holds in % of settings, {label}")  # fmt: skip
    ax.plot(100 * ledger["given_others"], places - 0.18, "o", mfc="none", mec=OTHERS, ms=10, mew=1.6,
            label="given that the other claims hold best")  # fmt: skip
    ax.plot(100 * ledger["printed"], places + 0.32, "|", color=PRINTED, ms=9, mew=2.2,
            label="30 runs of the reference would print it")  # fmt: skip
    ax.set_xlim(-1.5, 101.5)
    ax.set_xlabel("% of the settings drawn, or of replicates")
    ax.grid(axis="y", visible=False)
    ax.tick_params(axis="y", length=0)
    handles, labels = ax.get_legend_handles_labels()
    from matplotlib.patches import Patch

    classes = [name for name in style.CLASS_COLOURS if name in set(ledger["class"])]
    handles += [Patch(facecolor=style.CLASS_COLOURS[name]) for name in classes]
    figure.legend(handles, [*labels, *classes], loc="outside upper center", ncols=3, fontsize=11.5)
    return figure


@style.styled
def draw_compatibility(pairs: pd.DataFrame) -> Figure:
    """Draw how often two claims hold together, beside how often both would by chance: the smaller share is the limit.

    Lower left: read on B to F together; upper right: on task F.
    """
    names = list(dict.fromkeys([*pairs["first"], *pairs["second"]]))
    table = np.full((len(names), len(names)), np.nan)
    for row in pairs.itertuples():
        if row.read not in (LAST_TASK, TRANSFER_TASKS):
            continue
        least = min(row.share_first, row.share_second)
        place = names.index(row.first), names.index(row.second)
        place = place if row.read == LAST_TASK else place[::-1]
        table[place] = row.together / least if least > 0 else np.nan
    figure = style.new_figure(10.5, 9.4)
    ax = figure.subplots()
    ax.set_facecolor("#eceef0")
    image = ax.imshow(100 * table, cmap="RdYlBu", vmin=0, vmax=100, aspect="equal", interpolation="nearest")
    ax.set_xticks(range(len(names)), names, rotation=90, fontsize=11)
    ax.set_yticks(range(len(names)), names, fontsize=11)
    ax.set_xticks(np.arange(len(names) + 1) - 0.5, minor=True)
    ax.set_yticks(np.arange(len(names) + 1) - 0.5, minor=True)
    ax.grid(False)
    ax.grid(which="minor", color="white", linewidth=1.2)
    ax.tick_params(which="both", length=0)
    for spine in ax.spines.values():
        spine.set_visible(False)
    ax.set_title("Above the diagonal: read on task F. Below: on B to F together.", fontsize=13, fontweight="normal")
    bar = figure.colorbar(image, ax=ax, shrink=0.7, pad=0.02)
    bar.set_label("settings in which both hold,\nin % of those in which the rarer one does", fontsize=12)
    bar.outline.set_visible(False)  # type: ignore[operator]
    return figure


@style.styled
def draw_scores(scores: pd.DataFrame, ways: Mapping[str, str], named: Mapping[str, str]) -> Figure:
    """Draw how many claims hold in each drawn setting, by the way to use a skill, and where named settings are.

    Parameters
    ----------
    ways : mapping
        Way to use a skill of each drawn setting.
    named : mapping
        Title of each named setting.
    """
    figure = style.new_figure(style.SLIDE_WIDTH, 6.2)
    axes = figure.subplots(1, 2, sharey=True)
    order = list(dict.fromkeys(ways.values()))
    for ax, read, title in zip(
        axes, (LAST_TASK, TRANSFER_TASKS), ("Read on task F", "Read on B to F together"), strict=True
    ):
        share = scores.set_index("setting")[f"share_{read}"]
        samples = [100 * share[[setting for setting in ways if ways[setting] == way]].to_numpy() for way in order]
        parts = ax.violinplot(samples, positions=range(len(order)), orientation="horizontal", widths=0.8,
                              showextrema=False, showmeans=True)  # fmt: skip
        for body in parts["bodies"]:  # type: ignore[attr-defined]
            body.set_facecolor("#9fb8c8")
            body.set_alpha(0.9)
        parts["cmeans"].set_color(style.INK)
        for (name, title_of), colour in zip(named.items(), style.CATEGORIES, strict=False):
            if name in share.index:
                ax.axvline(100 * share[name], color=colour, linewidth=2, label=title_of)
        ax.set_title(title)
        ax.set_xlabel("% of the judged claims that hold")
        ax.grid(axis="y", visible=False)
    axes[0].set_yticks(range(len(order)), [way.replace("_", " ") for way in order])
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", fontsize=12)
    return figure


@style.styled
def draw_curve(
    frame: pd.DataFrame,
    associations: pd.DataFrame,
    changes: Mapping[str, Mapping[str, Any]],
    unknowns: Mapping[str, Unknown],
    titles: Mapping[str, str],
    headline: str,
    reference: str,
) -> Figure:
    """Draw the specification curve of a headline estimate, a column for each environment.

    Above: the estimates on B to F together, sorted, with intervals, and on task F; the reference and what the article
    states. Below: in which settings each unknown has which level.
    """
    own = frame[frame["headline"] == headline]
    figure = style.new_figure(style.SLIDE_WIDTH, 8.6)
    grid = figure.subplots(2, len(titles), height_ratios=[1, 1.15], squeeze=False)
    for place, (environment, title) in enumerate(titles.items()):
        part = own[own["environment"] == environment]
        together = part[part["tasks"] == TRANSFER_TASKS].sort_values("value", kind="stable")
        cloud = together[together["setting"].isin(changes)]
        last = part[part["tasks"] == LAST_TASK].set_index("setting")["value"]
        upper, lower = grid[0][place], grid[1][place]
        _draw_estimates(upper, cloud, last, together[together["setting"] == reference], headline, environment)
        upper.set_title(title, fontsize=15)
        rows = associations[
            (associations["environment"] == environment)
            & (associations["tasks"] == TRANSFER_TASKS)
            & (associations["headline"] == headline)
        ].head(ROWS)
        _draw_levels(lower, list(cloud["setting"]), rows, changes, unknowns)
    grid[0][0].set_ylabel(HEADINGS[headline], fontsize=13)
    handles, labels = grid[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=4, fontsize=12, markerscale=2)
    return figure


def _draw_estimates(
    ax: Axes, cloud: pd.DataFrame, last: pd.Series, reference: pd.DataFrame, headline: str, environment: str
) -> None:
    floor = FLOOR.get(headline, -np.inf)
    places = np.arange(len(cloud))
    values, low, high = (np.maximum(cloud[name].to_numpy(), floor) for name in ("value", "low", "high"))
    ax.plot(places, np.maximum(last.reindex(cloud["setting"]).to_numpy(), floor), ".", color=LAST, ms=3, alpha=0.5,
            label="task F")  # fmt: skip
    ax.fill_between(places, low, high, color=TOGETHER, alpha=0.3, linewidth=0)
    ax.plot(places, values, color=TOGETHER, linewidth=2, label="B to F together, sorted")
    if (headline, environment) in CLAIMED:
        least, most = CLAIMED[headline, environment]
        ax.axhspan(max(least, ax.get_ylim()[0]), most, color="#e8c34a", alpha=0.35, linewidth=0, label="the article")
    for row in reference.itertuples():
        below = int((cloud["value"] < row.value).sum())
        ax.plot(
            below, max(row.value, floor), "D", color=style.INK, ms=8, clip_on=False, zorder=5, label="the reference"
        )
    ax.set_xlim(-1, len(cloud))
    ax.set_xticks([])
    if headline in FLOOR:
        ax.axhline(0, color=style.MUTED, linewidth=1)


def _draw_levels(
    ax: Axes,
    settings: list[str],
    rows: pd.DataFrame,
    changes: Mapping[str, Mapping[str, Any]],
    unknowns: Mapping[str, Unknown],
) -> None:
    labels: list[str] = []
    places: list[float] = []
    top = 0.0
    for row in rows.itertuples():
        unknown = unknowns[str(row.unknown)]
        names, level = levels([changes[setting][str(row.unknown)] for setting in settings], unknown)
        for number, name in enumerate(names):
            here = np.flatnonzero(level == number)
            # one broken line, which takes a tenth of the bytes of as many markers in an SVG
            marks = np.tile([top - 0.25, top + 0.25, np.nan], len(here))
            ax.plot(np.repeat(here, 3), marks, color=style.INK, linewidth=0.6, alpha=0.6)
            labels.append(f"{unknown.symbol}: {name}" if number == 0 else name)
            places.append(top)
            top += 1
        top += 0.7
    ax.set_yticks(places, labels, fontsize=10)
    ax.set_ylim(top, -1)
    ax.set_xlim(-1, len(settings))
    ax.set_xticks([])
    ax.set_xlabel("settings, by the curve above", fontsize=12)
    ax.grid(False)
    for spine in ax.spines.values():
        spine.set_visible(False)
    ax.tick_params(length=0)
