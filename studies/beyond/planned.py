"""From the configuration of the second study to its maps and jobs, and what they cost."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from ptl import methods
from ptl.config import check_tasks
from ptl.errors import UserError
from ptl.files.outside import learning_code
from ptl.jobs.learn import Learn
from ptl.measures.cost import COSTLY, Cost, steps_of_life, steps_of_task, together
from ptl.world.gridworld import GridWorld, map_digest
from ptl.world.map_files import load_map
from ptl.world.mazes import GOALS
from studies.beyond.design import ARTICLE, SecondStudy
from studies.beyond.jobs import LIVES, LivesOnMaps
from studies.beyond.lives import NO_CHANGE
from studies.beyond.maps import MAIN, RETURNING
from studies.beyond.methods import reference
from studies.beyond.population import TABLE, MapEntry, read_population

MOVING_AI = "moving_ai"
"""Family of the maps that the key of this name lists; they may have any format that `ptl.world.map_files` reads."""

Population = Mapping[tuple[str, int], MapEntry]
"""Rows of the table by family and seed."""


@dataclass(frozen=True)
class GivenMap:
    """A map that is a file.

    Attributes
    ----------
    path : str
    world : GridWorld
        With start and goals.
    """

    path: str
    world: GridWorld

    @property
    def digest(self) -> str:
        """Digest of the map."""
        return map_digest(self.world.text)


# -- maps ---------------------------------------------------------------------------------------------------------


def population_of(study: SecondStudy) -> dict[tuple[str, int], MapEntry]:
    """Return the row of each generated map of a study.

    Raises
    ------
    UserError
        If the table lacks a map.
    """
    rows = {(entry.family, entry.seed): entry for entry in read_population() if entry.size == study.size}
    places = [(family, seed) for family in study.families for seed in study.seeds_of_maps]
    for family, seed in places:
        if (family, seed) not in rows:
            raise UserError(
                f"{TABLE}: has no map of the family {family}, size {study.size} and seed {seed}; make the table again"
                " with 'python -m studies.beyond.population'"
            )
    return {place: rows[place] for place in places}


def given_maps(study: SecondStudy) -> dict[tuple[str, str], GivenMap]:
    """Return the maps of a study that are files, by family and name.

    Raises
    ------
    UserError
        If a map cannot be read, or lacks a task.
    """
    given = {}
    for name, entry in study.article_maps.items():
        given[name, name] = GivenMap(entry.map, load_map(entry.map))
        check_tasks(entry.tasks, given[name, name].world.goals, f"article_maps.{name}.tasks")
    for path in study.moving_ai:
        given[MOVING_AI, Path(path).stem] = GivenMap(path, load_map(path))
    return given


def shown(study: SecondStudy) -> list[tuple[str, int]]:
    """Return family and seed of each map that the explorer shows."""
    seeds = study.seeds_of_maps[: study.explorer.maps] if study.explorer.methods else ()
    return [(family, seed) for family in study.families for seed in seeds]


# -- jobs ---------------------------------------------------------------------------------------------------------


def lives_jobs(
    study: SecondStudy, population: Population, given: Mapping[tuple[str, str], GivenMap]
) -> dict[str, LivesOnMaps]:
    """Return the jobs of a study by the place of their files."""
    codes = {name: learning_code(reference(name), LIVES) for name in study.methods}
    jobs = [
        LivesOnMaps(
            root_seed=study.root_seed,
            parameters=study.groups(LivesOnMaps.READS),
            maps=maps,
            code=codes[name],
            family=family,
            size=size,
            sequence=sequence,
            tasks=tasks,
            seeds=seeds,
            method=methods.identifier(reference(name)),
            reference=reference(name),
            per_task=per_task,
            slip=slip,
            change=change,
        )
        for family, size, sequence, tasks, seeds, maps, name, per_task, slip, change in _designed(
            study, population, given
        )
    ]
    return {job.place: job for job in jobs}


def _designed(
    study: SecondStudy, population: Population, given: Mapping[tuple[str, str], GivenMap]
) -> Iterator[tuple[str, int, str, str, int, dict[str, str], str, int, float, str]]:
    """Yield family, size, sequence, tasks, lives on each map, maps, method, skills added a task, slip and change."""
    sizes, others, harder, returning = study.library_sizes, study.sequences, study.harder, study.returning
    worlds = [*((slip, NO_CHANGE) for slip in harder.slips), *((0.0, change) for change in harder.changes)]
    as_they_are = [(name, 0) for name in study.methods]
    sized = [(name, number) for name in sizes.methods for number in sizes.per_task]
    certain = (0.0, NO_CHANGE)
    lives, again = study.seeds, GOALS + GOALS[0]
    plans = [(MAIN, GOALS, lives, study.maps, *variant, *certain) for variant in as_they_are]
    plans += [
        (order, GOALS, lives, others.maps, name, 0, *certain) for order in others.names for name in others.methods
    ]
    plans += [(MAIN, GOALS, lives, sizes.maps, *variant, *certain) for variant in sized]
    plans += [(MAIN, GOALS, lives, harder.maps, name, 0, *world) for world in worlds for name in harder.methods]
    plans += [(RETURNING, again, returning.seeds, returning.maps, name, 0, *certain) for name in returning.methods]
    for family in study.families:
        for sequence, tasks, lives, number, name, per_task, slip, change in plans:
            seeds = study.seeds_of_maps[:number]
            for batch in (seeds[first : first + study.batch] for first in range(0, len(seeds), study.batch)):
                maps = {str(seed): population[family, seed].hash for seed in batch}
                yield family, study.size, sequence, tasks, lives, maps, name, per_task, slip, change
    for name, per_task in (*as_they_are, *sized):
        for family, entry in study.article_maps.items():
            maps = {family: given[family, family].digest}
            yield family, 0, ARTICLE, entry.tasks, study.article_seeds, maps, name, per_task, *certain
        for place in (Path(path).stem for path in study.moving_ai):
            maps = {place: given[MOVING_AI, place].digest}
            tasks = "".join(given[MOVING_AI, place].world.goals)
            yield MOVING_AI, 0, MAIN, tasks, study.seeds, maps, name, per_task, *certain
    for name, world in itertools.product(harder.methods, worlds):
        for family, entry in study.article_maps.items():
            maps = {family: given[family, family].digest}
            yield family, 0, ARTICLE, entry.tasks, harder.article_seeds, maps, name, 0, *world
    for name in returning.methods:
        for family, entry in study.article_maps.items():
            maps = {family: given[family, family].digest}
            tasks = entry.tasks + entry.tasks[0]
            yield family, 0, RETURNING, tasks, returning.article_seeds, maps, name, 0, *certain


def shown_jobs(study: SecondStudy, population: Population) -> dict[str, Learn]:
    """Return the jobs whose lives the explorer shows, by the place of their files."""
    jobs = [
        Learn(
            root_seed=study.root_seed,
            parameters=study.groups(Learn.READS),
            maps={population[place].name: population[place].hash},
            code=learning_code(reference(name)),
            environment=population[place].name,
            tasks=GOALS,
            method=methods.identifier(reference(name)),
            reference=reference(name),
            seed=0,
        )
        for place in shown(study)
        for name in study.explorer.methods
    ]
    return {job.place: job for job in jobs}


# -- cost ---------------------------------------------------------------------------------------------------------


def cost_of_lives(
    jobs: Iterable[LivesOnMaps], population: Population, given: Mapping[tuple[str, str], GivenMap]
) -> Cost:
    """Estimate the total cost of jobs."""
    number, lives, steps = 0, 0, 0.0
    for job in jobs:
        number += 1
        lives += job.seeds * len(job.maps)
        learning = job.settings.learning
        for place in job.places:
            if job.size:
                entry = population[job.family, int(place)]
                lengths = [entry.shortest_paths[GOALS.index(letter)] for letter in job.tasks]
                taken = sum(steps_of_task(entry.states, length, learning) for length in lengths)
            else:
                taken = steps_of_life(given[job.family, place].world, job.tasks, learning)
            steps += job.seeds * taken * COSTLY.get(job.method, 1)
    return together(number, lives, steps)
