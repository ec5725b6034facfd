"""Steps per CPU second of the kernel and of other learners, in one run on one task."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import pandas as pd

from benchmarks.learners import GymnasiumLoop, Kernel, Mdplib, PlainLoop, Problem, Timed

EPISODES = 200
"""Episodes of the task, as in the published run."""

SAMPLED_EVERY = 20
"""A learner too slow for the whole task runs one in this many episodes."""

BASE = "plain Python, one loop"
"""The learner whose rate is 1 in the column of ratios."""


@dataclass(frozen=True)
class Entry:
    """A learner with its workload.

    Attributes
    ----------
    label : str
    make : callable
        Make the learner from a task and a seed.
    workload : {"whole", "sampled", "cold"}
        The whole task; every twentieth episode of it, from the Q that the kernel has there; or episodes with
        alpha = 0, so that Q stays zero and every episode has the distribution of the first one.
    limit : str
        Label of the walk that bounds the learner's speed, if one does.
    """

    label: str
    make: Callable[[Problem, int], Timed]
    workload: str = "whole"
    limit: str = ""


PUBLISHED = (
    (
        "QTAccel, a pipeline on an FPGA",
        180e6,
        "Q-learning, one sample in each clock cycle: Y. Meng, S. Kuppannagari, R. Rajat, A. Srivastava, R. Kannan and"
        " V. Prasanna, “QTAccel: A Generic FPGA based Design for Q-Table based Reinforcement Learning Accelerators”,"
        " IEEE International Parallel and Distributed Processing Symposium Workshops 2020, 107–114",
    ),
    (
        "NAVIX, 2048 PPO agents on an A100 GPU",
        2048 * 16 * 1e6 / 49,
        "PPO in 32,768 grid worlds at once, a million steps of each in 49 s: E. Pignatelli, J. Liesen, R. T. Lange,"
        " C. Lu, P. S. Castro and L. Toni, “NAVIX: Scaling MiniGrid Environments with JAX”, 2024, arXiv:2407.19396;"
        " figures from the README of github.com/epignatelli/navix, version 0.11.0",
    ),
)
"""Rates that others have published, in steps per second, with their sources; not measured here."""


def all_entries() -> list[Entry]:
    """Return all learners and the walks that bound them."""
    from benchmarks.jax_loop import JaxLoop
    from benchmarks.numba_loops import BareWalk, NumbaLoop

    every_step = partial(Kernel, shortcut=False)
    one, two = "bare random walk, one step a look-up", "bare random walk, two steps a look-up"
    return [
        Entry("kernel, every step simulated", every_step, limit=one),
        Entry("kernel, with the shortcut", Kernel, limit=two),
        Entry("kernel, every step simulated, while Q is zero", every_step, "cold", one),
        Entry("kernel, with the shortcut, while Q is zero", Kernel, "cold", two),
        Entry("mdplib (C++), while Q is zero", Mdplib, "cold"),
        Entry("Numba, one loop", NumbaLoop),
        Entry("JAX, one loop", JaxLoop),
        Entry(BASE, PlainLoop),
        Entry("Gymnasium and numpy", GymnasiumLoop, "sampled"),
        Entry(one, BareWalk, "cold"),
        Entry(two, partial(BareWalk, stride=2), "cold"),
    ]


def measure(
    task: Problem,
    entries: Iterable[Entry],
    rounds: int,
    episodes: int = EPISODES,
    min_seconds: float = 0.25,
    say: Callable[[str], None] = lambda _: None,
) -> pd.DataFrame:
    """Time all entries in turn, round after round, so that other load on the machine affects all of them.

    Parameters
    ----------
    min_seconds : float
        Minimum CPU seconds of a measurement; a fast learner learns the task several times.
    say : callable
        Called with a line at the start of each round.

    Returns
    -------
    DataFrame
        Columns ``part`` (speed or limit), ``item``, ``quantity`` and ``value``, rows of each round. A ratio or share
        compares rates of one round.
    """
    entries = list(entries)
    limits = {entry.limit for entry in entries}
    stages = _stages(task, episodes)
    rows = []
    for number in range(rounds):
        say(f"speed, round {number + 1} of {rounds}")
        rates = {entry.label: _rate(entry, task, stages, 1000 * number, episodes, min_seconds) for entry in entries}
        for entry in entries:
            part, rate = "limit" if entry.label in limits else "speed", rates[entry.label]
            rows.append((part, entry.label, "steps per CPU second" if part == "speed" else "per CPU second", rate))
            if part == "speed":
                rows.append((part, entry.label, "ratio to plain Python", rate / rates[BASE]))
            if entry.limit:
                rows.append(("limit", entry.label, f"share of {entry.limit}", rate / rates[entry.limit]))
    return pd.DataFrame(rows, columns=["part", "item", "quantity", "value"])


def published() -> pd.DataFrame:
    """Return `PUBLISHED` as a table with the columns ``part``, ``item``, ``quantity``, ``value`` and ``source``."""
    rows = [("published", item, "steps per second", rate, source) for item, rate, source in PUBLISHED]
    return pd.DataFrame(rows, columns=["part", "item", "quantity", "value", "source"])


def _stages(task: Problem, episodes: int) -> list[np.ndarray]:
    """Return Q before every twentieth episode of a task as the kernel learns it."""
    kernel, stages = Kernel(task, 0), []
    for _ in range(0, episodes, SAMPLED_EVERY):
        stages.append(kernel.q)
        kernel.run(SAMPLED_EVERY)
    return stages


def _rate(entry: Entry, task: Problem, stages: list[np.ndarray], seed: int, episodes: int, min_seconds: float) -> float:
    if entry.workload == "cold":
        task = replace(task, alpha=0.0)
    starts = stages if entry.workload == "sampled" else [None]
    steps, seconds = 0, 0.0
    while seconds < min_seconds:
        for q in starts:
            learner = entry.make(task, seed)
            if q is not None:
                learner.q[:] = q  # type: ignore[attr-defined]
            begin = time.process_time()
            steps += learner.run(episodes if q is None else 1)
            seconds += time.process_time() - begin
            seed += 1
    return steps / seconds
