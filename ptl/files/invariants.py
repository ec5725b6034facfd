"""What the numbers in a result file must be to each other, whatever made them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Annotated, Any

import msgspec
import numpy as np

from ptl import methods
from ptl.agent.skills import Skill
from ptl.config import TASKS, Learning, Parameters
from ptl.errors import UserError
from ptl.files.schema import (
    FIT,
    FREQUENCIES,
    GAIN,
    GROWTH,
    LEARNING,
    LIVES,
    SETTING,
    STEPS,
    learning_parameters,
)
from ptl.keys import key
from ptl.learning.starts import chosen_starts
from ptl.world.gridworld import GridWorld
from ptl.world.mazes import GOALS

if TYPE_CHECKING:
    from ptl.files.hdf5 import Node
    from ptl.files.results import LearningFile, ResultFile, TaskView

COMPLETE = "complete"
"""Status of a setting of which nothing was given up and nothing failed."""


def impossible(kind: str, content: Any) -> Iterator[str]:
    """Yield what is impossible in a file that fits the declaration of its kind.

    ``content`` is what the functions of `CHECKS` take: a `ptl.files.results.ResultFile` for the kinds that have one,
    for other kinds the root of the file.
    """
    return CHECKS[kind](content)


# -- learning, growth and frequencies -----------------------------------------------------------------------------


def _learning(result: LearningFile) -> Iterator[str]:
    world = result.world
    learning = learning_parameters(result.parameters).learning
    options = 1
    ours = result.method in methods.names()  # another method may mean something else by Q, and draw what is no skill
    for index, (name, task) in enumerate(result.tasks.items()):
        if (task.start, task.goal) != (world.start, world.goals.get(name)):
            yield f"task {name}: does not lead from the start of the map to its goal {name}"
            continue
        yield from _episodes(name, task, world.shortest_path_length(task.start, task.goal), learning.max_steps)
        if task.novelty > world.n_states - 1 or task.diameter > world.n_states - 1:
            yield f"task {name}: its novelty or diameter is longer than any path without loops"
        if ours:
            if not ((task.q >= 0).all() and (task.q <= 1).all()):
                yield f"task {name}: a value of Q is outside [0, 1]"
            if task.q[task.goal].any() and result.method != "full_transfer":
                yield f"task {name}: Q is not zero at the goal, where no action is taken"
            if task.subgoal >= 0 and task.diameter == 0:
                yield f"task {name}: has a new subgoal though its diameter is 0"
        yield from _selection(name, task, options if ours else None)
        if task.subgoal >= 0 and not (task.seen[task.subgoal] or task.subgoal == task.goal):
            yield f"task {name}: the new subgoal was never visited"
        options += result.library is None or task.subgoal >= 0
        if result.library is not None:
            learned = [skill.subgoal for skill in result.library if skill.learned_after == index]
            if learned != [task.subgoal] * (task.subgoal >= 0):
                yield f"task {name}: the library does not hold the subgoal found"
    yield from _library(result, len(result.tasks))


def _episodes(name: str, task: TaskView, shortest: int, limit: int) -> Iterator[str]:
    if (task.steps[~task.truncated] < shortest).any():
        yield f"task {name}: an episode is shorter than the shortest path of {shortest} steps"
    if task.steps.max() > limit:
        yield f"task {name}: an episode is longer than learning.max_steps ({limit})"
    elif (task.steps[task.truncated] < limit).any():
        yield f"task {name}: a truncated episode is shorter than learning.max_steps ({limit})"


def _selection(name: str, task: TaskView, options: int | None) -> Iterator[str]:
    selected, offsets = task.selected, task.selected_offsets
    if offsets[0] != 0 or (np.diff(offsets) < 0).any() or offsets[-1] != len(selected):
        yield f"task {name}: the skills drawn do not fit the episodes"
    elif options is not None and len(selected) and selected.max() >= options:
        yield f"task {name}: a skill was drawn that did not exist yet"


def _growth(result: ResultFile) -> Iterator[str]:
    world, learning = result.world, learning_parameters(result.parameters).learning
    starts, goals, total = (result.file[name] for name in ("starts", "goals", "total_steps"))
    if not _grows(result.file["library_size"]):
        yield "its library does not grow from 0 by at most one skill a task"
    if len(result.library or []) != result.file["library_size"][-1]:
        yield "its library is not of the size that it says"
    shortest = np.array([world.shortest_path_length(*task) for task in zip(starts, goals, strict=True)], dtype=np.int64)
    if (shortest <= 0).any():
        yield "a task has no way from its start to another state"
    elif (total < learning.episodes * np.minimum(shortest, learning.max_steps)).any():
        yield "a task took fewer steps than its shortest path in every episode"
    if (total > learning.episodes * learning.max_steps).any():
        yield "a task took more steps than learning.max_steps in every episode"
    yield from _library(result, len(starts))


def _grows(sizes: np.ndarray) -> bool:
    """Return whether libraries (last axis) grow from 0 by at most one skill a task."""
    return not sizes[..., 0].any() and bool(np.isin(np.diff(sizes), (0, 1)).all())


def _frequencies(result: ResultFile) -> Iterator[str]:
    attrs, counts, unresolved = result.file.attrs, result.file["counts"], int(result.file["unresolved"])
    if attrs.get("batch", 0) >= attrs.get("batches", 1):
        yield "its batch is none of its batches"
    elif attrs["starts"] > result.world.n_states:
        yield "it has more starts than the map has states"
    elif (pairs := int(result.file["pairs"])) != (expected := _pairs(result)):
        yield f"it has {pairs} pairs of start and goal where the map and its starts give {expected}"
    elif sum(counts.tolist()) + unresolved != pairs:  # Python's sum cannot overflow
        yield "its counts do not add up to the number of pairs"


def _pairs(result: ResultFile) -> int:
    """Return the number of pairs of a start and another state that it reaches, among the goals of the batch."""
    from scipy.sparse import csr_array  # not needed, and slow to import, for other kinds
    from scipy.sparse.csgraph import connected_components

    world, attrs = result.world, result.file.attrs
    n = world.n_states
    starts = chosen_starts(world, attrs["starts"], result.root_seed, result.environment)
    goals = np.arange(n)[attrs.get("batch", 0) :: attrs.get("batches", 1)]
    moves = (np.repeat(np.arange(n), world.successors.shape[1]), world.successors.ravel())
    _, part = connected_components(csr_array((np.ones(len(moves[0])), moves), shape=(n, n)), directed=False)
    starts_of = np.bincount(part[starts], minlength=n)
    return int(starts_of[part[goals]].sum() - np.isin(goals, starts).sum())


def _library(result: ResultFile, tasks: int) -> Iterator[str]:
    library = result.library or []
    if any(skill.learned_after >= tasks for skill in library):
        yield "its library holds a skill of a task that is not there"
    for skill in library:
        if not leads_to_subgoal(skill, result.world.successors):
            yield f"skill of state {skill.subgoal}: its policy does not lead to the subgoal"


def leads_to_subgoal(skill: Skill, successors: np.ndarray) -> bool:
    """Return whether a policy reaches its subgoal from every state where it is defined."""
    states = np.arange(len(successors))
    defined = skill.policy >= 0
    after = np.where(defined, successors[states, np.maximum(skill.policy, 0)], states)
    after[skill.subgoal] = skill.subgoal
    for _ in range(len(successors).bit_length()):  # 1, 2, 4, ... steps
        after = after[after]
    return bool((after[defined] == skill.subgoal).all())


# -- arrays of many lives -----------------------------------------------------------------------------------------


Letters = Annotated[str, key("", **TASKS)]
Number = Annotated[int, msgspec.Meta(ge=0)]


class _Tasks(msgspec.Struct):
    tasks: Letters


class _RandomTasks(msgspec.Struct):
    tasks: Number
    runs: Number


class _SettingJob(msgspec.Struct):
    """What a setting's job must say, see `ptl.study.robustness.design.job_of`."""

    setting: str
    environments: dict[str, _Tasks]
    methods: list[str]
    seeds: int
    parameters: dict[str, Any]
    growth: _RandomTasks


