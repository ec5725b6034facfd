"""Hyper-parameters of rivals, tuned on the tuning band: `make tune-beyond` writes config/tuned.csv.

For each method a grid of settings is tried on the same maps and lives, where moves are certain and at each slip of the
study (config/beyond.yaml). The cost of a setting is the geometric mean over families of the geometric mean over their
maps and lives of steps ÷ optimum of the same world, as on the page. The rule, fixed before the runs: at each slip, the
setting of the lowest cost is chosen. No map of the test band is looked at.
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
from studies.beyond.design import read_study
from studies.beyond.lives import expected_optimum
from studies.beyond.maps import MAIN, checked_map
from studies.beyond.methods import reference
from studies.beyond.population import BANDS, SIZE, read_population

CONFIG = Path(__file__).parent / "config"
TABLE = CONFIG / "tuned.csv"
COLUMNS = ("method", "slip", "setting", *FAMILIES, "cost", "chosen")

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


def slips() -> list[float]:
    """Return the probabilities of a slip in the study: 0 and those of its harder worlds."""
    return [0.0, *read_study(CONFIG / "beyond.yaml").harder.slips]


def settings(method: str) -> Iterator[dict[str, float]]:
    """Yield all combinations of the values of a method's grid."""
    grid = GRIDS[method]
    for values in itertools.product(*grid.values()):
        yield dict(zip(grid, values, strict=True))


def shown(setting: Mapping[str, float]) -> str:
    """Return a setting as text, such as ``learning.alpha=0.5``."""
    return " ".join(f"{name.replace('__', '.')}={value:g}" for name, value in setting.items())


def costs(method: str, setting: Mapping[str, float], slip: float = 0.0) -> dict[str, float]:
    """Return the cost of a setting in each family, where steps slip with a given probability."""
    rows = {(row.family, row.seed): row for row in read_population() if row.size == SIZE}
    parameters, kind = Parameters().replace(**setting), load(reference(method))
    found = {}
    for family in FAMILIES:
        logs = []
        for seed in range(BANDS["tuning"], BANDS["tuning"] + MAPS):
            world = checked_map(family, SIZE, seed, rows[family, seed].hash, MAIN).with_slip(slip)
            tasks = tasks_of(world, GOALS)
            optimum = parameters.learning.episodes * sum(expected_optimum(world, task) for task in tasks[1:])
            for life in range(LIVES):
                records = learn_life(world, tasks, kind, parameters, ROOT_SEED, family, seed, life).records
                logs.append(np.log(sum(record.steps.sum() for record in records[1:]) / optimum))
        found[family] = float(np.exp(np.mean(logs)))
    return found


def choices(table: pd.DataFrame) -> pd.Series:
    """Return which rows have the lowest cost of their method and slip, the first of several."""
    return table.index.isin(table.groupby(["method", "slip"])["cost"].idxmin())


def tune() -> pd.DataFrame:
    """Try all settings at each slip; return one row for each."""
    rows = []
    for method, slip in itertools.product(GRIDS, slips()):
        for setting in settings(method):
            of_families = costs(method, setting, slip)
            cost = float(np.exp(np.mean(np.log(list(of_families.values())))))
            rows.append({"method": method, "slip": slip, "setting": shown(setting), **of_families, "cost": cost})
            print(f"{method}, slip {slip:g}, {shown(setting)}: {cost:.3f}", flush=True)
    table = pd.DataFrame(rows)
    return table.assign(chosen=choices(table))[list(COLUMNS)]


if __name__ == "__main__":
    write_csv(tune(), TABLE)
