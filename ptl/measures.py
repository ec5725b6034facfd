"""From learning files to per-seed measures of transfer, steps per episode and the subgoals found.

The measures are jump start, asymptotic performance and time to threshold (Langley), total performance and
transfer ratio (Taylor and Stone, JMLR 10, 2009), the last with its sign flipped so that positive is good
(stated in the article). Performance is the number of steps of an episode; fewer is better.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from ptl.archive import write_arrays
from ptl.errors import UserError
from ptl.store import open_learning

if TYPE_CHECKING:
    from ptl.store import LearningFile

STEPS = "ptl-steps/1"
"""Format of the file of steps per episode."""

PER_SEED_COLUMNS = (
    "environment", "task", "method", "seed", "first_episode", "asymptotic", "threshold_episode",
    "total_steps", "jump_start", "transfer_ratio", "truncated",
)  # fmt: skip

SUBGOAL_COLUMNS = (
    "environment", "method", "seed", "task", "subgoal", "row", "column", "novelty", "metric_value", "reason",
    "incremental_peak", "original_peak",
)  # fmt: skip


# -- measures of arrays of steps, shape (seeds, episodes) ----------------------------------------------------


def first_episode(steps: np.ndarray) -> np.ndarray:
    """Steps of the first episode, shape (seeds,)."""
    return np.asarray(steps)[:, 0]


def jump_start(steps: np.ndarray, base_steps: np.ndarray) -> np.ndarray:
    """First-episode steps of the base minus those of the method, shape (seeds,); positive is good."""
    return first_episode(base_steps) - first_episode(steps)


def jump_start_percent(steps: np.ndarray, base_steps: np.ndarray) -> float:
    """Mean jump start in percent of the base's mean first episode: one number for all seeds."""
    return float(100 * np.mean(jump_start(steps, base_steps)) / np.mean(first_episode(base_steps)))


def asymptotic(steps: np.ndarray, window: int) -> np.ndarray:
    """Mean steps of the last ``window`` episodes, shape (seeds,)."""
    steps = np.asarray(steps)
    _check_window(window, steps.shape[1])
    return steps[:, -window:].mean(axis=1)


def threshold_episode(steps: np.ndarray, shortest_path: int, window: int, factor: float) -> np.ndarray:
    """Time to threshold, float array (seeds,), NaN where the threshold is never reached.

    It is the number (counted from 1) of the episode that completes the first ``window`` episodes whose mean
    is at most ``factor`` times the shortest path; so it is never less than ``window``.
    """
    steps = np.asarray(steps)
    seeds, episodes = steps.shape
    _check_window(window, episodes)
    sums = np.cumsum(np.hstack([np.zeros((seeds, 1), dtype=np.int64), steps]), axis=1)
    reached = (sums[:, window:] - sums[:, :-window]) / window <= factor * shortest_path
    return np.where(reached.any(axis=1), reached.argmax(axis=1) + float(window), np.nan)


def total_steps(steps: np.ndarray) -> np.ndarray:
    """Sum of the steps of all episodes, shape (seeds,)."""
    return np.asarray(steps).sum(axis=1)


def transfer_ratio(steps: np.ndarray, base_steps: np.ndarray) -> np.ndarray:
    """(Total of the base - total of the method) / total of the base, shape (seeds,); positive is good."""
    base = total_steps(base_steps)
    return (base - total_steps(steps)) / base


def _check_window(window: int, episodes: int) -> None:
    if not 1 <= window <= episodes:
        raise UserError(
            f"measures.window: {window} is not between 1 and the {episodes} episodes of a task;"
            " use a smaller window or more episodes"
        )


