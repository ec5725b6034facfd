"""The one model of a table, and its files as HTML, Markdown, LaTeX and CSV."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import groupby, pairwise
from pathlib import Path

import pandas as pd

from ptl.files.atomic import write_text
from ptl.files.csv import write_csv
from ptl.report.templating import render


@dataclass(frozen=True)
class Column:
    """A column of a table; neighbours with the same heading share it."""

    heading: str
    unit: str = ""
    is_text: bool = False

    @property
    def full_heading(self) -> str:
        """Heading and unit in one line."""
        return f"{self.heading} ({self.unit})" if self.unit else self.heading


@dataclass(frozen=True)
class Cell:
    """The text of a cell, a second line in small type, and whether it is the best of its column or an aside.

    Text in a column of words may have several lines.
    """

    text: str
    detail: str = ""
    best: bool = False
    aside: bool = False


@dataclass(frozen=True)
class Row:
    """A row with its label, a cell for each column, and the colour of a dot before the label."""

    label: str
    cells: Sequence[Cell]
    colour: str = ""

    @property
    def has_details(self) -> bool:
        """Whether a cell has a second line."""
        return any(cell.detail for cell in self.cells)


@dataclass(frozen=True)
class RowGroup:
    """Rows under one heading; ``name`` is its short form for formats without headings."""

    rows: Sequence[Row]
    heading: str = ""
    name: str = ""


@dataclass(frozen=True)
class Table:
    """A table before it takes the form of a format.

    Attributes
    ----------
    title, intro : str
    corner : str
        Heading of the labels of rows.
    columns : sequence of Column
    groups : sequence of RowGroup
    notes : sequence of str
    number : int, optional
        Number in the article.
    group_heading : str
        Heading of the names of groups, in Markdown.
    """

    title: str
    intro: str
    corner: str
    columns: Sequence[Column]
    groups: Sequence[RowGroup]
    notes: Sequence[str] = ()
    number: int | None = None
    group_heading: str = ""

    @property
    def name(self) -> str:
        """Name of its files without the suffix."""
        return f"table{self.number}"

    @property
    def full_title(self) -> str:
        """Title with the number."""
        return self.title if self.number is None else f"Table {self.number}. {self.title}"

    @property
    def has_groups(self) -> bool:
        """Whether groups have names."""
        return any(group.name for group in self.groups)

    @property
    def has_units(self) -> bool:
        """Whether columns have units, in a second line of headings."""
        return any(column.unit for column in self.columns)

    @property
    def headings(self) -> list[tuple[str, list[Column]]]:
        """Headings with the neighbouring columns that share them."""
        return [(heading, list(part)) for heading, part in groupby(self.columns, key=lambda column: column.heading)]

    @property
    def spans(self) -> list[tuple[int, int]]:
        """First and last column of each heading, counted from 2 (the labels are column 1)."""
        ends = [1]
        for _, columns in self.headings:
            ends.append(ends[-1] + len(columns))
        return [(before + 1, last) for before, last in pairwise(ends)]

    @property
    def all_notes(self) -> list[str]:
        """The introduction and the notes."""
        return [self.intro, *self.notes]


def text_table(
    title: str,
    intro: str,
    headings: Sequence[str],
    rows: Iterable[Sequence[str]],
    notes: Sequence[str] = (),
    text_columns: Iterable[str] = (),
) -> Table:
    """Make a table of ready texts; the first text of a row is its label.

    Parameters
    ----------
    headings : sequence of str
        The first heads the labels.
    text_columns : iterable of str
        Headings of columns of words rather than numbers.
    """
    words = set(text_columns)
    columns = [Column(heading, is_text=heading in words) for heading in headings[1:]]
    body = [Row(label, [Cell(text) for text in texts]) for label, *texts in rows]
    return Table(title, intro, headings[0], columns, [RowGroup(body)], notes)


def to_html(table: Table) -> str:
    """Render a page without scripts or other files; light and dark, and a wide table scrolls."""
    return render("table.html", table=table, title=table.full_title)


def to_markdown(table: Table) -> str:
    """Render a pipe table with the notes below."""
    return render("table.md", table=table).rstrip("\n") + "\n"


def to_latex(table: Table) -> str:
    """Render a longtable with booktabs rules; the second line of a row holds the details of its cells."""
    return render("table.tex", table=table)


RENDERERS = {".html": to_html, ".md": to_markdown, ".tex": to_latex}


def write(table: Table, path: Path, numbers: pd.DataFrame, formats: Sequence[str] = (".html", ".md")) -> None:
    """Write a table in some formats, and its numbers as CSV, all with the name of ``path`` and their own suffix."""
    for suffix in formats:
        write_text(path.with_suffix(suffix), RENDERERS[suffix](table))
    write_csv(numbers, path.with_suffix(".csv"))
