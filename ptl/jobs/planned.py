"""From a run's configuration to its jobs: every learning, growth and survey job by the place of its file."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from ptl import methods
from ptl.config import Configuration, Environment
from ptl.errors import UserError
from ptl.files.outside import learning_code, sources_of
from ptl.jobs.grow import Grow
from ptl.jobs.learn import Learn
from ptl.jobs.survey import Survey
from ptl.learning.growth import METHOD

MISLEADING, MISLEADING_ENTRY = "misleading_prior", Environment(map="config/misleading_prior.txt", tasks="ABC")
"""A small map of ours on which the prior misleads, for a figure of the article's run."""

Digests = Mapping[str, str]
"""Digest of the map of each environment."""


def groups_of(run: Configuration, names: Iterable[str]) -> dict[str, dict[str, Any]]:
    """Return groups of the configuration as plain data."""
    return {name: getattr(run, name).to_dict() for name in names}


def learning_jobs(run: Configuration, maps: Digests) -> dict[str, Learn]:
    """Return the learning jobs by environment, method and seed, in the order of the tables."""
    codes = {reference: learning_code(reference) for reference in run.methods}
    jobs = [
        _learning_job(run, maps, environment, entry, reference, codes[reference], seed)
        for environment, entry in run.environments.items()
        for reference in run.methods
        for seed in range(run.seeds)
    ]
    return _by_place(jobs)


def misleading_jobs(run: Configuration, maps: Digests) -> dict[str, Learn]:
    """Return the jobs of ``ptl`` on the map where the prior misleads, which only an article's run has.

    Raises
    ------
    UserError
        If the run has an environment of that name.
    """
    if not run.article or METHOD not in run.methods:
        return {}
    if MISLEADING in run.environments:
        raise UserError(f"environments.{MISLEADING}: is the name of a map of figure 4; give another name")
    code = learning_code(METHOD)
    seeds = range(run.seeds)
    return _by_place([_learning_job(run, maps, MISLEADING, MISLEADING_ENTRY, METHOD, code, seed) for seed in seeds])


def _learning_job(
    run: Configuration, maps: Digests, environment: str, entry: Environment, reference: str, code: str, seed: int
) -> Learn:
    method = methods.identifier(reference)
    return Learn(
        root_seed=run.root_seed,
        parameters=groups_of(run, Learn.READS),
        maps={environment: maps[environment]},
        code=code,
        slip=entry.map_options.slip,
        environment=environment,
        tasks=entry.tasks,
        method=method,
        reference=reference,
        own=run.method_parameters.get(method, {}),
        seed=seed,
    )


def growth_jobs(run: Configuration, maps: Digests) -> dict[str, Grow]:
    """Return the growth jobs."""
    environment = run.growth.environment
    code = learning_code(METHOD, "ptl.learning.growth")
    return _by_place(
        Grow(
            root_seed=run.root_seed,
            parameters=groups_of(run, Grow.READS),
            maps={environment: maps[environment]},
            code=code,
            slip=run.environments[environment].map_options.slip,
            environment=environment,
            tasks=run.growth.tasks,
            seed=seed,
        )
        for seed in range(run.growth.runs)
    )


def survey_jobs(run: Configuration, maps: Digests) -> dict[str, Survey]:
    """Return the survey jobs, one for each environment or none; `Survey.parts` shares one out to batches."""
    code = sources_of("ptl.learning.survey")
    survey = run.subgoal_frequencies
    return _by_place(
        Survey(
            root_seed=run.root_seed,
            parameters=groups_of(run, Survey.READS),
            maps={environment: maps[environment]},
            code=code,
            slip=entry.map_options.slip,
            environment=environment,
            trajectories=survey.trajectories,
            starts=survey.starts,
        )
        for environment, entry in (run.environments.items() if survey.starts else ())
    )


def _by_place(jobs: Iterable[Any]) -> dict[str, Any]:
    return {job.place: job for job in jobs}
