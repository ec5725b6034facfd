"""Results of other programs: a table of steps per episode, checked as a whole before anything is learned.

The table is CSV, separated by commas, semicolons or tabs, with one row an episode and the columns `COLUMNS`, in any
order; ``truncated`` (0 or 1) may be left out if every episode reached its goal. A truncated episode has the run's
maximum number of steps: with fewer it would count as one that reached its goal. A method has every task of each
environment that it names, and of each task exactly the episodes (1, 2, ...) of the run and as many seeds. Seeds may
have any names; those that are not 0, 1, ... are numbered in the natural order of their names.
"""

from __future__ import annotations

import io
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ptl.errors import UserError
from ptl.files.regular import NotReadable, read_bytes
from ptl.keys import shortened
from ptl.world.gridworld import GridWorld

if TYPE_CHECKING:
    import pandas as pd

COLUMNS = ("environment", "method", "task", "seed", "episode", "steps")
OPTIONAL = "truncated"

MAX_BYTES = 2**30
"""Maximum size of a table that is read (ours)."""


@dataclass(frozen=True)
class Expected:
    """The episodes that a table must have.

    Attributes
    ----------
    worlds : mapping of str to GridWorld
        The environments of the run.
    tasks : mapping of str to str
        Goal letters of each environment, in the order in which they are learned.
    seeds, episodes : int
        Runs, and episodes of each task.
    max_steps : int
        Steps after which an episode is truncated.
    """

    worlds: Mapping[str, GridWorld]
    tasks: Mapping[str, str]
    seeds: int
    episodes: int
    max_steps: int


@dataclass(frozen=True)
class ForeignSteps:
    """Runs of a method on one task: int64 (seeds, episodes), and the number of truncated episodes, (seeds,)."""

    steps: np.ndarray
    truncated: np.ndarray


def read_foreign(path: str | Path, method: str, expected: Expected) -> dict[tuple[str, str], ForeignSteps]:
    """Read the runs of one method from a table; rows of other methods are skipped.

    Returns
    -------
    dict
        (environment, task) to its runs, in the order of ``expected``.

    Raises
    ------
    UserError
        One line with the file, the line and column or the episode, and the value and what is allowed.
    """
    table = _read(Path(path))
    names = map(shortened, sorted(table["method"].unique())[:8])
    table = table[table["method"] == method]
    if table.empty:
        raise UserError(f"{path}: has no row of method {method}; there are {', '.join(names) or 'none'}")

    def refuse(wrong: pd.Series, column: str, wanted: str) -> None:
        if wrong.any():
            row = table.loc[line := wrong.idxmax()]
            about = f" (task {row['task']} of {row['environment']})" if column == "steps" else ""
            value = shortened(row[column])
            raise UserError(f"{path}: line {line}: {column} {value!r} is not allowed{about}; give {wanted}")

    def whole(column: str, low: int, high: int) -> pd.Series:
        digits = table[column].map(whole_number)
        wrong = digits == ""
        values = digits.mask(wrong, "0").astype(np.int64)
        refuse(wrong | ~values.between(low, high), column, f"a whole number from {low} to {high}")
        return values

    refuse(~table["environment"].isin([*expected.tasks]), "environment", f"one of {', '.join(expected.tasks)}")
    refuse(table["seed"].str.strip() == "", "seed", "a number or a name")
    numbers = numbers_of_seeds(table["seed"], expected.seeds)
    if len(numbers) > expected.seeds:
        raise UserError(
            f"{path}: method {method}: has {len(numbers)} seeds ({shortened(', '.join(numbers))}), and the run has"
            f" {expected.seeds}; give as many"
        )
    seed, episode = table["seed"].map(numbers), whole("episode", 1, expected.episodes)
    steps, truncated = whole("steps", 1, expected.max_steps), whole(OPTIONAL, 0, 1) == 1
    limit = f"{expected.max_steps}, the run's learning.max_steps, for a truncated episode"
    refuse(truncated & (steps < expected.max_steps), "steps", limit)
    runs = {}
    for environment, tasks in expected.tasks.items():
        world, there = expected.worlds[environment], table["environment"] == environment
        refuse(there & ~table["task"].isin([*tasks]), "task", f"one of {', '.join(tasks)}")
        for task in tasks if there.any() else "":
            rows = there & (table["task"] == task)
            shortest = world.shortest_path_length(world.start, world.goal(task))
            refuse(rows & ~truncated & (steps < shortest), "steps", f"at least the shortest path, {shortest}")
            counts = np.zeros((expected.seeds, expected.episodes), dtype=np.int64)
            np.add.at(counts, (seed[rows], episode[rows] - 1), 1)
            for wrong, fault in ((counts > 1, "given more than once"), (counts == 0, "missing")):
                if wrong.any():
                    first = np.argwhere(wrong)[0]
                    raise UserError(
                        f"{path}: method {method}, environment {environment}, task {task}: seed {first[0]}, episode"
                        f" {first[1] + 1} is {fault}, and {wrong.sum() - 1} more; give {expected.seeds} seeds, say 0 to"
                        f" {expected.seeds - 1}, and episodes 1 to {expected.episodes}, each once"
                    )
            ordered = np.empty_like(counts)
            ordered[seed[rows], episode[rows] - 1] = steps[rows]
            cut = np.bincount(seed[rows & truncated], minlength=expected.seeds)
            runs[environment, task] = ForeignSteps(ordered, cut)
    return runs


