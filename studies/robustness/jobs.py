"""The kind of job of the study: one setting, all environments, methods and seeds in one file."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Annotated, Any

import numpy as np
from msgspec import Meta

from ptl.claims.comparisons import OTHERS, VARIANTS
from ptl.config import Configuration, Learning
from ptl.errors import UserError
from ptl.files.formats import Array
from ptl.files.job import Job, Number, Positive, Watch, Word, Worlds, register
from ptl.files.outside import sources_of
from ptl.jobs.grow import grows
from ptl.jobs.lives import LIBRARY_SIZE, LIVES, lives_faults
from ptl.keys import ConfigurationError
from ptl.measures.cost import COSTLY, Cost, steps_of_life, steps_of_task, together
from ptl.world.drawing import KINDS
from ptl.world.gridworld import GridWorld
from studies.robustness.design import Point, Robustness
from studies.robustness.running import COMPLETE, changed_worlds, learn_setting

STATES = ("subgoal", "incremental_peak", "original_peak")
"""Arrays of states, whose number depends on the changes of a map."""


@register
class Setting(Job, frozen=True, kw_only=True, tag="setting/1"):
    """All environments and methods under one setting; ``maps`` are those before the changes."""

    name: Annotated[str, Meta(description="name of the setting, and of its random streams", pattern=r"^[a-z0-9_.]+$")]
    group: Annotated[Word, Meta(description="group of settings")]
    changes: Annotated[dict[str, Any], Meta(description="changed unknowns with their values")]
    tasks: Annotated[dict[str, str], Meta(description="goal letters of each environment, in order")]
    methods: Annotated[list[Word], Meta(description="identifiers of the methods")]
    seeds: Annotated[Positive, Meta(description="lives of each method in each environment")]
    step_budget: Annotated[Positive, Meta(description="steps after which a method is given up in an environment")]
    growth_environment: Annotated[Word, Meta(description="environment of the growing library")]
    growth_tasks: Annotated[Positive, Meta(description="tasks in one of its lives")]
    growth_runs: Annotated[Number, Meta(description="its lives")]

    TITLE = "Settings of the robustness study"
    READS = ("learning", "skills", "subgoals", "policy_reuse")
    ARRAYS = {  # noqa: RUF012
        "status": Array("bytes", (), f"`{COMPLETE}`, or what was given up or failed"),
        **{
            f"<environment>/<method>/{name}": array._replace(high=None) if name in STATES else array
            for name, array in LIVES.items()
        },
        "growth/library_size": LIBRARY_SIZE._replace(optional=True),
    }

    @property
    def place(self) -> str:
        """Path of the file below results/<run>/."""
        return f"settings/{self.name}.h5"

    def sources(self) -> str:
        """Return the digest of the present sources."""
        return setting_code(self.methods)

    def run(self, worlds: Worlds, watch: Watch = iter) -> dict[str, np.ndarray]:
        """Learn the setting."""
        return learn_setting(
            worlds,
            self.tasks,
            self.methods,
            self.changes,
            self.settings,
            self.root_seed,
            self.name,
            seeds=self.seeds,
            step_budget=self.step_budget,
            growth=(self.growth_environment, self.growth_tasks, self.growth_runs),
            watch=watch,
        )

    def sizes(self, worlds: Worlds) -> dict[str, int]:
        """Return the numbers of episodes, and of sizes of a growing library."""
        return {"e": self.settings.learning.episodes, "r": self.growth_runs, "g": self.growth_tasks + 1}

    def faults(self, arrays: Mapping[str, np.ndarray], worlds: Worlds) -> Iterator[str]:
        """Yield the impossible values."""
        complete = arrays["status"].item().decode() == COMPLETE
        lives = lives_in(arrays)
        changed = changed_worlds(worlds, self.changes) if lives else {}
        for (environment, method), own in lives.items():
            place, letters = f"{environment}/{method}", self.tasks.get(environment, "")
            if not letters or method not in self.methods:
                yield f"{place}: is not among the lives of its job"
            elif own["steps"].shape[1] != len(letters):
                yield f"{place}: its tasks are not {letters}"
            elif not 1 <= len(own["seeds"]) <= self.seeds or (complete and len(own["seeds"]) < self.seeds):
                yield f"{place}: has {len(own['seeds'])} lives of {self.seeds}"
            elif any((own[name] >= changed[environment].n_states).any() for name in STATES if name in own):
                yield f"{place}: has a state that is not in its map"
            else:
                limit = self.settings.learning.max_steps
                yield from (f"{place}: {fault}" for fault in lives_faults(own, changed[environment], letters, limit))
        sizes = arrays.get("growth/library_size")
        if complete and (len(lives) < len(self.tasks) * len(self.methods) or (sizes is None) == (self.growth_runs > 0)):
            yield f"some of its lives are missing, but its status is {COMPLETE}"
        if sizes is not None and not grows(sizes):
            yield "a library does not grow from 0 by at most one skill a task"


def lives_in(arrays: Mapping[str, np.ndarray]) -> dict[tuple[str, str], dict[str, np.ndarray]]:
    """Return the arrays of the lives of each environment and method."""
    by_method: dict[tuple[str, str], dict[str, np.ndarray]] = {}
    for place, values in arrays.items():
        if place.count("/") == 2:
            environment, method, name = place.split("/")
            by_method.setdefault((environment, method), {})[name] = values
    return by_method


# -- planning -----------------------------------------------------------------------------------------------------


def setting_code(methods: Iterable[str]) -> str:
    """Return the digest of the sources that a setting with these methods depends on."""
    return sources_of("studies.robustness.running", *(f"ptl.methods.{name}" for name in methods))


def setting_jobs(study: Robustness, run: Configuration, maps: Mapping[str, str]) -> dict[str, Setting]:
    """Return the job of every point of the study by place.

    Methods of the run that no claim is about are left out.

    Parameters
    ----------
    run : Configuration
        Complete; the base from which the settings differ.
    maps : mapping
        Digest of the map of each environment.

    Raises
    ------
    UserError
        If the run cannot have a setting: an environment that it does not have, or a value that does not fit others.
    """
    methods = [name for name in run.methods if name in (*OTHERS, *VARIANTS)]
    code = setting_code(methods)
    jobs = (_job(point, study, run, methods, maps, code) for point in study.points())
    return {job.place: job for job in jobs}


def _job(
    point: Point, study: Robustness, run: Configuration, methods: list[str], maps: Mapping[str, str], code: str
) -> Setting:
    changes = {"learning__max_steps": study.max_steps}
    for unknown, value in point.changes.items():
        group, _, name = unknown.partition(".")
        if name not in KINDS:
            changes[f"{group}__{name}"] = value
        elif group not in run.environments:
            known = ", ".join(run.environments)
            raise ConfigurationError(f"unknowns.{unknown}", f"environment {group} is not in this run ({known})")
    try:
        changed = run.replace(**changes)
    except ConfigurationError as error:
        raise UserError(f"robustness study, setting {point.name}: {error}") from error
    return Setting(
        root_seed=run.root_seed,
        parameters={name: getattr(changed, name).to_dict() for name in Setting.READS},
        maps={name: maps[name] for name in run.environments},
        code=code,
        name=point.name,
        group=point.group,
        changes=point.changes,
        tasks={name: entry.tasks for name, entry in run.environments.items()},
        methods=methods,
        seeds=study.seeds,
        step_budget=study.step_budget,
        growth_environment=run.growth.environment,
        growth_tasks=study.growth.tasks,
        growth_runs=study.growth.runs,
    )


def settings_cost(jobs: Iterable[Setting], worlds: Mapping[str, GridWorld]) -> Cost:
    """Estimate the total cost of settings; ``worlds`` are the maps before they are changed."""
    number, lives, steps = 0, 0, 0.0
    for job in jobs:
        learning: Learning = job.settings.learning
        number += 1
        lives += job.seeds * len(job.methods) * len(job.tasks) + job.growth_runs
        for name, letters in job.tasks.items():
            taken = job.seeds * steps_of_life(worlds[name], letters, learning)
            steps += sum(min(taken * COSTLY.get(method, 1), job.step_budget) for method in job.methods)
        world = worlds[job.growth_environment]
        steps += job.growth_runs * job.growth_tasks * steps_of_task(world.n_states, world.diagonal, learning)
    return together(number, lives, steps)
