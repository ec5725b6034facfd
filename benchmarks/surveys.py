"""The survey of figure 8 by two methods of the same distribution: every step simulated, and with trees.

docs/performance.md explains the trees.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Mapping
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np
import pandas as pd

from ptl.agent._kernel import Dynamics
from ptl.config import Parameters
from ptl.learning._survey import Survey, subgoals_from
from ptl.world.gridworld import GridWorld
from ptl.world.map_files import load_map

EVERY_STEP, TREES = "survey, every step simulated", "survey, with trees"
METHODS = (EVERY_STEP, TREES)

NO_LIMIT = 10**12
"""Step limit of an episode: the two methods count different steps, so a limit must never be reached."""

Pairs = tuple[int, np.ndarray]
"""Pairs that are learned in one call: a start and its goals if every step is simulated, else a goal and its starts."""


def costs(world: GridWorld, method: str, groups: Iterable[Pairs], trajectories: int) -> np.ndarray:
    """Find the subgoals of some pairs; return CPU seconds, simulated steps and pairs of each group, float (k, 3)."""
    dynamics, learning = Dynamics(world.successors), Parameters().learning
    options = {"alpha": learning.alpha, "gamma": learning.gamma, "epsilon": learning.epsilon, "max_steps": NO_LIMIT}
    survey = Survey(dynamics, trajectories, **options)
    rows = []
    for state, others in groups:
        random, before, begin = np.random.SFC64([0, state]), survey.steps, time.process_time()
        if method == TREES:
            survey.subgoals_to(state, others, random)
            steps = survey.steps - before
        else:
            _, steps = subgoals_from(dynamics, state, others, random, trajectories, trajectories, **options)
        rows.append((time.process_time() - begin, steps, len(others)))
    return np.array(rows, dtype=float)


def all_pairs(world: GridWorld, batch: int, batches: int) -> list[Pairs]:
    """Return the pairs of every n-th state; all batches together have each ordered pair of a map once."""
    states = np.arange(world.n_states)
    return [(int(state), np.delete(states, state)) for state in states[batch::batches]]


def measure(maps: Mapping[str, str], trajectories: int, batches: int = 12) -> pd.DataFrame:
    """Survey all ordered pairs of some maps by both methods, in as many processes at a time as there are cores.

    The batches of one method alternate with those of the other, so that other load on the machine affects both.

    Parameters
    ----------
    maps : mapping
        Files of the maps by the environments' names.

    Returns
    -------
    DataFrame
        Columns ``part``, ``item`` (method), ``quantity``, ``value``: core seconds, steps and pairs of all maps together
        and of each map.
    """
    jobs = [(name, batch, method) for name in maps for batch in range(batches) for method in METHODS]
    with ProcessPoolExecutor(mp_context=get_context("spawn")) as pool:
        batch_costs = [
            pool.submit(_batch, maps[name], method, batch, batches, trajectories) for name, batch, method in jobs
        ]
        rows = [(method, name, *cost.result()) for (name, _, method), cost in zip(jobs, batch_costs, strict=True)]
    table = pd.DataFrame(rows, columns=["item", "map", "core seconds", "steps", "pairs"])
    by_map = table.groupby(["item", "map"], sort=False).sum().stack().rename("value").reset_index()
    by_map.columns = ["item", "map", "quantity", "value"]
    total = by_map.groupby(["item", "quantity"], sort=False, as_index=False)["value"].sum()
    by_map["quantity"] += ", " + by_map["map"]
    return pd.concat([total, by_map.drop(columns="map")], ignore_index=True).assign(part="survey")


def _batch(path: str, method: str, batch: int, batches: int, trajectories: int) -> np.ndarray:
    world = load_map(path)
    return costs(world, method, all_pairs(world, batch, batches), trajectories).sum(axis=0)
