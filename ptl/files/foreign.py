"""Results of other programs: a table of steps per episode, checked as a whole before anything is learned.

The table is CSV with one row an episode and the columns `COLUMNS`, in any order; ``truncated`` (0 or 1) may be left out
if every episode reached its goal. A method has every task of each environment that it names, and of each task exactly
the seeds (0, 1, ...) and episodes (1, 2, ...) of the run, because measures compare seed by seed with the base.
"""

from __future__ import annotations

import csv
import stat
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ptl.errors import UserError
from ptl.keys import shortened
from ptl.world.gridworld import GridWorld

COLUMNS = ("environment", "method", "task", "seed", "episode", "steps")
OPTIONAL = "truncated"

LARGEST = 2**30
"""Bytes of the largest table that is read (ours)."""

WHOLE = frozenset("0123456789")


@dataclass(frozen=True)
class Expected:
    """What the table of a run must hold.

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
        One line with the file, the line or the place in the table, and what is wrong.
    """
    steps: dict[tuple[str, str], np.ndarray] = {}
    cut: dict[tuple[str, str], np.ndarray] = {}
    shortest: dict[tuple[str, str], int] = {}
    others: set[str] = set()
    for line, row in _rows(Path(path)):
        if row["method"] != method:
            others.add(shortened(row["method"]))
            continue
        place, seed, episode = _place(row, expected, f"{path}: line {line}")
        if place not in steps:
            world = expected.worlds[place[0]]
            steps[place] = np.zeros((expected.seeds, expected.episodes), dtype=np.int64)
            cut[place] = np.zeros((expected.seeds, expected.episodes), dtype=bool)
            shortest[place] = world.shortest_path_length(world.start, world.goal(place[1]))
        if steps[place][seed, episode]:
            raise UserError(f"{path}: line {line}: {_named(place, seed, episode)} is there twice; keep one of them")
        truncated = bool(_whole(row[OPTIONAL], OPTIONAL, 0, 1, f"{path}: line {line}")) if OPTIONAL in row else False
        least = 1 if truncated else shortest[place]
        steps[place][seed, episode] = _whole(
            row["steps"], "steps", least, expected.max_steps, f"{path}: line {line}", _named(place, seed, episode)
        )
        cut[place][seed, episode] = truncated
    if not steps:
        there = f"; there are {', '.join(sorted(others)[:8])}" if others else ""
        raise UserError(f"{path}: has no row of method {method}{there}")
    return dict(_complete(path, method, steps, cut, expected))


def _rows(path: Path) -> Iterator[tuple[int, dict[str, str]]]:
    """Yield the number and the cells of each row below the header."""
    try:
        status = path.stat()
        if not stat.S_ISREG(status.st_mode):
            raise UserError(f"{path}: is no file; give a CSV table")
        if status.st_size > LARGEST:
            raise UserError(f"{path}: {status.st_size:,} bytes are more than the {LARGEST:,} that are read; shorten it")
        with path.open(encoding="utf-8-sig", newline="") as file:
            table = csv.reader(file, strict=True)
            header = next(table, [])
            wanted = {*COLUMNS}
            if len(set(header)) != len(header) or {*header} - {OPTIONAL} != wanted:
                raise UserError(
                    f"{path}: the columns {shortened(','.join(header))!r} are not allowed; give {','.join(COLUMNS)},"
                    f" each once, and {OPTIONAL} if episodes were cut off"
                )
            for cells in table:
                if len(cells) != len(header):
                    raise UserError(
                        f"{path}: line {table.line_num}: {len(cells)} cells where the header has {len(header)}"
                    )
                yield table.line_num, dict(zip(header, cells, strict=True))
    except OSError as error:
        raise UserError(f"{path}: cannot be read ({error.strerror}); check the path") from error
    except UnicodeDecodeError as error:
        raise UserError(f"{path}: is not UTF-8 text ({error.reason}); save it as plain text") from error
    except csv.Error as error:
        raise UserError(f"{path}: line {table.line_num}: is not CSV ({error}); correct it there") from error


def _place(row: Mapping[str, str], expected: Expected, where: str) -> tuple[tuple[str, str], int, int]:
    environment, task = row["environment"], row["task"]
    if environment not in expected.tasks:
        raise UserError(
            f"{where}: environment {shortened(environment)!r} is not in this run; give one of"
            f" {', '.join(expected.tasks)}"
        )
    if len(task) != 1 or task not in expected.tasks[environment]:
        raise UserError(
            f"{where}: {shortened(task)!r} is no task of {environment}; give one of {expected.tasks[environment]}"
        )
    seed = _whole(row["seed"], "seed", 0, expected.seeds - 1, where)
    return (environment, task), seed, _whole(row["episode"], "episode", 1, expected.episodes, where) - 1


def _whole(text: str, name: str, least: int, most: int, where: str, about: str = "") -> int:
    if not (0 < len(text) <= 18 and WHOLE.issuperset(text) and least <= (value := int(text)) <= most):
        about = f" ({about})" if about else ""
        raise UserError(
            f"{where}: {name} {shortened(text)!r} is not allowed{about}; give a whole number from {least} to {most}"
        )
    return value


def _named(place: tuple[str, str], seed: int, episode: int) -> str:
    return f"environment {place[0]}, task {place[1]}, seed {seed}, episode {episode + 1}"


def _complete(
    path: str | Path,
    method: str,
    steps: Mapping[tuple[str, str], np.ndarray],
    cut: Mapping[tuple[str, str], np.ndarray],
    expected: Expected,
) -> Iterator[tuple[tuple[str, str], ForeignSteps]]:
    """Yield the runs in the order of the tasks; refuse what is missing."""
    named = {environment for environment, _ in steps}
    for environment, tasks in expected.tasks.items():
        for task in tasks if environment in named else "":
            place = environment, task
            if place not in steps:
                raise UserError(f"{path}: method {method} has no task {task} of environment {environment}; add it")
            missing = np.argwhere(steps[place] == 0)
            if len(missing):
                raise UserError(
                    f"{path}: method {method}: {_named(place, *missing[0])} is missing, and {len(missing) - 1} more of"
                    f" this task; the run has seeds 0 to {expected.seeds - 1} and episodes 1 to {expected.episodes}"
                )
            yield place, ForeignSteps(steps[place], cut[place].sum(axis=1))