def seeds_of(path: str | Path, method: str, seeds: int) -> dict[str, int]:
    """Return the number of each seed of a method by its name; empty if the names are the numbers."""
    table = _read(Path(path))
    numbers = numbers_of_seeds(table.loc[table["method"] == method, "seed"], seeds)
    return {} if all(name == str(number) for name, number in numbers.items()) else numbers


def numbers_of_seeds(names: pd.Series, seeds: int | None = None) -> dict[str, int]:
    """Number the names of seeds in natural order; if all are numbers below ``seeds``, they stay what they are."""
    distinct = sorted(names.unique(), key=natural)
    whole = [whole_number(name) for name in distinct]
    if seeds is not None and all(number and int(number) < seeds for number in whole):
        return {name: int(number) for name, number in zip(distinct, whole, strict=True)}
    return {name: place for place, name in enumerate(distinct)}


def natural(name: str | os.PathLike[str]) -> list[Any]:
    """Return a key that sorts names with numbers as people do: seed_2 before seed_10."""
    parts = re.split("([0-9]+)", os.fspath(name))
    return [int(part) if place % 2 else part for place, part in enumerate(parts)]


def as_text(value: Any) -> str:
    """Return a cell as text."""
    return value if isinstance(value, str) else repr(value)


def whole_number(cell: str) -> str:
    """Return the digits of a cell that is a whole number as programs write it (40, 40.0, 40,0, False), or nothing.

    1.000 and 1,000 are refused, which mean 1 to some and 1000 to others.
    """
    text = cell.strip()
    if text in ("True", "False"):
        return str(int(text == "True"))
    match = re.fullmatch(r"(?:np\.u?int[0-9]+\()?([0-9]{1,18})(?:[.,](?!000$)0*)?\)?", text)
    return match[1] if match else ""


def read_cells(path: Path, **options: Any) -> pd.DataFrame:
    """Return the cells of a CSV file as texts, its header in row 0; ``options`` go to pandas.

    Cells are separated by commas, or by the semicolons or tabs of the header; Excel's line ``sep=;`` is left out.

    Raises
    ------
    UserError
        If it cannot be read, is not UTF-8, or a row has more cells than the header; shorter ones get empty cells.
    """
    import pandas as pd  # slow to import, and most configurations name no such table

    try:
        text = read_bytes(path, MAX_BYTES).decode("utf-8-sig")
        if text.lstrip()[:1] in ("<", "{"):
            raise UserError(f"{path}: is {'HTML or XML' if text.lstrip()[0] == '<' else 'JSON'}; give a CSV table")
        text = re.sub(r'\A"?sep=[,;\t]"?\r?\n', "", text)
        header = text.partition("\n")[0]
        return pd.read_csv(
            io.StringIO(text), sep=max(",;\t", key=header.count), header=None, dtype=str, na_filter=False,
            skipinitialspace=True, **options,
        )  # fmt: skip
    except NotReadable as error:
        raise UserError(f"{path}: cannot be read ({error.reason}); give a CSV table") from error
    except UnicodeDecodeError as error:
        raise UserError(f"{path}: byte {error.start + 1} is not UTF-8 text; save it as UTF-8") from error
    except ValueError as error:  # pandas' own errors are ValueErrors
        fault = " ".join(str(error).split())
        raise UserError(f"{path}: is no table ({fault}); correct it, or make one with 'ptl import-runs'") from error


def _read(path: Path) -> pd.DataFrame:
    """Return the cells of a table as texts, indexed by line number; ``truncated`` is 0 if it is left out.

    A first column without a name, such as the index that pandas writes, is left out.
    """
    table = read_cells(path, skip_blank_lines=False)
    if table.iloc[0, 0] in ("", "Unnamed: 0"):
        table = table.iloc[:, 1:]
    header = table.iloc[0].tolist()
    if sorted({*header} - {OPTIONAL}) != sorted(COLUMNS) or len({*header}) != len(header):
        raise UserError(
            f"{path}: the columns {shortened(','.join(header))!r} are not allowed; give {','.join(COLUMNS)}, each once,"
            f" and {OPTIONAL} if episodes were cut off; 'ptl import-runs' makes such a table"
        )
    table = table.iloc[1:].set_axis(header, axis="columns").set_axis(range(2, len(table) + 1))
    return table if OPTIONAL in table else table.assign(**{OPTIONAL: "0"})
