"""Steps per CPU second of the kernel, of other learners and of what bounds them, in one run on one task."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from ptl.benchmark.contestants import (
    BareWalk,
    BareWalkByTwos,
    GymnasiumLoop,
    Kernel,
    KernelEveryStep,
    Mdplib,
    NumbaLoop,
    PlainLoop,
    RandomWords,
    Timed,
)
from ptl.benchmark.task import Task

EPISODES = 200
"""Episodes of the task, as in the published run."""

SAMPLED_EVERY = 20
"""A learner too slow for the whole task runs every so many-th episode of it."""

LEAST_SECONDS = 0.25
"""CPU seconds of a measurement at least; a fast learner learns the task again and again."""


@dataclass(frozen=True)
class Entry:
    """A contestant with the workload on which it is timed.

    Attributes
    ----------
    label : str
    kind : type
        The contestant's class.
    workload : str
        ``whole`` task; ``sampled``, every twentieth episode from the Q that the kernel has there; or ``cold``,
        episodes with alpha = 0, so that Q stays zero and every episode follows the law of the first one.
    limit : str
        Label of the entry that bounds its speed, empty if none is given.
    """

    label: str
    kind: type[Timed]
    workload: str = "whole"
    limit: str = ""


BASE = "plain Python, one loop"
"""The entry whose rate is 1 in the column of ratios."""

LIMITS = (
    Entry("bare random walk, one step a look-up", BareWalk, "cold"),
    Entry("bare random walk, two steps a look-up", BareWalkByTwos, "cold"),
    Entry("random words of 64 bits", RandomWords),
)
"""What no learner of this kind can pass: look-ups that wait for each other, and random numbers."""

ONE, TWO = LIMITS[0].label, LIMITS[1].label

ENTRIES = (
    Entry("kernel, every step simulated", KernelEveryStep, limit=ONE),
    Entry("kernel, with the shortcut", Kernel, limit=TWO),
    Entry("kernel, every step simulated, while Q is zero", KernelEveryStep, "cold", ONE),
    Entry("kernel, with the shortcut, while Q is zero", Kernel, "cold", TWO),
    Entry("mdplib (C++), while Q is zero", Mdplib, "cold"),
    Entry("Numba, one loop", NumbaLoop),
    Entry(BASE, PlainLoop),
    Entry("Gymnasium and numpy", GymnasiumLoop, "sampled"),
)


def measure(
    task: Task,
    rounds: int,
    entries: Iterable[Entry] = ENTRIES + LIMITS,
    episodes: int = EPISODES,
    least_seconds: float = LEAST_SECONDS,
    say: Callable[[str], None] = lambda _: None,
) -> pd.DataFrame:
    """Time all entries in turn, round after round, so that other load on the machine affects all of them.

    ``say`` is called with a line at the start of each round.

    Returns
    -------
    DataFrame
        Columns ``round``, ``entry``, ``steps``, ``seconds`` (CPU time of this process).
    """
    stages = stages_of(task, episodes)
    rows = []
    for number in range(rounds):
        say(f"round {number + 1} of {rounds}")
        for entry in entries:
            steps, seconds = _time(entry, task, stages, number, episodes, least_seconds)
            rows.append({"round": number, "entry": entry.label, "steps": steps, "seconds": seconds})
    return pd.DataFrame(rows)


def stages_of(task: Task, episodes: int = EPISODES) -> list[np.ndarray]:
    """Return Q before every twentieth episode of a task as the kernel learns it."""
    kernel = KernelEveryStep(task, seed=0)
    stages = []
    for _ in range(0, episodes, SAMPLED_EVERY):
        stages.append(kernel.q)
        kernel.run(SAMPLED_EVERY)
    return stages


def _time(
    entry: Entry, task: Task, stages: list[np.ndarray], number: int, episodes: int, least_seconds: float
) -> tuple[int, float]:
    if entry.workload == "cold":
        task = replace(task, alpha=0.0)
    steps, seconds, seed = 0, 0.0, 1000 * number
    while seconds < least_seconds:
        if entry.workload == "sampled":
            jobs = [(entry.kind(task, seed + index, q), 1) for index, q in enumerate(stages)]
        else:
            jobs = [(entry.kind(task, seed), episodes)]
        for contestant, length in jobs:
            begin = time.process_time()
            steps += contestant.run(length)
            seconds += time.process_time() - begin
        seed += len(jobs)
    return steps, seconds


def summarise(measured: pd.DataFrame, base: str = BASE) -> pd.DataFrame:
    """Return rate and ratio to the base of every learner over the rounds.

    Returns
    -------
    DataFrame
        Columns ``item``, ``quantity`` (``steps per CPU second``, ``ratio to plain Python``), ``value`` (median over
        the rounds), ``low``, ``high`` (least and greatest), ``repeats``. A ratio compares the same round.
    """
    rates = _rates(measured)
    learners = [label for label in rates if label not in {entry.label for entry in LIMITS}]
    return pd.DataFrame(
        [
            row
            for label in learners
            for row in (
                _over_rounds(label, "steps per CPU second", rates[label]),
                _over_rounds(label, "ratio to plain Python", rates[label] / rates[base]),
            )
        ]
    )


def summarise_limits(measured: pd.DataFrame) -> pd.DataFrame:
    """Return the rates of the limits and the share of its limit that each kernel reaches; columns as `summarise`."""
    rates = _rates(measured)
    rows = [_over_rounds(entry.label, "per CPU second", rates[entry.label]) for entry in LIMITS]
    rows += [
        _over_rounds(entry.label, f"share of {entry.limit}", rates[entry.label] / rates[entry.limit])
        for entry in ENTRIES
        if entry.limit
    ]
    return pd.DataFrame(rows)


def _rates(measured: pd.DataFrame) -> pd.DataFrame:
    """Return steps per CPU second, a row for each round and a column for each entry in the order of the rounds."""
    rate = measured["steps"] / measured["seconds"]
    rates = measured.assign(rate=rate).pivot(index="round", columns="entry", values="rate")
    return rates[measured["entry"].unique()]


def _over_rounds(label: str, quantity: str, values: pd.Series) -> dict[str, str | float]:
    return {
        "item": label,
        "quantity": quantity,
        "value": values.median(),
        "low": values.min(),
        "high": values.max(),
        "repeats": len(values),
    }
