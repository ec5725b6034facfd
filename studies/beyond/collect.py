"""From the files of lives to a row for each life, and for each of its tasks."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

import numpy as np
import pandas as pd

from ptl import methods
from ptl.errors import UserError
from ptl.files.store import Result
from ptl.files.tables import check_numbers, read_table
from studies.beyond.design import SecondStudy
from studies.beyond.jobs import LivesOnMaps
from studies.beyond.lives import NO_CHANGE, last_episodes
from studies.beyond.maps import MAIN, RETURNING
from studies.beyond.methods import reference
from studies.beyond.population import read_population

KEYS = ("family", "map", "size", "sequence", "slip", "change", "method", "per_task", "seed")
TASK_COLUMNS = (
    *KEYS, "task", "steps", "first_episode", "last_episodes", "optimum", "truncated", "library_size", "states",
    "winding",
)  # fmt: skip
"""``task`` counts from 1; ``last_episodes`` is the mean number of steps over the last tenth of the episodes;
``optimum`` is episodes x expected steps of the best policy, the shortest path where nothing slips; ``library_size`` is
that after the task."""

TEXTS = ("family", "map", "sequence", "change")
"""Columns whose values are text, in addition to those of `ptl.files.tables`."""

LIFE_COLUMNS = ("family", "map", "size", "sequence", "method", "seed", "total_steps", "optimum", "library_size")
"""Columns of ``per_life.csv``: steps and optimum are those of the tasks after the first."""

HARDER_COLUMNS = ("family", "map", "size", "slip", "change", "method", "seed", "total_steps", "optimum", "library_size")
"""Columns of ``per_life_harder.csv``, of worlds that slip or change."""


def per_task(results: Iterable[Result]) -> pd.DataFrame:
    """Return a row for each task of each life, columns `TASK_COLUMNS`.

    ``size`` is the wanted number of states of a generated map and the number of states of a given one.

    Raises
    ------
    UserError
        If a file cannot be used.
    """
    frames = [_rows(result.job, result.arrays) for result in results]
    return pd.concat(frames, ignore_index=True) if frames else pd.DataFrame(columns=list(TASK_COLUMNS))


def _rows(job: LivesOnMaps, arrays: Mapping[str, np.ndarray]) -> pd.DataFrame:
    of_map, of_seed, of_task = (index.ravel() for index in np.indices(arrays["steps"].shape))
    return pd.DataFrame(
        {
            "family": job.family,
            "map": np.array(job.places, dtype=object)[of_map],
            "size": job.size or arrays["states"][of_map],
            "sequence": job.sequence,
            "slip": job.slip,
            "change": job.change,
            "method": job.method,
            "per_task": job.per_task,
            "seed": of_seed,
            "task": of_task + 1,
            "steps": arrays["steps"].ravel(),
            "first_episode": arrays["first"].ravel(),
            "last_episodes": arrays["last"].ravel() / last_episodes(job.settings),
            "optimum": (job.settings.learning.episodes * arrays["optimum"])[of_map, of_task],
            "truncated": arrays["truncated"].ravel(),
            "library_size": arrays["library_size"].ravel(),
            "states": arrays["states"][of_map],
            "winding": arrays["winding"][of_map],
        },
        columns=list(TASK_COLUMNS),
    )


def per_life(tasks: pd.DataFrame) -> pd.DataFrame:
    """Return a row for each life of a method as it is, columns `LIFE_COLUMNS`; the sums leave out the first task.

    The first task is the same for all methods that need a library or a memory, which is empty then.
    """
    lives = _lives(tasks[certain(tasks) & (tasks["sequence"] != RETURNING)])
    return lives.astype({"optimum": "int64"})[list(LIFE_COLUMNS)]  # sums of shortest paths


def per_life_harder(tasks: pd.DataFrame) -> pd.DataFrame:
    """Return a row for each life in a world that slips or changes, columns `HARDER_COLUMNS`, as `per_life`."""
    return _lives(tasks[~certain(tasks)])[list(HARDER_COLUMNS)]


def certain(tasks: pd.DataFrame) -> pd.Series:
    """Return which rows are of worlds that neither slip nor change, bool."""
    return (tasks["slip"] == 0) & (tasks["change"] == NO_CHANGE)


def _lives(tasks: pd.DataFrame) -> pd.DataFrame:
    later = tasks[(tasks["task"] > 1) & (tasks["per_task"] == 0)]
    grouped = later.groupby([name for name in KEYS if name != "per_task"], sort=False)
    return grouped.agg(
        total_steps=("steps", "sum"), optimum=("optimum", "sum"), library_size=("library_size", "last")
    ).reset_index()


def read_tasks(path: str | Path) -> pd.DataFrame:
    """Read the table of `per_task` back."""
    return read_table(path, TASK_COLUMNS, texts=TEXTS).astype({"task": int})  # a number here, a letter elsewhere


def read_harder(path: str | Path) -> pd.DataFrame:
    """Read the table of `per_life_harder` back."""
    return read_table(path, HARDER_COLUMNS, texts=TEXTS)


def read_lives(path: str | Path) -> pd.DataFrame:
    """Read ``per_life.csv`` or a table of the same columns that another program has written.

    Raises
    ------
    UserError
        If it cannot be read, lacks a column, has a duplicate life or an impossible cost.
    """
    frame = read_table(path, LIFE_COLUMNS, texts=TEXTS)
    check_numbers(frame, path, ("size", "seed", "optimum", "library_size"), low=0)
    check_numbers(frame, path, ("total_steps",))
    for wrong, what in (
        (frame.duplicated(["family", "map", "size", "sequence", "method", "seed"]), "is there twice; give it once"),
        (frame["optimum"] <= 0, "has no optimum; give episodes x shortest paths of the tasks after the first"),
        (frame["total_steps"] < frame["optimum"], "has fewer steps than the optimum; check how both are counted"),
    ):
        if wrong.any():
            row = frame[wrong].iloc[0]
            life = f"family {row['family']}, map {row['map']}, method {row['method']}, seed {row['seed']}"
            raise UserError(f"{path}: the life of {life} {what}")
    return frame[list(LIFE_COLUMNS)]


def foreign_lives(study: SecondStudy) -> pd.DataFrame:
    """Return the lives of methods that the study does not run, on the maps that it does.

    Raises
    ------
    UserError
        When a file is invalid, names a method twice, or has an optimum that differs from the table of maps.
    """
    collected = pd.DataFrame(columns=list(LIFE_COLUMNS))
    taken = {methods.identifier(reference(name)): "methods" for name in study.methods}
    episodes = study.learning.episodes
    shortest = {(e.family, str(e.seed), e.size): sum(e.shortest_paths[1:]) for e in read_population()}
    for path in study.foreign_lives:
        lives = read_lives(path)
        places = [str(seed) for seed in study.seeds_of_maps]
        generated = lives["family"].isin(study.families) & lives["map"].isin(places) & (lives["size"] == study.size)
        lives = lives[
            (generated & (lives["seed"] < study.seeds) & lives["sequence"].isin([MAIN, *study.sequences.names]))
            | (lives["family"].isin(study.article_maps) & (lives["seed"] < study.article_seeds))
        ]
        if lives.empty:
            raise UserError(f"{path}: holds no life on the maps of this study")
        for name in dict.fromkeys(lives["method"]):
            if name in taken:
                raise UserError(f"{path}: method {name} is in {taken[name]} already; give it another name")
            taken[name] = str(path)
        for row in lives[lives["sequence"] == MAIN].drop_duplicates(["family", "map"]).itertuples():
            wanted = episodes * shortest[row.family, row.map, row.size]
            if row.optimum != wanted:
                raise UserError(
                    f"{path}: the optimum of family {row.family}, map {row.map} is {row.optimum}, where {episodes}"
                    f" episodes give {wanted}; use the same maps, tasks and episodes"
                )
        collected = pd.concat([collected, lives], ignore_index=True) if len(collected) else lives
    return collected