def _setting(root: Node) -> Iterator[str]:
    try:
        job = msgspec.convert(root.attrs["job"], _SettingJob)
        learning = learning_parameters(job.parameters).learning
        worlds = {name: GridWorld.from_text(text, f"map {name!r}") for name, text in root.attrs["maps"].items()}
    except (msgspec.ValidationError, UserError) as error:
        yield f"its job or a map cannot be right ({error})"
        return
    complete = root.attrs["status"] == COMPLETE
    if root.attrs["setting"] != job.setting:
        yield "its job is that of another setting"
    if worlds.keys() != job.environments.keys() and (worlds or complete):
        yield "its maps are not those of its job's environments"
        return
    named = [(environment, method) for environment in worlds for method in job.methods]
    held = [(environment, method) for environment, group in root.items() for method in group if environment != "growth"]
    for environment, method in held:
        place = f"{environment}/{method}"
        if (environment, method) not in named:
            yield f"holds {place}, which its job does not name"
            continue
        lives, letters = root[environment][method], job.environments[environment].tasks
        yield from _lives_of(place, lives, worlds[environment], letters, learning, job.seeds)
        if complete and len(lives["seeds"]) < job.seeds:
            yield f"{place}: has not all seeds though its status is {COMPLETE}"
    if "growth" in root:
        yield from _random_lives(root["growth"]["library_size"], job.growth)
    if complete and (len(held) < len(named) or ("growth" in root) != (job.growth.runs > 0)):
        yield f"lacks some of its job's lives though its status is {COMPLETE}"


