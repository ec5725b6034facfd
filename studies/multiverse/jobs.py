"""The kind of job of the study: a block of settings, all environments, methods and seeds in one file."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from typing import Annotated

import numpy as np
from msgspec import Meta

from ptl.config import Configuration, Learning, Measures
from ptl.errors import UserError
from ptl.files.formats import Array
from ptl.files.job import Job, Positive, Watch, Word, Worlds, register
from ptl.files.provenance import LEARNING, code_digest
from ptl.jobs.grow import grows
from ptl.keys import ConfigurationError
from ptl.measures.cost import COSTLY, Cost, steps_of_life, steps_of_task, together
from ptl.world.gridworld import GridWorld
from studies.multiverse.design import PARAMETERS, Multiverse, Point, measures_of, parameters_of
from studies.multiverse.learning import COMPLETE, MEASURED, NEVER, SUBGOALS, learn_point, worlds_of


@register
class Block(Job, frozen=True, kw_only=True, tag="multiverse/1"):
    """Some settings; ``parameters`` and ``maps`` are those before the changes."""

    number: Annotated[int, Meta(description="number of the block, from 0", ge=0)]
    points: Annotated[list[Point], Meta(description="settings")]
    measures: Annotated[Measures, Meta(description="settings of the measures before the changes")]
    tasks: Annotated[dict[str, str], Meta(description="goal letters of each environment, in order")]
    step_budget: Annotated[Positive, Meta(description="steps for each planned run of a method")]
    growth_environment: Annotated[Word, Meta(description="environment of the growing library")]
    growth_tasks: Annotated[Positive, Meta(description="tasks in one of its lives")]

    TITLE = "Settings of the multiverse"
    READS = PARAMETERS
    ARRAYS = {  # noqa: RUF012
        "<setting>/status": Array("bytes", (), f"`{COMPLETE}`, or what was given up or failed"),
        "<setting>/growth": Array("int64", ("r", "g"), "skills after 0, 1, ... tasks of each life", 0, None, True),
        "<setting>/<environment>/<method>/measured": Array(
            "float64",
            (len(MEASURED), "s", "t"),
            f"{', '.join(measure.__name__ for measure in MEASURED)} of each run and task; {NEVER:g}: never reached",
            NEVER,
        ),
        "<setting>/<environment>/<method>/subgoals": Array(
            "int64", (len(SUBGOALS), "s", "t"), f"{', '.join(SUBGOALS)} of each run and task, −1: none", -1, None, True
        ),
    }

    @property
    def place(self) -> str:
        """Path of the file below results/<run>/."""
        return f"blocks/{self.number:04d}.h5"

    def sources(self) -> str:
        """Return the digest of the present sources."""
        return sources(methods_of(self.points))

    def run(self, worlds: Worlds, watch: Watch = iter) -> dict[str, np.ndarray]:
        """Learn the settings."""
        arrays: dict[str, np.ndarray] = {}
        for point in watch(self.points):
            learned = learn_point(
                point,
                worlds,
                self.tasks,
                self.settings,
                self.measures,
                self.root_seed,
                self.step_budget,
                (self.growth_environment, self.growth_tasks),
            )
            arrays |= {f"{point.name}/{place}": values for place, values in learned.items()}
        return arrays

    def sizes(self, worlds: Worlds) -> dict[str, int]:
        """Return the number of sizes of a growing library."""
        return {"g": self.growth_tasks + 1}

    def faults(self, arrays: Mapping[str, np.ndarray], worlds: Worlds) -> Iterator[str]:
        """Yield the impossible values."""
        for point in self.points:
            own = arrays_of(point, arrays)
            complete = "status" in own and own["status"].item().decode() == COMPLETE
            wanted = {f"{name}/{method}/measured" for name in self.tasks for method in point.seeds}
            if complete and wanted - set(own):
                yield f"{point.name}: some of its runs are missing, but its status is {COMPLETE}"
            if "growth" in own and not grows(own["growth"]):
                yield f"{point.name}: a library does not grow from 0 by at most one skill a task"
            changed = worlds_of(point, worlds, list(self.tasks)) if wanted & set(own) else {}
            least = {name: self._shortest_episodes(point, name, world) for name, world in changed.items()}
            for place in sorted(set(own) - {"status", "growth"}):
                yield from self._faults_of(point, place, own[place], changed, least)

    def _shortest_episodes(self, point: Point, environment: str, world: GridWorld) -> np.ndarray:
        """Return the steps that no episode of each task can have less of, int array (tasks,)."""
        paths = world.distances_to(world.start)[[world.goal(letter) for letter in self.tasks[environment]]]
        return np.minimum(paths, parameters_of(point.changes, self.settings).learning.max_steps)

    def _faults_of(
        self,
        point: Point,
        place: str,
        values: np.ndarray,
        worlds: Mapping[str, GridWorld],
        least: Mapping[str, np.ndarray],
    ) -> Iterator[str]:
        environment, method, name = place.split("/")
        letters = self.tasks.get(environment, "")
        if not letters or method not in point.seeds:
            yield f"{point.name}/{place}: is not of this job"
        elif values.shape[2] != len(letters):
            yield f"{point.name}/{place}: its tasks are not {letters}"
        elif values.shape[1] > point.seeds[method]:
            yield f"{point.name}/{place}: has {values.shape[1]} runs of {point.seeds[method]}"
        elif name == "subgoals" and values.max(initial=-1) >= worlds[environment].n_states:
            yield f"{point.name}/{place}: has a state that is not in its map"
        elif name == "measured" and (values[0] < least[environment]).any():
            yield f"{point.name}/{place}: an episode is shorter than the shortest path"


def arrays_of(point: Point, arrays: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return the arrays of one setting, its name left out."""
    start = f"{point.name}/"
    return {name.removeprefix(start): values for name, values in arrays.items() if name.startswith(start)}


