"""Learn one setting of the study, all environments, methods and seeds in one process."""

from __future__ import annotations

import sys
import traceback
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from ptl.config import Parameters
from ptl.errors import printable
from ptl.learning.lives import grow_lives, learn_lives
from ptl.world.drawing import KINDS, changed_world
from ptl.world.gridworld import GridWorld

STREAM = "robustness"
"""First name of every random stream of the study, followed by the setting's."""

COMPLETE = "complete"
"""Status of a setting that was learned completely."""

MAX_STATUS = 10_000
"""Maximum length of a status in characters."""


def learn_setting(
    worlds: Mapping[str, GridWorld],
    tasks: Mapping[str, str],
    methods: Sequence[str],
    changes: Mapping[str, Any],
    parameters: Parameters,
    root_seed: int,
    name: str,
    *,
    seeds: int,
    step_budget: int,
    growth: tuple[str, int, int],
    watch: Callable[[Sequence[Any]], Iterable[Any]] = iter,
) -> dict[str, np.ndarray]:
    """Learn one setting.

    A method that takes more than ``step_budget`` steps in one environment is given up there: the seeds that it
    finished are kept, and the array ``status`` records this, and any failure; the traceback goes to stderr.

    Parameters
    ----------
    worlds : mapping
        The maps before they are changed.
    tasks : mapping of str to str
        Goal letters of each environment.
    growth : tuple
        Environment, tasks and lives of the growing library.

    Returns
    -------
    dict of arrays
        ``status`` and, for each environment and method, ``<environment>/<method>/`` with the arrays of
        `ptl.learning.lives.learn_lives`; ``growth/library_size`` (lives, tasks + 1) if there are such lives.
    """
    arrays: dict[str, np.ndarray] = {}
    remarks = []
    try:
        changed = changed_worlds(worlds, changes)
        for environment, method in watch([(environment, method) for environment in tasks for method in methods]):
            letters, names = tasks[environment], (STREAM, name, environment)
            world = changed[environment]
            lives = learn_lives(world, letters, method, parameters, root_seed, range(seeds), *names, budget=step_budget)
            finished = len(lives["seeds"])
            if finished < seeds:
                remarks.append(
                    f"{environment}, {method}: given up after {finished} of {seeds} seeds and"
                    f" {lives['steps'].sum()} steps"
                )
            arrays |= {f"{environment}/{method}/{key}": values for key, values in lives.items()}
        environment, number, runs = growth
        if runs:
            arrays["growth/library_size"] = grow_lives(
                changed[environment], environment, number, parameters, root_seed, range(runs), STREAM, name
            )
    except Exception as error:  # a setting that fails is a result of the study and does not end it
        traceback.print_exc(file=sys.stderr)
        remarks.append(f"failed: {type(error).__name__}: {str(error).splitlines()[0] if str(error) else ''}")
    status = printable("; ".join(remarks))[:MAX_STATUS] or COMPLETE
    return {"status": np.array(status.encode()), **arrays}


def changed_worlds(worlds: Mapping[str, GridWorld], changes: Mapping[str, Any]) -> dict[str, GridWorld]:
    """Return the maps of a setting; changes of hyper-parameters are ignored.

    Raises
    ------
    UserError
        If a change makes no map.
    """
    maps: dict[str, dict[str, Any]] = {name: {} for name in worlds}
    for unknown, value in changes.items():
        name, _, kind = unknown.partition(".")
        if kind in KINDS:
            maps[name][kind] = value
    return {name: changed_world(world, maps[name]) for name, world in worlds.items()}
