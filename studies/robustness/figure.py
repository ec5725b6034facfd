"""The robustness study as a heat map: every claim in every setting."""

from __future__ import annotations

import json
from collections.abc import Mapping
from itertools import chain
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
from matplotlib.colors import ListedColormap
from matplotlib.patches import Patch

from ptl.report.figures import style
from ptl.text import percent
from studies.robustness.design import GROUPS, LATIN_HYPERCUBE, ONE_AT_A_TIME, REFERENCE, Unknown
from studies.robustness.summary import NOT, PARTLY, REPRODUCED, UNDECIDED, VERDICTS, scores

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS = {REPRODUCED: "#0f7f8c", PARTLY: "#a9d5d3", NOT: "#c2571a", UNDECIDED: "#e4e6e9"}
"""Blue-green against orange, and unlike in lightness, so that they are told apart without colour as well."""


def heat_frame(verdicts: pd.DataFrame) -> pd.DataFrame:
    """Return the plotted numbers: column (from 0), setting, group, unknown, value, claim, verdict, score.

    Settings are in the order of the study; those of the Latin hypercube by their mean score, the best
    first.
    """
    frame = verdicts.assign(score=scores(verdicts))
    order = {group: list(dict.fromkeys(frame.loc[frame["group"] == group, "setting"])) for group in GROUPS}
    mean = frame.groupby("setting")["score"].mean()
    order[LATIN_HYPERCUBE].sort(key=lambda setting: -np.nan_to_num(mean[setting]))
    place = {setting: index for index, setting in enumerate(chain.from_iterable(order.values()))}
    single = frame["group"] == ONE_AT_A_TIME
    changes = [
        next(iter(json.loads(text).items())) if one else ("", "")
        for text, one in zip(frame["changes"], single, strict=True)
    ]
    frame = frame.assign(
        column=frame["setting"].map(place),
        unknown=[key for key, _ in changes],
        value=[json.dumps(value) if key else "" for key, value in changes],
    )
    columns = ["column", "setting", "group", "unknown", "value", "claim", "verdict", "score"]
    return frame.sort_values("column", kind="stable")[columns].reset_index(drop=True)


LABEL_WIDTH = 1.65
"""Width of a line of text, in settings of the middle panel."""


@style.styled
def draw(frame: pd.DataFrame, unknowns: Mapping[str, Unknown]) -> Figure:
    """Draw claims by settings; one panel for each group of settings, names of unknowns below the middle one."""
    claims = list(dict.fromkeys(frame["claim"]))
    panels = [(group, frame[frame["group"] == group]) for group in GROUPS]
    panels = [(group, part) for group, part in panels if len(part)]
    # the panel with the names of unknowns gets more room for each setting
    widths = [part["setting"].nunique() * (1.5 if group != LATIN_HYPERCUBE else 1) for group, part in panels]
    figure = style.new_figure(style.SLIDE_WIDTH, 7.6)
    axes = figure.subplots(1, len(panels), sharey=True, width_ratios=widths, squeeze=False)[0]
    for ax, (group, part) in zip(axes, panels, strict=True):
        _panel(ax, part, claims)
        number = part["setting"].nunique()
        if group == REFERENCE:
            ax.set_xticks([(number - 1) / 2], [f"reference × {number}"], rotation=90, fontsize=11.5)
        elif group == ONE_AT_A_TIME:
            _name_unknowns(ax, part, unknowns)
            ax.set_title(f"one unknown moved ({number} settings)", fontsize=14, loc="center")
        else:
            ax.set_title(f"all moved at once ({number} settings)", fontsize=14, loc="center")
            ax.set_xlabel("settings of the Latin hypercube, by mean score", fontsize=12)
            _shares(ax, part, claims)
    axes[0].set_yticks(range(len(claims)), claims, fontsize=11.5)
    shown = [verdict for verdict in VERDICTS if (frame["verdict"] == verdict).any()]
    figure.legend(
        handles=[Patch(facecolor=COLOURS[verdict], label=verdict) for verdict in shown],
        loc="outside upper center",
        ncols=len(shown),
        fontsize=14,
        handlelength=1.2,
        handleheight=1.2,
    )
    return figure


def _panel(ax: Axes, part: pd.DataFrame, claims: list[str]) -> None:
    settings = list(dict.fromkeys(part["setting"]))
    table = part.pivot(index="claim", columns="setting", values="verdict").loc[claims, settings]
    codes = table.map(VERDICTS.index).to_numpy()
    ax.imshow(
        codes,
        cmap=ListedColormap([COLOURS[verdict] for verdict in VERDICTS]),
        vmin=0,
        vmax=len(VERDICTS) - 1,
        aspect="auto",
        interpolation="nearest",
    )
    ax.grid(False)
    ax.set_yticks(np.arange(len(claims) + 1) - 0.5, minor=True)
    ax.grid(axis="y", which="minor", color="white", linewidth=1.4)
    ax.tick_params(which="both", length=0)
    ax.set_xticks([])
    for spine in ax.spines.values():
        spine.set_visible(False)


def _name_unknowns(ax: Axes, part: pd.DataFrame, unknowns: Mapping[str, Unknown]) -> None:
    keys = part.drop_duplicates("setting")["unknown"].tolist()
    starts = [index for index, key in enumerate(keys) if index == 0 or key != keys[index - 1]]
    middles = [(start + end - 1) / 2 for start, end in zip(starts, [*starts[1:], len(keys)], strict=True)]
    for start in starts[1:]:
        ax.axvline(start - 0.5, color="white", linewidth=2)
    labels = [unknowns[keys[start]].symbol if keys[start] in unknowns else keys[start] for start in starts]
    ax.set_xticks(_apart(middles, LABEL_WIDTH), labels, rotation=90, fontsize=11.5)


def _apart(places: list[float], least: float) -> np.ndarray:
    """Move places that are closer than ``least`` apart; they stay in order, and others where they are."""
    steps = least * np.arange(len(places))
    shifted = np.array(places) - steps
    pushed_right, pushed_left = np.maximum.accumulate(shifted), np.minimum.accumulate(shifted[::-1])[::-1]
    return (pushed_right + pushed_left) / 2 + steps


def _shares(ax: Axes, part: pd.DataFrame, claims: list[str]) -> None:
    """Write the share of the settings in which the claim is reproduced at the right edge."""
    share = part.assign(holds=part["verdict"] == REPRODUCED).groupby("claim")["holds"].mean()
    twin = ax.secondary_yaxis("right")
    twin.set_yticks(range(len(claims)), [percent(round(share[claim], 2)) for claim in claims], fontsize=11.5)
    twin.tick_params(length=0)
    twin.spines["right"].set_visible(False)
    ax.annotate(
        "repro-\nduced",
        (1, 0),
        (4, -4),
        xycoords="axes fraction",
        textcoords="offset points",
        fontsize=10.5,
        va="top",
        color=style.MUTED,
        annotation_clip=False,
    )