# -- measures of a run ---------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Measurements:
    """What is read from the learning files of a run.

    Attributes
    ----------
    per_seed : DataFrame
        Columns `PER_SEED_COLUMNS`. Jump start and transfer ratio are missing if the base method is not in the
        run of that environment; the threshold episode is missing where the threshold was never reached.
        ``truncated`` counts the episodes cut off at the safety cap.
    subgoals : DataFrame
        Columns `SUBGOAL_COLUMNS`, a row for each task of the methods that keep a library. The subgoal is -1
        and its cell missing if none was added, for the reason given; the value is the greatest of the
        incremental metric. The peaks are the states where either metric is greatest, whether the library
        added a skill or not, and -1 where the metric is 0 everywhere.
    steps : dict
        (environment, method, task) to int64 array (seeds, episodes), seeds in ascending order.
    seeds : tuple of int
    """

    per_seed: pd.DataFrame
    subgoals: pd.DataFrame
    steps: dict[tuple[str, str, str], np.ndarray]
    seeds: tuple[int, ...]


@dataclass
class _Collection:
    """Small numbers kept from each learning file after it is closed again."""

    steps: dict[tuple[str, str, str], dict[int, np.ndarray]] = field(default_factory=dict)
    truncated: dict[tuple[str, str, str], dict[int, int]] = field(default_factory=dict)
    shortest: dict[tuple[str, str], int] = field(default_factory=dict)
    subgoals: list[tuple[object, ...]] = field(default_factory=list)

    def add(self, path: Path, file: LearningFile) -> None:
        for letter, task in file.tasks.items():
            key = (file.environment, file.method, letter)
            by_seed = self.steps.setdefault(key, {})
            if file.seed in by_seed:
                raise UserError(
                    f"{path}: environment {file.environment}, method {file.method}, seed {file.seed} is given"
                    " twice; name each learning file once"
                )
            by_seed[file.seed] = np.asarray(task.steps, dtype=np.int64)
            self.truncated.setdefault(key, {})[file.seed] = int(np.count_nonzero(task.truncated))
            shortest = file.world.shortest_path_length(task.start, task.goal)
            if self.shortest.setdefault((file.environment, letter), shortest) != shortest:
                raise UserError(
                    f"{path}: the shortest path of task {letter} is {shortest} steps, but other files of"
                    f" environment {file.environment} have another map; delete those learned on the old one"
                )
            if file.library is not None:
                self._add_subgoal(file, letter)

    def _add_subgoal(self, file: LearningFile, letter: str) -> None:
        task = file.tasks[letter]
        row, column = file.world.cells[task.subgoal] if task.subgoal >= 0 else (None, None)
        self.subgoals.append(
            (file.environment, file.method, file.seed, letter, task.subgoal, row, column, task.novelty,
             float(np.max(task.incremental)), task.reason, _peak(task.incremental), _peak(task.original))
        )  # fmt: skip


def _peak(metric: np.ndarray) -> int:
    """State where a metric is greatest, the first of several; -1 if it is 0 everywhere."""
    return int(np.argmax(metric)) if np.any(metric) else -1


def measure_files(
    paths: Iterable[str | Path],
    window: int,
    threshold_factor: float,
    base: str = "no_transfer",
    *,
    admit: Callable[[Path, LearningFile], None] | None = None,
) -> Measurements:
    """Measure the learning files of a run, one open at a time.

    Parameters
    ----------
    paths : paths of learning files
        Environments and methods keep the order in which they first appear here; tasks are in alphabetical
        order.
    window : int
        Episodes of the asymptotic mean and of the moving mean behind the time to threshold.
    threshold_factor : float
        The threshold is this many times the shortest path.
    base : str
        Method that the others are compared with, on the same environment, task and seed.
    admit : callable, optional
        Called with the path and the open file of each; it raises UserError to refuse one.

    Raises
    ------
    UserError
        When a file cannot be read, stands twice, lacks seeds or episodes that others have, or the window is
        longer than a task.
    """
    collection = _Collection()
    for path in map(Path, paths):
        with open_learning(path) as file:
            if admit is not None:
                admit(path, file)
            collection.add(path, file)
    if not collection.steps:
        raise UserError("no learning file to measure; name at least one")
    seeds, steps = _stack(collection.steps)
    frames = []
    for environment, method, task in _table_order(steps):
        key = (environment, method, task)
        own, reference = steps[key], steps.get((environment, base, task))
        if reference is None and any(name == environment and by == base for name, by, _ in steps):
            raise UserError(
                f"environment {environment}: method {base} has no task {task} that {method} has;"
                " learn the same tasks with both"
            )
        shortest = collection.shortest[environment, task]
        frames.append(
            pd.DataFrame(
                {
                    "environment": environment,
                    "task": task,
                    "method": method,
                    "seed": seeds,
                    "first_episode": first_episode(own),
                    "asymptotic": asymptotic(own, window),
                    "threshold_episode": _integers(threshold_episode(own, shortest, window, threshold_factor)),
                    "total_steps": total_steps(own),
                    "jump_start": _integers(None if reference is None else jump_start(own, reference), len(seeds)),
                    "transfer_ratio": np.nan if reference is None else transfer_ratio(own, reference),
                    "truncated": [collection.truncated[key][seed] for seed in seeds],
                }
            )
        )
    return Measurements(
        per_seed=pd.concat(frames, ignore_index=True)[list(PER_SEED_COLUMNS)],
        subgoals=_subgoal_frame(collection.subgoals, steps),
        steps=steps,
        seeds=seeds,
    )


