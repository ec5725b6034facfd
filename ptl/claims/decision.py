"""Decide the run's claims on as many runs as their verdicts need, and on no fewer.

Runs are added in looks. After each look the claims are judged, and only environments and methods that a part which is
still open speaks of get more runs. The error over all looks is bounded: a part is judged at look k with an interval
whose error is the share of the error 1 - confidence that look k is given, in proportion to its runs, so that the sum
over all looks is 1 - confidence (union bound; the idea of comparing agents by a group-sequential test with early
stopping is that of AdaStop, Mathieu et al., arXiv:2306.10882). Intervals are those of large samples.

The random streams differ from those of the tables, so a claim is decided by runs that the tables do not show.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from ptl.claims.claim import Judgement
from ptl.claims.comparisons import OTHERS, VARIANTS
from ptl.claims.curves import ENVIRONMENTS
from ptl.claims.evidence import Evidence, settings_of
from ptl.claims.verdict import Outcome
from ptl.config import Configuration
from ptl.files.outside import learning_code
from ptl.files.store import Result
from ptl.jobs.lives import Libraries, Lives
from ptl.jobs.planned import Digests, groups_of
from ptl.learning.growth import METHOD
from ptl.measures.measures import BASE, Runs, measure, runs_of
from ptl.measures.statistics import Resampling
from ptl.world.gridworld import GridWorld

Pair = tuple[str, str]
"""Environment and method, or environment and "growth"."""


def decision_jobs(run: Configuration, maps: Digests) -> dict[str, Lives | Libraries]:
    """Return the jobs of all looks by place; environments and methods that no claim mentions have none."""
    jobs: list[Lives | Libraries] = []
    for look, (first, last) in enumerate(zip((0, *run.decision.looks), run.decision.looks, strict=False), start=1):
        jobs += [
            Lives(
                root_seed=run.root_seed,
                parameters=groups_of(run, Lives.READS),
                maps={environment: maps[environment]},
                code=learning_code(method, "ptl.learning.lives"),
                slip=entry.map_options.slip,
                name=f"{environment}_{method}",
                environment=environment,
                tasks=entry.tasks,
                method=method,
                look=look,
                first=first,
                seeds=last - first,
            )
            for environment, entry in run.environments.items()
            if environment in ENVIRONMENTS
            for method in run.methods
            if method in (*OTHERS, *VARIANTS)
        ]
        environment = run.growth.environment
        if environment in ENVIRONMENTS:
            jobs.append(
                Libraries(
                    root_seed=run.root_seed,
                    parameters=groups_of(run, Libraries.READS),
                    maps={environment: maps[environment]},
                    code=learning_code(METHOD, "ptl.learning.lives"),
                    slip=run.environments[environment].map_options.slip,
                    environment=environment,
                    tasks=run.growth.tasks,
                    look=look,
                    first=first,
                    runs=last - first,
                )
            )
    return {job.place: job for job in jobs}


def confidence_at(look: int, looks: Sequence[int], confidence: float) -> float:
    """Return the level of the intervals at a look, counted from 1."""
    return 1 - (1 - confidence) * looks[look - 1] / sum(looks)


def open_pairs(judgements: Iterable[Judgement]) -> set[Pair]:
    """Return the environments and methods that a part which is still open speaks of.

    Every method is compared with the base, seed by seed, so the base of an environment goes on with any of its methods.
    """
    parts = [part for judgement in judgements for part in (*judgement.parts, *judgement.plain)]
    pairs = {pair for part in parts if part.outcome is Outcome.OPEN for pair in part.uses}
    return pairs | {(environment, BASE) for environment, method in pairs if environment}


def goes_on(job: Lives | Libraries, pairs: set[Pair]) -> bool:
    """Return whether a job of the next look is needed."""
    return ("", Libraries.NAME) in pairs if isinstance(job, Libraries) else job.pair in pairs


def evidence_of(results: Iterable[Result], groups: Any, confidence: float, **tables: Any) -> Evidence:
    """Return the files of all looks as evidence; first episodes are compared with their exact expectation.

    Parameters
    ----------
    results : iterable of Result
        In the order of the looks.
    groups : namespace
        Groups learning, measures, statistics and growth of the configuration.
    confidence : float
        See `confidence_at`.
    tables
        As in `ptl.claims.evidence.Evidence`.
    """
    lives: dict[Pair, list[Result]] = {}
    worlds: dict[str, GridWorld] = {}
    for result in results:
        worlds |= result.worlds
        lives.setdefault(result.job.pair, []).append(result)
    runs: list[Runs] = []
    growth = None
    for (environment, method), parts in lives.items():
        arrays = {name: np.concatenate([part.arrays[name] for part in parts]) for name in parts[0].arrays}
        if method == Libraries.NAME:
            growth = arrays["library_size"]
        else:
            runs += runs_of(environment, method, parts[0].job.tasks, arrays)
    measured = measure(runs, worlds, groups.measures.window, groups.measures.threshold_factor, groups.learning)
    settings = settings_of(groups) | {"how": Resampling(confidence, 0, normal=True)}
    return Evidence(
        per_seed=measured.per_seed,
        worlds=worlds,
        steps=measured.steps,
        subgoals=measured.subgoals,
        growth=growth,
        **tables,
        **settings,
    )
