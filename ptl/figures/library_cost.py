"""What the skill library costs: time of one skill selection, and room in memory or on disk."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from ptl.errors import UserError
from ptl.figures import style
from ptl.files import read_csv

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SELECTION_COLUMNS = ("skills", "seconds")
STORAGE_COLUMNS = ("states", "skills", "bytes")
MICROSECONDS = 1e6
KIBIBYTE = 1024


def read(path: str | Path, columns: Sequence[str]) -> pd.DataFrame:
    """Read these columns of a CSV file, all of them positive numbers."""
    frame = read_csv(path)
    for column in columns:
        if column not in frame:
            raise UserError(f"{path}: no column {column!r}; the columns must be {', '.join(columns)}")
        if not pd.api.types.is_numeric_dtype(frame[column]) or not (frame[column] >= 0).all():
            raise UserError(f"{path}: column {column!r} holds something that is not a number from 0 up; make it again")
    return frame[list(columns)]


def cost_frame(selection: pd.DataFrame, storage: pd.DataFrame) -> pd.DataFrame:
    """The plotted numbers.

    Columns kind (selection or storage), states, skills, seconds (median of the repetitions), fit
    (least-squares line through all repetitions, seconds), seconds_per_skill (its slope), bytes.
    """
    if selection["skills"].nunique() < 2:
        raise UserError("time of a selection: a line needs two library sizes; measure another size")
    slope, intercept = np.polyfit(selection["skills"], selection["seconds"], 1)
    times = selection.groupby("skills", as_index=False)["seconds"].median()
    times = times.assign(kind="selection", fit=intercept + slope * times["skills"], seconds_per_skill=slope)
    frame = pd.concat([times, storage.assign(kind="storage")], ignore_index=True)
    frame = frame[["kind", "states", "skills", "seconds", "fit", "seconds_per_skill", "bytes"]]
    return frame.astype({"states": "Int64", "skills": "Int64", "bytes": "Int64"})


@style.styled
def draw(frame: pd.DataFrame) -> Figure:
    """Left: time of a selection and its line. Right: size of libraries, one line per number of states."""
    figure = style.new_figure(style.SLIDE_WIDTH, 5.8)
    left, right = figure.subplots(1, 2, width_ratios=[1, 1.08])
    _selection(left, frame[frame["kind"] == "selection"])
    _storage(right, frame[frame["kind"] == "storage"])
    return figure


def _selection(axes: Axes, part: pd.DataFrame) -> None:
    slope = MICROSECONDS * float(part["seconds_per_skill"].iloc[0])
    skills, times = part["skills"].astype(float), MICROSECONDS * part["seconds"]
    (dots,) = axes.plot(skills, times, "o", color=style.ACCENT, markersize=9, clip_on=False, zorder=3)
    (line,) = axes.plot(skills, MICROSECONDS * part["fit"], color=style.INK, linewidth=2)
    axes.set(xlim=(0, None), ylim=(0, None))
    axes.set(xlabel="skills in the library", ylabel="CPU time of one selection, µs")
    axes.set_title("Time of a skill selection")
    axes.legend([dots, line], ["measured", f"line: {slope:.2g} µs per skill"], loc="upper left")


def _storage(axes: Axes, part: pd.DataFrame) -> None:
    groups = list(part.groupby("states"))
    shades = style.HEAT(np.linspace(0.45, 1.0, len(groups)))
    for shade, (states, library) in zip(shades, groups, strict=True):
        library = library.sort_values("skills")
        kibibytes = library["bytes"].astype(float) / KIBIBYTE
        axes.plot(library["skills"].astype(float), kibibytes, "o-", color=shade, markersize=7, label=str(states))
    axes.set(xlim=(0, None), ylim=(0, None), xlabel="skills in the library", ylabel="size of the library, KiB")
    axes.set_title("Room for the library")
    # the largest line comes first, as in the picture
    lines, labels = axes.get_legend_handles_labels()
    axes.legend(lines[::-1], labels[::-1], title="states", title_fontsize=15, loc="upper left")
