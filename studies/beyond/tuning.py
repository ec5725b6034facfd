"""Hyper-parameters of rivals, tuned on the tuning band: `make tune-beyond` writes config/tuned.csv.

For each method a grid of settings is tried on the same maps and lives. The cost of a setting is the geometric mean over
families of the geometric mean over their maps and lives of steps ÷ optimum, as on the page. The rule, fixed before the
runs: the setting of the lowest cost is chosen. No map of the test band is looked at.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
import pandas as pd

from ptl.config import Parameters
from ptl.files.csv import write_csv
from ptl.learning.life import learn_life, tasks_of
from ptl.methods import load
from ptl.world.mazes import FAMILIES, GOALS
from studies.beyond.maps import MAIN, checked_map
from studies.beyond.methods import reference
from studies.beyond.population import BANDS, SIZE, read_population

TABLE = Path(__file__).parent / "config/tuned.csv"
COLUMNS = ("method", "setting", *FAMILIES, "cost", "chosen")

ROOT_SEED = 15
MAPS, LIVES = 4, 2
"""Maps of each family, and lives on each."""

GRIDS: dict[str, dict[str, tuple[float, ...]]] = {
    "optimistic": {"learning__alpha": (0.05, 0.1, 0.2, 0.5, 0.8, 1.0)},
    "policy_reuse": {
        "policy_reuse__psi_decay": (0.95, 0.98, 0.99, 0.995, 0.998),
        "policy_reuse__temperature_step": (0.05, 5.0, 500.0, 50000.0),
    },
}
"""Values tried of each hyper-parameter, by method; the first of each is that of the reproduction."""


def settings(method: str) -> Iterator[dict[str, float]]:
    """Yield all combinations of the values of a method's grid."""
    grid = GRIDS[method]
    for values in itertools.product(*grid.values()):
        yield dict(zip(grid, values, strict=True))


def shown(setting: Mapping[str, float]) -> str:
    """Return a setting as text, such as ``learning.alpha=0.5``."""
    return " ".join(f"{name.replace('__', '.')}={value:g}" for name, value in setting.items())


def costs(method: str, setting: Mapping[str, float]) -> dict[str, float]:
    """Return the cost of a setting in each family."""
    rows = {(row.family, row.seed): row for row in read_population() if row.size == SIZE}
    parameters, kind = Parameters().replace(**setting), load(reference(method))
    found = {}
    for family in FAMILIES:
        logs = []
        for seed in range(BANDS["tuning"], BANDS["tuning"] + MAPS):
            world = checked_map(family, SIZE, seed, rows[family, seed].hash, MAIN)
            optimum = parameters.learning.episodes * sum(rows[family, seed].shortest_paths[1:])
            for life in range(LIVES):
                records = learn_life(
                    world, tasks_of(world, GOALS), kind, parameters, ROOT_SEED, family, seed, life
                ).records
                logs.append(np.log(sum(record.steps.sum() for record in records[1:]) / optimum))
        found[family] = float(np.exp(np.mean(logs)))
    return found


def choices(table: pd.DataFrame) -> pd.Series:
    """Return which rows have the lowest cost of their method, the first of several."""
    return table.index.isin(table.groupby("method")["cost"].idxmin())


def tune() -> pd.DataFrame:
    """Try all settings; return one row for each."""
    rows = []
    for method in GRIDS:
        for setting in settings(method):
            of_families = costs(method, setting)
            cost = float(np.exp(np.mean(np.log(list(of_families.values())))))
            rows.append({"method": method, "setting": shown(setting), **of_families, "cost": cost})
            print(f"{method} {shown(setting)}: {cost:.3f}", flush=True)
    table = pd.DataFrame(rows)
    return table.assign(chosen=choices(table))[list(COLUMNS)]


if __name__ == "__main__":
    write_csv(tune(), TABLE)
