"""From a setting's arrays to what holds in it: every claim under every reading, and the estimates behind them.

A drawn setting is judged as if its runs were all there are: a part holds if its estimate is on the right side of the
bound. Whether a difference is significant is judged for the article's 30 runs, or never true in the limit of a
difference of 0.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from ptl import claims
from ptl.claims.claim import Claim, Judgement
from ptl.claims.degrees import PLAIN, STRICT, Outcomes
from ptl.claims.evidence import Evidence, MissingEvidence
from ptl.claims.reading import ARTICLE_RUNS, TRANSFER_TASKS, Reading
from ptl.claims.verdict import Outcome
from ptl.config import Configuration
from ptl.files.store import Result
from ptl.measures.measures import BASE, PER_SEED_COLUMNS
from ptl.measures.statistics import Resampling
from ptl.world.gridworld import GridWorld
from studies.multiverse.design import Point, measures_of, parameters_of
from studies.multiverse.jobs import arrays_of
from studies.multiverse.learning import MEASURED, NEVER, SUBGOALS, worlds_of

NOT_JUDGED = {
    "selection-cost": "counts the operations of one selection, in which nothing that is drawn enters",
    "space": "is the size of a library in bytes, in which nothing that is drawn enters",
    "E1-frequencies": "needs every pair of start and goal, which would take most of the time of a setting",
    "E3-recovery": "needs the whole curves, which are not kept",
    "curves": "needs the whole curves, which are not kept",
    "reuse-spikes": "needs the whole curves, which are not kept",
}
"""Claims that the study leaves out, and why."""

JUDGED: tuple[Claim, ...] = tuple(claim for claim in claims.CLAIMS if claim.id not in NOT_JUDGED)

LIMIT = "limit"
"""How tables name a reading of "not significant" by as many runs as there are."""

VERDICT_COLUMNS = ("setting", "claim", "words", "tasks", "tolerance", "runs", "holds", "parts", "parts_holding")
ESTIMATE_COLUMNS = ("setting", "environment", "tasks", "method", "measure", "mean", "sd", "seeds")


@dataclass(frozen=True)
class Setting:
    """A setting with what was learned in it.

    Attributes
    ----------
    point : Point
    arrays : mapping
        See `studies.multiverse.learning.learn_point`.
    worlds : mapping
        Its maps by environment.
    tasks : mapping of str to str
        Goal letters of each environment.
    run : Configuration
        The configuration that the setting changes.
    """

    point: Point
    arrays: Mapping[str, np.ndarray]
    worlds: Mapping[str, GridWorld]
    tasks: Mapping[str, str]
    run: Configuration

    @property
    def name(self) -> str:
        """Name of the setting."""
        return self.point.name

    @property
    def status(self) -> str:
        """Whether it is complete, or what is missing."""
        return str(self.arrays["status"].item().decode())

    def evidence(self) -> Evidence:
        """Return its runs as evidence whose intervals are points."""
        runs = {
            (environment, method): self.arrays[f"{environment}/{method}/measured"]
            for environment in self.tasks
            for method in self.point.seeds
            if f"{environment}/{method}/measured" in self.arrays
        }
        frames = [
            _frame(environment, self.tasks[environment], method, values, runs.get((environment, BASE)))
            for (environment, method), values in runs.items()
        ]
        subgoals = [
            _rows(environment, self.tasks[environment], method, SUBGOALS, self.arrays[place])
            for environment, method in runs
            if (place := f"{environment}/{method}/subgoals") in self.arrays
        ]
        return Evidence(
            per_seed=pd.concat(frames, ignore_index=True) if frames else pd.DataFrame(columns=list(PER_SEED_COLUMNS)),
            subgoals=pd.concat(subgoals, ignore_index=True) if subgoals else None,
            worlds=self.worlds,
            growth=self.arrays.get("growth"),
            how=Resampling(self.run.statistics.confidence, 0),
            window=measures_of(self.point.changes, self.run.measures).window,
            breakpoint=self.run.growth.breakpoint,
            episodes=parameters_of(self.point.changes, self.run).learning.episodes,
        )


def settings_in(result: Result, run: Configuration) -> Iterator[Setting]:
    """Yield the settings of a block's file."""
    job = result.job
    for point in job.points:
        worlds = worlds_of(point, result.worlds, list(job.tasks))
        yield Setting(point, arrays_of(point, result.arrays), worlds, job.tasks, run)


def _frame(environment: str, letters: str, method: str, values: np.ndarray, base: np.ndarray | None) -> pd.DataFrame:
    """Return the rows of ``per_seed`` of one method in one environment."""
    names = [measure.__name__ for measure in MEASURED]
    frame = _rows(environment, letters, method, names, values)
    frame["threshold_episode"] = frame["threshold_episode"].mask(frame["threshold_episode"] == NEVER)
    frame["jump_start"] = frame["transfer_ratio"] = np.nan
    seeds = values.shape[1]
    if base is not None and base.shape[1] >= seeds:
        first, total = (base[names.index(name), :seeds].ravel() for name in ("first_episode", "total_steps"))
        frame["jump_start"] = first - frame["first_episode"]
        frame["transfer_ratio"] = (total - frame["total_steps"]) / total
    return frame


