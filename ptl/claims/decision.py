"""Decide the run's claims on many more seeds than its tables have, learned in few jobs.

The random streams differ from those of the tables, so a claim is decided by runs that the tables do not show.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from ptl.claims.comparisons import FULL, OTHERS, VARIANTS
from ptl.claims.curves import ENVIRONMENTS
from ptl.claims.evidence import Evidence, settings_of
from ptl.config import Configuration
from ptl.files.outside import learning_code
from ptl.files.store import Result
from ptl.jobs.lives import Libraries, Lives
from ptl.jobs.planned import Digests, groups_of
from ptl.learning.growth import METHOD
from ptl.measures.measures import BASE, Runs, measure, runs_of
from ptl.world.gridworld import GridWorld


def decision_jobs(run: Configuration, maps: Digests) -> dict[str, Lives | Libraries]:
    """Return the jobs by place; environments and methods that no claim mentions have none."""
    seeds = {FULL: run.decision.full_transfer_seeds, BASE: run.decision.no_transfer_seeds}
    jobs: list[Lives | Libraries] = [
        Lives(
            root_seed=run.root_seed,
            parameters=groups_of(run, Lives.READS),
            maps={environment: maps[environment]},
            code=learning_code(method, "ptl.learning.lives"),
            name=f"{environment}_{method}",
            environment=environment,
            tasks=entry.tasks,
            method=method,
            seeds=seeds.get(method, run.decision.seeds),
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
                environment=environment,
                tasks=run.growth.tasks,
                runs=run.decision.growth_runs,
            )
        )
    return {job.place: job for job in jobs}


def evidence_of(results: Iterable[Result], groups: Any, **tables: Any) -> Evidence:
    """Return the files of all deciding jobs as evidence; first episodes are compared with their exact expectation.

    Parameters
    ----------
    results : iterable of Result
    groups : namespace
        Groups measures, statistics and growth of the configuration.
    tables
        As in `ptl.claims.evidence.Evidence`.
    """
    runs: list[Runs] = []
    worlds: dict[str, GridWorld] = {}
    growth = None
    for result in results:
        job = result.job
        worlds |= result.worlds
        if isinstance(job, Libraries):
            growth = result.arrays["library_size"]
        else:
            runs += runs_of(job.environment, job.method, job.tasks, result.arrays)
    measured = measure(runs, worlds, groups.measures.window, groups.measures.threshold_factor)
    return Evidence(
        per_seed=measured.per_seed,
        worlds=worlds,
        steps=measured.steps,
        subgoals=measured.subgoals,
        growth=growth,
        exact=True,
        **tables,
        **settings_of(groups),
    )
