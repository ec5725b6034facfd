"""Cost of a skill library: operations of one skill selection, and size in memory or on disk."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from ptl.errors import UserError
from ptl.measures.run_files import read_selection, read_storage
from ptl.report.figures import style
from ptl.text import number

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ptl.report.script import Script

KIBIBYTE = 1024


def make(script: Script) -> tuple[Figure, pd.DataFrame]:
    """Draw the cost of a selection and the size of libraries."""
    frame = cost_frame(read_selection(script.input.selection_cost), read_storage(script.input.library_bytes))
    return draw(frame), frame


def cost_frame(selection: pd.DataFrame, storage: pd.DataFrame) -> pd.DataFrame:
    """Return the plotted numbers.

    Columns kind (selection or storage), states, skills, operations, fit (least-squares line, operations),
    operations_per_skill (its slope), bytes.
    """
    if selection["skills"].nunique() < 2:
        raise UserError("operations of a selection: a line needs two library sizes; count another size")
    slope, intercept = np.polyfit(selection["skills"], selection["operations"], 1)
    fit = intercept + slope * selection["skills"]
    counts = selection.assign(kind="selection", fit=fit, operations_per_skill=slope)
    frame = pd.concat([counts, storage.assign(kind="storage")], ignore_index=True)
    frame = frame[["kind", "states", "skills", "operations", "fit", "operations_per_skill", "bytes"]]
    return frame.astype(dict.fromkeys(("states", "skills", "operations", "bytes"), "Int64"))


@style.styled
def draw(frame: pd.DataFrame) -> Figure:
    """Draw the operations of a selection (left) and the size of libraries by number of states (right)."""
    figure = style.new_figure(style.SLIDE_WIDTH, 5.8)
    left, right = figure.subplots(1, 2, width_ratios=[1, 1.08])
    _selection(left, frame[frame["kind"] == "selection"])
    _storage(right, frame[frame["kind"] == "storage"])
    return figure


def _selection(axes: Axes, part: pd.DataFrame) -> None:
    slope = float(part["operations_per_skill"].iloc[0])
    skills, operations = part["skills"].astype(float), part["operations"].astype(float)
    (dots,) = axes.plot(skills, operations, "o", color=style.ACCENT, markersize=9, clip_on=False, zorder=3)
    (line,) = axes.plot(skills, part["fit"], color=style.INK, linewidth=2)
    axes.set(xlim=(0, None), ylim=(0, None))
    axes.set(xlabel="skills in the library", ylabel="operations of one selection")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter(style.GROUPED)
    axes.set_title("Cost of a skill selection")
    axes.legend([dots, line], ["counted", f"line: {number(slope)} operations a skill"], loc="upper left")


def _storage(axes: Axes, part: pd.DataFrame) -> None:
    groups = list(part.groupby("states"))
    shades = style.HEAT(np.linspace(0.45, 1.0, len(groups)))
    for shade, (states, library) in zip(shades, groups, strict=True):
        library = library.sort_values("skills")
        kibibytes = library["bytes"].astype(float) / KIBIBYTE
        axes.plot(library["skills"].astype(float), kibibytes, "o-", color=shade, markersize=7, label=number(states))
    axes.set(xlim=(0, None), ylim=(0, None), xlabel="skills in the library", ylabel="size of the library, KiB")
    axes.set_title("Size of the library")
    # the largest line comes first, as in the picture
    lines, labels = axes.get_legend_handles_labels()
    axes.legend(lines[::-1], labels[::-1], title="states", title_fontsize=15, loc="upper left")