def write_steps(path: str | Path, measurements: Measurements) -> None:
    """Write the steps per episode: /<environment>/<method>/<task>, int64 (seeds, episodes).

    The root attribute ``seeds`` names the rows.
    """
    arrays = {"/".join(names): steps for names, steps in measurements.steps.items()}
    write_arrays(path, STEPS, arrays, {"seeds": np.array(measurements.seeds, dtype=np.int64)})


def _stack(
    collected: dict[tuple[str, str, str], dict[int, np.ndarray]],
) -> tuple[tuple[int, ...], dict[tuple[str, str, str], np.ndarray]]:
    """Seeds of the run and (seeds, episodes) arrays; every method must have the same seeds and episodes."""
    seeds = sorted(set().union(*collected.values()))
    episodes = {len(steps) for by_seed in collected.values() for steps in by_seed.values()}
    if len(episodes) > 1:
        raise UserError(
            f"learning files with {' and '.join(map(str, sorted(episodes)))} episodes a task cannot be"
            " compared; measure the files of one run"
        )
    arrays = {}
    for key, by_seed in collected.items():
        for seed in seeds:
            if seed not in by_seed:
                environment, method, task = key
                raise UserError(
                    f"environment {environment}, method {method}, task {task}: seed {seed} is missing"
                    " although others have it; name its learning file too, or learn it"
                )
        arrays[key] = np.stack([by_seed[seed] for seed in seeds])
    return tuple(seeds), arrays


def _table_order(keys: Iterable[tuple[str, str, str]]) -> list[tuple[str, str, str]]:
    """Environment and method by first appearance, task by the alphabet; sorted environment, task, method."""
    keys = list(keys)
    environments = list(dict.fromkeys(environment for environment, _, _ in keys))
    methods = list(dict.fromkeys(method for _, method, _ in keys))
    return sorted(keys, key=lambda key: (environments.index(key[0]), key[2], methods.index(key[1])))


def _integers(values: np.ndarray | None, length: int = 0) -> pd.Series:
    """Whole numbers that may be missing."""
    if values is None:
        return pd.Series([pd.NA] * length, dtype="Int64")
    return pd.Series(values).astype("Int64")


def _subgoal_frame(rows: list[tuple[object, ...]], steps: Iterable[tuple[str, str, str]]) -> pd.DataFrame:
    frame = pd.DataFrame(rows, columns=list(SUBGOAL_COLUMNS))
    whole = ("seed", "subgoal", "incremental_peak", "original_peak")
    frame = frame.astype(dict.fromkeys(whole, "int64") | {"row": "Int64", "column": "Int64"})
    order = [(environment, method) for environment, method, _ in steps]
    ranks = {pair: rank for rank, pair in enumerate(dict.fromkeys(order))}
    frame["rank"] = [ranks[pair] for pair in zip(frame["environment"], frame["method"], strict=True)]
    return frame.sort_values(["rank", "seed", "task"], ignore_index=True).drop(columns="rank")