def _rows(environment: str, letters: str, method: str, names: Sequence[str], values: np.ndarray) -> pd.DataFrame:
    """Return a row for each run and task of an array (names, seeds, tasks)."""
    seeds = values.shape[1]
    return pd.DataFrame(
        {
            "environment": environment,
            "task": np.tile(list(letters), seeds),
            "method": method,
            "seed": np.repeat(np.arange(seeds), len(letters)),
            **{name: own.ravel() for name, own in zip(names, values, strict=True)},
        }
    )


# -- verdicts ------------------------------------------------------------------------------------------------------


def judgements(evidence: Evidence) -> Iterator[tuple[Claim, Reading, Judgement]]:
    """Yield the judgement on each claim under each of its readings."""
    for reading in dict.fromkeys(reading for claim in JUDGED for reading in claim.readings()):
        read = evidence.under(reading)
        for claim in JUDGED:
            if reading in claim.readings():
                yield claim, reading, claim.judge(read)


def verdict_rows(name: str, evidence: Evidence) -> Iterator[tuple[object, ...]]:
    """Yield a row with `VERDICT_COLUMNS` for each claim and reading, strict and plain; ``holds`` may be missing."""
    for claim, reading, judgement in judgements(evidence):
        for words, parts in ((STRICT, judgement.parts), (PLAIN, judgement.plain)):
            if words == PLAIN and not parts:
                continue
            runs = LIMIT if reading.runs is None else str(reading.runs)
            held = sum(part.outcome is Outcome.HOLDS for part in parts)
            holds = Outcomes.of(reading, words, parts).holds
            value = np.nan if holds is None else float(holds)
            yield name, claim.id, words, reading.tasks, reading.tolerance, runs, value, len(parts), held


# -- estimates -----------------------------------------------------------------------------------------------------

SHOWN = ("first_episode", "jump_start", "asymptotic", "threshold_episode", "total_steps", "transfer_ratio")
"""Measures of which the estimates of each setting are kept."""


def estimate_rows(name: str, evidence: Evidence) -> Iterator[tuple[object, ...]]:
    """Yield a row with `ESTIMATE_COLUMNS` for each environment, task (and B to F together), method and measure.

    A run that never reaches the threshold counts with all its episodes.
    """
    known = evidence.per_seed.groupby(["environment", "method"], sort=False)["task"].unique()
    for (environment, method), letters in known.items():
        for tasks in (*letters, TRANSFER_TASKS):
            for measure in SHOWN:
                try:
                    values = evidence.values(str(environment), tasks, str(method), measure)
                except MissingEvidence:
                    continue
                if measure == "threshold_episode":
                    values = np.nan_to_num(values, nan=float(evidence.length(environment, method, tasks) * len(tasks)))
                deviation = float(np.std(values, ddof=1)) if len(values) > 1 else np.nan
                yield name, environment, tasks, method, measure, float(np.mean(values)), deviation, len(values)


def replicated(setting: Setting, replicates: int, random: np.random.Generator) -> pd.DataFrame:
    """Return the share of replicates of the article's 30 runs in which each claim holds.

    Each replicate draws 30 runs of every method with replacement. Its parts are statements about its means, and its
    significance is that of its own runs.

    Returns
    -------
    DataFrame
        Columns claim, words, tasks, tolerance, runs, printed.
    """
    rows = [
        row
        for replicate in range(replicates)
        for row in verdict_rows(str(replicate), replace(setting, arrays=_resampled(setting.arrays, random)).evidence())
    ]
    frame = pd.DataFrame(rows, columns=list(VERDICT_COLUMNS))
    keys = ["claim", "words", "tasks", "tolerance", "runs"]
    return frame.groupby(keys, sort=False, dropna=False)["holds"].mean().rename("printed").reset_index()


def _resampled(arrays: Mapping[str, np.ndarray], random: np.random.Generator) -> dict[str, np.ndarray]:
    """Return 30 runs of each environment and method, drawn with replacement, whole lives at a time."""
    drawn = dict(arrays)
    for place, values in arrays.items():
        if place.endswith("/measured"):
            runs = random.integers(values.shape[1], size=ARTICLE_RUNS)
            subgoals = f"{place.rpartition('/')[0]}/subgoals"
            drawn |= {name: arrays[name][:, runs] for name in (place, subgoals) if name in arrays}
    if "growth" in arrays:
        drawn["growth"] = arrays["growth"][random.integers(len(arrays["growth"]), size=ARTICLE_RUNS)]
    return drawn
