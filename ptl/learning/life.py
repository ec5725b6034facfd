"""A life: tasks one after another under one method, with subgoal discovery after each."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np

from ptl import methods
from ptl.agent import seeding
from ptl.agent._episodes import run_episodes
from ptl.agent._kernel import Dynamics, Learner
from ptl.agent.skills import SkillLibrary, Update
from ptl.agent.subgoals import Discovery, discover
from ptl.config import Parameters
from ptl.errors import UserError
from ptl.keys import shortened
from ptl.methods._base import BaseMethod
from ptl.world.gridworld import GridWorld
from ptl.world.transitions import TransitionGraph

MAX_DRAWN = 2**31 - 1
"""Maximum number of a skill in a result file."""


@dataclass(frozen=True)
class Task:
    """A navigation task: reach ``goal`` from ``start`` (states).

    Attributes
    ----------
    world : GridWorld, optional
        Map on which it is learned, with the states of the life's map, of which methods are not told; the life's map if
        not given.
    """

    name: str
    start: int
    goal: int
    world: GridWorld | None = field(default=None, repr=False)


@dataclass(frozen=True)
class TaskRecord:
    """The record of one learned task.

    Attributes
    ----------
    task : Task
    q : float64 array, shape (n_states, 4)
        Final action values.
    seen : uint8 array, shape (n_states,)
        Bit a is set if action a was taken in the state.
    steps : int64 array, shape (episodes,)
        Steps of each episode, guided ones included.
    truncated : bool array, shape (episodes,)
        Whether the episode ran into the step limit.
    selected : list of lists of int
        Skills or arms drawn in each episode (0 is the null skill or the new policy).
    discovery : Discovery
    update : Update
        What the library did after the task; methods without a library add nothing.
    library_size : int
        Skills in the library after the task, 0 if the method keeps none.
    """

    task: Task
    q: np.ndarray = field(repr=False)
    seen: np.ndarray = field(repr=False)
    steps: np.ndarray = field(repr=False)
    truncated: np.ndarray = field(repr=False)
    selected: list[list[int]] = field(repr=False)
    discovery: Discovery
    update: Update
    library_size: int


@dataclass(frozen=True, repr=False)
class Life:
    """The records of all tasks in order, and the library at the end (None if the method keeps none)."""

    records: list[TaskRecord]
    library: SkillLibrary | None

    def __repr__(self) -> str:
        return f"<Life: tasks {', '.join(record.task.name for record in self.records)}; library {self.library!r}>"


def tasks_of(world: GridWorld, letters: str) -> list[Task]:
    """Return the tasks of a map: from its start to each goal letter in the order given."""
    return [Task(letter, world.start, world.goal(letter)) for letter in letters]


def learn_task(
    world: GridWorld,
    dynamics: Dynamics,
    task: Task,
    method: BaseMethod,
    parameters: Parameters,
    steps_stream: np.random.BitGenerator,
    task_index: int = 0,
) -> TaskRecord:
    """Learn one task under a method, then look for a subgoal and let the method keep what it wants.

    Parameters
    ----------
    steps_stream : numpy.random.BitGenerator
        Random numbers of the agent's steps.
    task_index : int
        Number of tasks learned before.

    Raises
    ------
    UserError
        If the task starts at its goal, or the method ends an episode before the goal and before the step limit, begins
        one, or returns anything but a list of draws or None.
    """
    if task.start == task.goal:
        raise UserError(f"task {task.name}: starts at its goal, state {task.goal}; give two states")
    learning, rates = parameters.learning, method.parameters.learning  # a method may have its own rates
    initial_q = method.begin_task(task.start, task.goal)
    learner = Learner(
        dynamics,
        task.goal,
        steps_stream,
        alpha=rates.alpha,
        gamma=rates.gamma,
        epsilon=rates.epsilon,
        max_steps=learning.max_steps,
        initial_q=initial_q,
        ties=rates.ties,
    )
    search = parameters.subgoals
    if getattr(method.run_episode, "__func__", None) is BaseMethod.run_episode:
        plan = method.plan()
        steps, truncated, selected, paths = run_episodes(
            learner, plan, task.start, learning.episodes, search.trajectories
        )
    else:
        steps, truncated, selected, paths = _run_own_episodes(
            learner, method, task, learning.episodes, search.trajectories
        )
    seen = learner.seen
    library = method.library
    graph = TransitionGraph(world.successors, seen)
    known = library.known_states(task.start, world.successors, search.known) if library is not None else []
    discovery = discover(paths, graph, known, search.cover_radius, search.distance_form)
    update = Update(-1, "the method keeps no library")
    if library is not None:
        update = library.update(discovery, graph, task_index)
    method.end_task(learner)
    size = 0 if library is None else len(library)
    return TaskRecord(task, learner.q.copy(), seen, steps, truncated, selected, discovery, update, size)


def _run_own_episodes(
    learner: Learner, method: BaseMethod, task: Task, episodes: int, trajectories: int
) -> tuple[np.ndarray, np.ndarray, list[list[int]], list[np.ndarray]]:
    """Let a method run its episodes itself; the results are those of `run_episodes`."""
    steps = np.empty(episodes, dtype=np.int64)
    truncated = np.empty(episodes, dtype=bool)
    selected = []
    paths: list[np.ndarray] = []
    for episode in range(episodes):
        learner.begin_episode(task.start)
        drawn = method.run_episode(learner)
        if learner.episodes != episode + 1:
            raise UserError(
                f"method {method.label!r}: run_episode began another episode in episode {episode + 1} of task"
                f" {task.name}; the life begins each one"
            )
        selected.append(_checked_draws(method, drawn, learner.steps))
        if not (learner.at_goal or learner.truncated):
            raise UserError(
                f"method {method.label!r}: run_episode returned in episode {episode + 1} of task {task.name} before the"
                " goal; an episode ends at the goal or at the step limit learning.max_steps"
            )
        steps[episode] = learner.steps
        truncated[episode] = learner.truncated
        if learner.at_goal and len(paths) < trajectories:
            paths.append(learner.erased_path())
    return steps, truncated, selected, paths


def _checked_draws(method: BaseMethod, drawn: Any, steps: int) -> list[int]:
    if drawn is None:  # a method without a return statement draws nothing
        return []
    if isinstance(drawn, list) and len(drawn) <= steps + 1 and all(map(_is_draw, drawn)):
        return drawn
    raise UserError(
        f"method {method.label!r}: run_episode must return the list of the skills drawn, numbers from 0"
        f" to {MAX_DRAWN} and at most one more than steps, or nothing, not {shortened(repr(drawn))}"
    )


def _is_draw(number: Any) -> bool:
    return isinstance(number, (int, np.integer)) and 0 <= int(number) <= MAX_DRAWN


def learn_life(
    world: GridWorld,
    tasks: Iterable[Task | str],
    method: str | methods.Maker = "ptl",
    parameters: Parameters | None = None,
    root_seed: int = 0,
    *stream_names: str | int,
) -> Life:
    """Learn tasks in order under one method.

    >>> world = GridWorld.from_text("I...A\\n....B\\n")
    >>> life = learn_life(world, "AB", parameters=Parameters(episodes=20))
    >>> [len(record.steps) for record in life.records]
    [20, 20]

    The random streams are named by the method, ``stream_names`` (say, environment and seed) and the task's place, so
    nothing depends on other jobs.

    Parameters
    ----------
    tasks : iterable of Task or str
        Tasks, or goal letters of the map such as "ABC", each learned from the map's start.
    method : str, type or function
        Reference, class or factory of the method, see `ptl.methods`.
    parameters : Parameters, optional
        By default those of the published run.
    """
    parameters = Parameters() if parameters is None else parameters
    names = (methods.identifier(method), *stream_names)
    make = methods.load(method) if isinstance(method, str) else method
    agent = make(world, parameters, seeding.generator(root_seed, *names, "choices"))
    records = []
    for index, given in enumerate(tasks):
        task = _task(world, given)
        there = world if task.world is None else task.world
        if there.n_states != world.n_states:
            raise UserError(f"task {task.name}: its map has {there.n_states} states, that of the life {world.n_states}")
        stream = seeding.bit_generator(root_seed, *names, "steps", index)
        records.append(learn_task(there, _dynamics(there), task, agent, parameters, stream, index))
    return Life(records, agent.library)


def _task(world: GridWorld, task: Task | str) -> Task:
    return Task(task, world.start, world.goal(task)) if isinstance(task, str) else task


@lru_cache(maxsize=8)  # the lives on one map follow each other
def _dynamics(world: GridWorld) -> Dynamics:
    return Dynamics(world.successors, world.slip)
