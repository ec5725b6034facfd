"""Readings: what the words of the article leave open, and what a claim is therefore judged under."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from typing import Any, NamedTuple

TRANSFER_TASKS, LAST_TASK = "BCDEF", "F"
"""Tasks with something to transfer, those of the tables; and the one of the article's curves."""

ARTICLE_RUNS = 30
"""Runs behind the article's statements on significance (stated)."""


class Reading(NamedTuple):
    """One way to read the article's words.

    Attributes
    ----------
    tasks : str
        What a claim that names no task is about: the letter of one task, or several tasks added up.
    tolerance : int
        Steps from a place that still count as "at" it.
    runs : int or None
        Number of runs of which "not significant" speaks; None: as many as there are.
    """

    tasks: str = LAST_TASK
    tolerance: int = 1
    runs: int | None = None


DEFAULT = Reading()
"""The reading of the run's ledger (chosen)."""

VALUES: dict[str, tuple[Any, ...]] = {
    "tasks": (*TRANSFER_TASKS, TRANSFER_TASKS),
    "tolerance": (0, 1, 2),
    "runs": (ARTICLE_RUNS, None),
}
"""Values of each field of a reading."""


def readings(fields: tuple[str, ...]) -> Iterator[Reading]:
    """Yield the readings that differ in some fields, the others as they are by default."""
    for values in product(*(VALUES[field] for field in fields)):
        yield DEFAULT._replace(**dict(zip(fields, values, strict=True)))


def tasks_text(tasks: str) -> str:
    """Return how a sentence names one task or several together."""
    return f"task {tasks}" if len(tasks) == 1 else f"tasks {tasks[0]} to {tasks[-1]} together"
