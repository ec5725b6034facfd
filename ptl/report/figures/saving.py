"""The files of a figure: PNG, SVG and the numbers that it shows."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from matplotlib.artist import Artist
from matplotlib.axis import Tick
from matplotlib.figure import Figure
from matplotlib.text import Text

from ptl.errors import UserError
from ptl.files.atomic import atomic_path
from ptl.files.csv import write_csv
from ptl.report.figures.style import styled

if TYPE_CHECKING:
    import pandas as pd

PNG_RESOLUTION = 200
"""Dots per inch of the PNG files."""


@styled
def save(figure: Figure, frame: pd.DataFrame, path: str | os.PathLike[str]) -> None:
    """Write a figure as PNG and SVG and the numbers it shows as CSV, all three with the same name.

    The files carry no date and no version, so the same inputs give the same bytes.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
    frame : pandas.DataFrame
        The plotted numbers, tidy.
    path : path
        Name of the PNG file; the twins get the suffixes ``.svg`` and ``.csv``.

    Raises
    ------
    UserError
        When the name does not end in ``.png`` or a file cannot be written.
    """
    path = Path(path)
    if path.suffix != ".png":
        raise UserError(f"{path}: a figure is written as PNG (with an SVG and a CSV beside it); end the name in .png")
    for words in _words(figure):
        words.set_parse_math(False)
    with atomic_path(path) as png, atomic_path(path.with_suffix(".svg")) as svg:
        figure.savefig(png, dpi=PNG_RESOLUTION, metadata={"Software": None})
        figure.set_layout_engine("none")  # the second file keeps the layout just computed
        figure.savefig(svg, metadata={"Date": None, "Creator": None})
        write_csv(frame, path.with_suffix(".csv"))


def _words(artist: Artist) -> Iterator[Text]:
    """Yield the texts of a figure apart from the marks of its axes: a dollar sign in a title starts no formula."""
    if isinstance(artist, Text):
        yield artist
    for child in artist.get_children():
        if not isinstance(child, Tick):
            yield from _words(child)