def _lives_of(place: str, lives: Node, world: GridWorld, letters: str, learning: Learning, seeds: int) -> Iterator[str]:
    """Hold the arrays of `ptl.study.lives.learn_lives` against the map and what they were learned from."""
    steps, truncated = lives["steps"], lives["truncated"]
    if steps.shape[1:] != (len(letters), learning.episodes) or not set(letters) <= world.goals.keys():
        yield f"{place} does not have the tasks {letters} with {learning.episodes} episodes each"
        return
    number = len(lives["seeds"])
    if not steps.size:
        yield f"{place}: holds no lives"
        return
    if number > seeds or (lives["seeds"] != np.arange(number)).any():
        yield f"{place}: its seeds are not 0, 1, ... up to {seeds - 1} at most"
    goals = [world.goals[letter] for letter in letters]
    shortest, limit = world.distances_to(world.start)[goals][:, None], learning.max_steps
    at_limit = steps == limit
    if (steps > limit).any():
        yield f"{place}: an episode is longer than learning.max_steps ({limit})"
    if ((steps < shortest) & ~at_limit).any():
        yield f"{place}: an episode is shorter than the shortest path"
    if (truncated > at_limit.sum(axis=2)).any() or (truncated < (at_limit & (steps < shortest)).sum(axis=2)).any():
        yield f"{place}: its truncated episodes are not those that hit learning.max_steps ({limit})"
    for name in ("subgoal", "incremental_peak", "original_peak"):
        if name in lives and lives[name].max() >= world.n_states:
            yield f"{place}/{name} holds a state that is not there"
    if "novelty" in lives and lives["novelty"].max() > world.n_states - 1:
        yield f"{place}: its novelty is longer than any path without loops"


def _random_lives(sizes: np.ndarray, growth: _RandomTasks) -> Iterator[str]:
    if sizes.shape != (growth.runs, growth.tasks + 1):
        yield f"growth: does not have {growth.runs} lives of {growth.tasks} tasks"
    elif not _grows(sizes):
        yield "growth: a library does not grow from 0 by at most one skill a task"


