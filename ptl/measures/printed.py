"""Printed tables, typed in by hand: the form of the file, its template and its reader.

The file is CSV in UTF-8, a row for each cell, columns `COLUMNS` in any order; ``sd`` may be left out. Lines that begin
with ``#`` are comments. A cell whose number is empty is not scored, so that a part of the tables can be typed in.
"""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Iterable, Iterator
from pathlib import Path

import pandas as pd

from ptl.errors import UserError
from ptl.files.regular import NotReadable, read_bytes
from ptl.keys import shortened
from ptl.measures.scoring import CELL, MEAN, SD, STATISTICS, template_rows

COLUMNS = (*CELL, *STATISTICS)
COMMENT = "#"

MAX_BYTES = 2**24
"""Maximum size of a file of printed values (ours)."""

NUMBER = re.compile(r"[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]{1,2})?")

EXPLANATION = """\
# Type the printed mean and standard deviation (sd) of a cell into its last two columns, with a decimal point and
# without separators of thousands (47784, 0.91). A cell that is left empty is not scored. transfer_ratio is positive
# where transfer saves steps; jump_start counts steps saved in the first episode, first_episode the steps of that
# episode. Measures in percent of the base and ratios of means have no sd.
"""


def template(predictions: pd.DataFrame) -> str:
    """Return the text of an empty file with all cells of predictions."""
    rows = [COLUMNS, *((*cell, "", "") for cell in template_rows(predictions))]
    return EXPLANATION + "".join(f"{','.join(row)}\n" for row in rows)


def read_printed(path: str | Path, predictions: pd.DataFrame) -> pd.DataFrame:
    """Read printed values.

    Parameters
    ----------
    predictions : DataFrame
        Columns `ptl.measures.scoring.PREDICTION_COLUMNS`; their cells are the known ones.

    Returns
    -------
    DataFrame
        Columns `COLUMNS`, a row for each cell with a number; a missing number is NaN.

    Raises
    ------
    UserError
        One line with the file, the line, the value and what is allowed.
    """
    lines = _lines(path)
    header = next(lines, (0, []))[1]
    wanted = COLUMNS if SD in header else COLUMNS[:-1]
    for name in wanted:
        if header.count(name) != 1:
            fault = "no column" if name not in header else "more than one column"
            raise UserError(f"{path}: {fault} {name!r}; give the columns {','.join(COLUMNS)}, separated by commas")
    known = set(predictions[[*CELL, "statistic"]].itertuples(index=False, name=None))
    cells = {names[:-1] for names in known}
    found: dict[tuple[str, ...], tuple[float, float]] = {}
    for line, row in lines:
        if len(row) != len(header):
            raise UserError(
                f"{path}: line {line}: has {len(row)} values for {len(header)} columns; numbers take a decimal point"
            )
        values = dict(zip(header, row, strict=True))
        cell = tuple(values[name] for name in CELL)
        if cell not in cells:
            raise UserError(f"{path}: line {line}: {_nearest(cell, cells)}")
        if cell in found:
            raise UserError(f"{path}: line {line}: {_named(cell)} is given again; give each cell once")
        mean, sd = (_number(path, line, name, values.get(name, "")) for name in STATISTICS)
        if not math.isnan(sd) and (*cell, SD) not in known:
            raise UserError(f"{path}: line {line}: {_named(cell)} has no sd; leave it empty")
        found[cell] = mean, sd
    rows = [(*cell, *numbers) for cell, numbers in found.items() if not all(map(math.isnan, numbers))]
    if not rows:
        raise UserError(f"{path}: has no printed value; type some into the columns {MEAN} and {SD}")
    return pd.DataFrame(rows, columns=list(COLUMNS))


def _lines(path: str | Path) -> Iterator[tuple[int, list[str]]]:
    """Yield line number and values of each line that is neither empty nor a comment."""
    try:
        text = read_bytes(path, MAX_BYTES).decode("utf-8-sig")
    except NotReadable as error:
        raise UserError(f"{path}: cannot be read ({error.reason}); give a CSV file, see 'ptl score --help'") from error
    except UnicodeDecodeError as error:
        raise UserError(f"{path}: is not UTF-8 text (byte {error.start}); save it as CSV in UTF-8") from error
    reader = csv.reader(io.StringIO(text, newline=""), strict=True)
    try:
        for row in reader:
            values = [value.strip() for value in row]
            if any(values) and not values[0].startswith(COMMENT):
                yield reader.line_num, values
    except csv.Error as error:
        raise UserError(f"{path}: line {reader.line_num}: is not CSV ({error}); correct the line") from error


def _number(path: str | Path, line: int, name: str, text: str) -> float:
    """Return a number, NaN for an empty text."""
    if not text:
        return math.nan
    plain = text.replace("−", "-")  # as printed
    if not NUMBER.fullmatch(plain):
        raise UserError(
            f"{path}: line {line}: {name} {shortened(text)!r} is not allowed; give a number with a decimal point and"
            " without separators or units, such as 47784 or 0.91"
        )
    if name == SD and float(plain) < 0:
        raise UserError(f"{path}: line {line}: sd {shortened(text)!r} is negative; give the standard deviation")
    return float(plain)


def _named(cell: Iterable[str]) -> str:
    return ", ".join(f"{name} {shortened(value)!r}" for name, value in zip(CELL, cell, strict=True))


def _nearest(cell: tuple[str, ...], cells: set[tuple[str, ...]]) -> str:
    """Describe an unknown cell by the first of its names that does not fit those before it."""
    candidates = cells
    for place, (name, value) in enumerate(zip(CELL, cell, strict=True)):
        rest = {own for own in candidates if own[place] == value}
        if not rest:
            names = ", ".join(sorted({own[place] for own in candidates}))
            before = f" of {_named_first(cell, place)}" if place else ""
            return f"{name} {shortened(value)!r}{before} is not in the predictions; give one of {names}"
        candidates = rest
    raise AssertionError(cell)


def _named_first(cell: tuple[str, ...], number: int) -> str:
    return ", ".join(f"{name} {value}" for name, value in zip(CELL[:number], cell, strict=False))