# -- planning -----------------------------------------------------------------------------------------------------


def methods_of(points: Iterable[Point]) -> frozenset[str]:
    """Return the methods that are learned in some settings."""
    return frozenset(name for point in points for name in point.seeds)


@cache
def sources(methods: frozenset[str]) -> str:
    """Return the digest of the sources that settings with these methods depend on."""
    modules = ("studies.multiverse.learning", *(f"ptl.methods.{name}" for name in sorted(methods)))
    return code_digest(*modules, within=(*LEARNING, "ptl.measures.measures"))


def block_jobs(study: Multiverse, run: Configuration, maps: Mapping[str, str]) -> dict[str, Block]:
    """Return the job of every block by place; each named setting has a block of its own.

    Parameters
    ----------
    run : Configuration
        Complete; the base from which the settings differ.
    maps : mapping
        Digest of each environment's map, and of those of the named settings.

    Raises
    ------
    UserError
        If a setting has a value that does not fit others, or a map that does not exist.
    """
    points = study.points()
    for point in points:
        _check(point, run, maps)
    named, drawn = points[: len(study.named)], points[len(study.named) :]
    starts = range(0, len(drawn), study.block)
    blocks = [*([point] for point in named), *(drawn[start : start + study.block] for start in starts)]
    jobs = (
        Block(
            root_seed=run.root_seed,
            parameters={name: getattr(run, name).to_dict() for name in PARAMETERS},
            maps={name: maps[name] for name in [*run.environments, *_extra(block)]},
            code=sources(methods_of(block)),
            number=number,
            points=block,
            measures=run.measures,
            tasks={name: entry.tasks for name, entry in run.environments.items()},
            step_budget=study.step_budget,
            growth_environment=run.growth.environment,
            growth_tasks=study.growth.tasks,
        )
        for number, block in enumerate(blocks)
    )
    return {job.place: job for job in jobs}


def _extra(block: list[Point]) -> list[str]:
    return sorted({name for point in block for name in point.maps.values()})


def _check(point: Point, run: Configuration, maps: Mapping[str, str]) -> None:
    try:
        parameters = parameters_of(point.changes, run)
        measures = measures_of(point.changes, run.measures)
        if measures.window > parameters.learning.episodes:
            raise ConfigurationError(
                "measures.window",
                f"{measures.window} must not exceed learning.episodes ({parameters.learning.episodes})",
            )
    except ConfigurationError as error:
        raise UserError(f"multiverse, setting {point.name}: {error}") from error
    unknown = {*point.maps, *point.maps.values()} - set(maps)
    if unknown:
        raise UserError(f"multiverse, setting {point.name}: {unknown.pop()} is no map; known are {', '.join(maps)}")


def cost_of(jobs: Iterable[Block], worlds: Mapping[str, GridWorld]) -> Cost:
    """Estimate the cost of all settings; ``worlds`` are the maps before they are changed."""
    number, lives, steps = 0, 0, 0.0
    for job in jobs:
        number += 1
        for point in job.points:
            learning: Learning = parameters_of(point.changes, job.settings).learning
            lives += sum(point.seeds.values()) * len(job.tasks) + point.growth_runs
            for name, letters in job.tasks.items():
                one = steps_of_life(worlds[name], letters, learning)
                steps += sum(
                    seeds * min(one * COSTLY.get(method, 1), job.step_budget) for method, seeds in point.seeds.items()
                )
            world = worlds[job.growth_environment]
            steps += point.growth_runs * job.growth_tasks * steps_of_task(world.n_states, world.diagonal, learning)
    return together(number, lives, steps)