class _Unit(msgspec.Struct):
    """What a unit of the fit must say, see `ptl.study.fit.Searcher`."""

    map: str
    tasks: Letters
    seeds: int
    parameters: dict[str, Any]


def _fit(root: Node) -> Iterator[str]:
    unit = root.attrs["unit"]
    try:
        if "growth" in root:
            yield from _random_lives(root["growth"]["library_size"], msgspec.convert(unit, _RandomTasks))
        if "lives" in root:
            given = msgspec.convert(unit, _Unit)
            world = GridWorld.from_text(given.map)
            values = {name.replace(".", "__"): value for name, value in given.parameters.items()}
            learning = Parameters().replace(**values).learning
            yield from _lives_of("lives", root["lives"], world, given.tasks, learning, given.seeds)
    except (msgspec.ValidationError, UserError) as error:
        yield f"its unit cannot be right ({error})"
    if ("growth" in root) == ("lives" in root):
        yield "it must hold either lives or growth"


class _Cell(msgspec.Struct):
    """What the cell of a job must say, see `ptl.study.population.running.Cell`."""

    family: str
    size: int
    sequence: str
    maps: list[int | str]
    seeds: int
    method: str
    per_task: int
    tasks: Letters


def _lives(root: Node) -> Iterator[str]:
    job = root.attrs["job"]
    try:
        cell = msgspec.convert(job["cell"], _Cell)
        learning = learning_parameters(job["parameters"]).learning
    except (msgspec.ValidationError, UserError) as error:
        yield f"its job cannot be right ({error})"
        return
    tasks = len(cell.tasks or GOALS) if cell.tasks or cell.size else root["steps"].shape[2]
    if root["steps"].shape != (len(cell.maps), cell.seeds, tasks) or not root["steps"].size:
        yield f"does not hold the lives of its job: {len(cell.maps)} maps, {cell.seeds} lives, {tasks} tasks"
        return
    steps, first, truncated = root["steps"], root["first"], root["truncated"]
    episodes, limit = learning.episodes, learning.max_steps
    shortest = root["shortest"][:, None]
    least = np.minimum(shortest, limit)
    if (root["shortest"] >= root["states"][:, None]).any():
        yield "a shortest path is longer than any path without loops"
        return
    if (truncated > episodes).any() or ((shortest > limit) & (truncated < episodes)).any():
        yield "a task has a number of truncated episodes that cannot be"
        return
    if (steps < truncated * limit + (episodes - truncated) * least).any():
        yield "a task took fewer steps than its shortest path in every episode that was not truncated"
    if (steps > episodes * limit).any():
        yield f"a task took more steps than learning.max_steps ({limit}) in every episode"
    if (first < least).any() or (first > limit).any() or (first > steps - (episodes - 1) * least).any():
        yield "a first episode is shorter than the shortest path, or longer than the others leave room for"
    if ((first < shortest) & (truncated == 0)).any():
        yield "a first episode is shorter than the shortest path though no episode was truncated"


def _gain(root: Node) -> Iterator[str]:
    yield from _distinct(root["seeds"])
    if not root["gain"].size:
        yield "it holds no trials"


def _steps(root: Node) -> Iterator[str]:
    yield from _distinct(root.attrs["seeds"])
    for environment, by_method in root.items():
        for method, by_task in by_method.items():
            for task, steps in by_task.items():
                if (steps < 1).any():
                    yield f"{environment}/{method}/{task}: an episode has no steps"


def _distinct(seeds: np.ndarray) -> Iterator[str]:
    if not len(seeds) or len(np.unique(seeds)) < len(seeds):
        yield "it holds no seeds, or one twice"


CHECKS: Mapping[str, Callable[[Any], Iterator[str]]] = {
    LEARNING: _learning,
    GROWTH: _growth,
    FREQUENCIES: _frequencies,
    STEPS: _steps,
    GAIN: _gain,
    SETTING: _setting,
    FIT: _fit,
    LIVES: _lives,
}
"""Invariants of each kind of file."""
