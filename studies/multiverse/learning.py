"""Learn one setting and keep what verdicts need of each run: its measures and its subgoals."""

from __future__ import annotations

import sys
import traceback
from collections.abc import Mapping, Sequence

import numpy as np

from ptl.config import Measures, Parameters
from ptl.errors import printable
from ptl.learning.lives import grow_lives, learn_lives
from ptl.measures.measures import Curves, asymptotic, first_episode, threshold_episode, total_steps, truncated
from ptl.world.drawing import changed_world
from ptl.world.gridworld import GridWorld
from ptl.world.optimum import optimum
from studies.multiverse.design import EVERY, Point, drawings_of, measures_of, parameters_of

STREAM = "multiverse"
"""First name of every random stream of the study, followed by the setting's."""

COMPLETE = "complete"
"""Status of a setting that was learned completely."""

MAX_STATUS = 10_000
"""Maximum length of a status in characters."""

MEASURED = (first_episode, asymptotic, threshold_episode, total_steps, truncated)
"""Measures of a run that need no other run, in the order of the array ``measured``."""

NEVER = -1.0
"""Stands for a threshold that was never reached."""

SUBGOALS = ("subgoal", "incremental_peak", "original_peak")
"""States of a task, in the order of the array ``subgoals``."""


def worlds_of(point: Point, worlds: Mapping[str, GridWorld], environments: list[str]) -> dict[str, GridWorld]:
    """Return the maps of a setting by environment.

    Raises
    ------
    UserError
        If a change makes no map.
    """
    drawings = drawings_of(point.changes)
    every = drawings.get(EVERY, {})
    return {
        name: changed_world(worlds[point.maps.get(name, name)], every | drawings.get(name, {})) for name in environments
    }


def learn_point(
    point: Point,
    worlds: Mapping[str, GridWorld],
    tasks: Mapping[str, str],
    parameters: Parameters,
    measures: Measures,
    root_seed: int,
    step_budget: int,
    growth: tuple[str, int],
) -> dict[str, np.ndarray]:
    """Learn one setting.

    A method that has taken more than ``step_budget`` steps for each of its planned runs in an environment begins no
    further run there; ``status`` records this, and any failure, whose traceback goes to stderr.

    Parameters
    ----------
    worlds : mapping
        The maps before they are changed.
    tasks : mapping of str to str
        Goal letters of each environment.
    growth : tuple
        Environment and tasks of the growing library.

    Returns
    -------
    dict of arrays
        ``status``; for each environment and method ``<environment>/<method>/measured``, (measures, seeds, tasks), and
        ``/subgoals``, (3, seeds, tasks), see `MEASURED` and `SUBGOALS`; ``growth``, (lives, tasks + 1).
    """
    arrays: dict[str, np.ndarray] = {}
    remarks = []
    try:
        own = worlds_of(point, worlds, list(tasks))
        settings = parameters_of(point.changes, parameters)
        rule = measures_of(point.changes, measures)
        for environment, letters in tasks.items():
            optima = [optimum(own[environment], own[environment].goal(letter)) for letter in letters]
            for method, seeds in point.seeds.items():
                names = (STREAM, point.name, environment)
                lives = learn_lives(
                    own[environment],
                    letters,
                    method,
                    settings,
                    root_seed,
                    range(seeds),
                    *names,
                    budget=step_budget * seeds,
                )
                if len(lives["seeds"]) < seeds:
                    remarks.append(f"{environment}, {method}: given up after {len(lives['seeds'])} of {seeds} seeds")
                place = f"{environment}/{method}"
                arrays[f"{place}/measured"] = measured(lives, optima, rule)
                if "subgoal" in lives:
                    arrays[f"{place}/subgoals"] = np.array([lives[name] for name in SUBGOALS])
        if point.growth_runs:
            environment, number = growth
            arrays["growth"] = grow_lives(
                own[environment], environment, number, settings, root_seed, range(point.growth_runs), STREAM, point.name
            )
    except Exception as error:  # a setting that fails is a result of the study and does not end it
        traceback.print_exc(file=sys.stderr)
        remarks.append(f"failed: {type(error).__name__}: {str(error).splitlines()[0] if str(error) else ''}")
    status = printable("; ".join(remarks))[:MAX_STATUS] or COMPLETE
    return {"status": np.array(status.encode()), **arrays}


def measured(lives: Mapping[str, np.ndarray], optima: Sequence[float], rule: Measures) -> np.ndarray:
    """Return the measures of all runs, float array (measures, seeds, tasks); ``optima`` are those of the tasks."""
    tasks = []
    for place, least in enumerate(optima):
        curves = Curves(
            steps=lives["steps"][:, place],
            base=None,
            truncated=lives["truncated"][:, place],
            optimum=least,
            window=rule.window,
            threshold_factor=rule.threshold_factor,
        )
        tasks.append([np.nan_to_num(measure(curves).astype(float), nan=NEVER) for measure in MEASURED])
    return np.moveaxis(np.array(tasks), 0, -1)
