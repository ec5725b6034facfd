"""Steps per CPU second of the kernel and of other learners, in one run on one task."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from ptl.benchmark.contestants import (
    Contestant,
    GymnasiumLoop,
    Kernel,
    KernelEveryStep,
    NumbaLoop,
    PlainLoop,
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
    """

    label: str
    kind: type[Contestant]
    workload: str = "whole"


BASE = "plain Python, one loop"
"""The entry whose rate is 1 in the column of ratios."""

ENTRIES = (
    Entry("kernel, every step simulated", KernelEveryStep),
    Entry("kernel, with the shortcut", Kernel),
    Entry("kernel, every step simulated, while Q is zero", KernelEveryStep, "cold"),
    Entry("kernel, with the shortcut, while Q is zero", Kernel, "cold"),
    Entry("Numba, one loop", NumbaLoop),
    Entry(BASE, PlainLoop),
    Entry("Gymnasium and numpy", GymnasiumLoop, "sampled"),
)


def measure(
    task: Task,
    rounds: int,
    entries: Iterable[Entry] = ENTRIES,
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
    """Return rate and ratio to the base of every entry over the rounds.

    Returns
    -------
    DataFrame
        Columns ``item``, ``quantity`` (``steps per CPU second``, ``ratio to plain Python``), ``value`` (median over
        the rounds), ``low``, ``high`` (least and greatest), ``repeats``. A ratio compares the same round.
    """
    rate = (measured["steps"] / measured["seconds"]).rename("rate")
    rates = measured.assign(rate=rate).pivot(index="round", columns="entry", values="rate")
    rows = []
    for label in measured["entry"].unique():
        for quantity, values in (
            ("steps per CPU second", rates[label]),
            ("ratio to plain Python", rates[label] / rates[base]),
        ):
            rows.append(
                {
                    "item": label,
                    "quantity": quantity,
                    "value": values.median(),
                    "low": values.min(),
                    "high": values.max(),
                    "repeats": len(values),
                }
            )
    return pd.DataFrame(rows)
