"""The survey of figure 8 as a whole, by both methods side by side."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from multiprocessing.pool import ThreadPool
from pathlib import Path

import pandas as pd

from ptl.benchmark.scaling import probe
from ptl.benchmark.surveys import METHODS

BATCHES = 12
"""Parts of a map's pairs; the methods take turns at them, so that disturbances affect both."""

QUANTITIES = ("core seconds", "steps", "pairs")


def measure(
    maps: Mapping[str, Path],
    trajectories: int,
    parameters: str,
    batches: int = BATCHES,
    say: Callable[[str], None] = lambda _: None,
) -> pd.DataFrame:
    """Survey all ordered pairs of some maps by both methods, in as many processes at a time as there are cores.

    Parameters
    ----------
    maps : mapping
        Files of the maps by the environments' names. All states of a map must be reachable from each other.
    parameters : str
        Hyper-parameters, as `ptl.config.Parameters.from_json` takes them.
    batches : int
        Batches of each map.

    Returns
    -------
    DataFrame
        Columns ``item`` (method), ``map`` and the `QUANTITIES`: CPU seconds, simulated steps and pairs of a batch.
    """

    def run(job: tuple[str, int, str]) -> dict[str, str | float]:
        name, batch, method = job
        say(f"{method}: {name}, batch {batch + 1} of {batches}")
        numbers = map(str, (batch, batches, trajectories))
        found = probe("survey_batch", str(maps[name]), method, *numbers, parameters)
        return {"item": method, "map": name, **{each["quantity"]: each["value"] for each in found}}

    jobs = [(name, batch, method) for name in maps for batch in range(batches) for method in METHODS]
    with ThreadPool(os.cpu_count() or 1) as pool:
        return pd.DataFrame(pool.map(run, jobs, chunksize=1))


def summarise(measured: pd.DataFrame) -> pd.DataFrame:
    """Add up the batches of each method.

    Returns
    -------
    DataFrame
        Columns ``item`` (method), ``quantity``, ``value``: the `QUANTITIES` of all maps together, then those of each
        map, with its name behind the quantity's.
    """
    rows = []
    for method, batches in measured.groupby("item", sort=False):
        parts = [("", batches), *((f", {name}", part) for name, part in batches.groupby("map", sort=False))]
        for ending, part in parts:
            rows += [{"item": method, "quantity": name + ending, "value": part[name].sum()} for name in QUANTITIES]
    return pd.DataFrame(rows)
