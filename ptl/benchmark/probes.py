"""Measurements of one size each, made in a process of their own so that peak memory is theirs alone.

``python -m ptl.benchmark.probes KIND ARGUMENT...`` prints a JSON list of records with the keys ``quantity`` and
``value`` (for ``tasks`` also ``size``).
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from ptl.agent._kernel import Dynamics, Learner
from ptl.agent._selection import SkillSelection
from ptl.agent.selection import prior
from ptl.agent.skills import Skill, SkillLibrary
from ptl.agent.subgoals import discover
from ptl.benchmark import surveys
from ptl.benchmark.memory import peak_mebibytes
from ptl.config import Parameters
from ptl.learning import life as learning
from ptl.learning.growth import grow_library
from ptl.learning.life import learn_life, tasks_of
from ptl.world import mazes
from ptl.world._graph import searches
from ptl.world.gridworld import GridWorld, load_map
from ptl.world.transitions import TransitionGraph

STEPS = 10**7
"""Steps over which the time of one is measured."""

STEPS_FROM_A_START = 10**4
"""Steps before the walk goes on elsewhere, unless the goal comes first."""

FIRST_EPISODES = 3
"""First episodes over which their length is averaged."""

TASKS_OF_A_LIFE = 10
"""Tasks of a life on larger and larger maps."""

Record = dict[str, Any]


def world_of(kind: str, states: int) -> GridWorld:
    """A world of about so many states.

    Parameters
    ----------
    kind : {"chain", "rooms", "maze", "ring"}
        A row of 10 x 10 rooms (as environment 1); a square cut at random into small rooms; a perfect maze; or one
        corridor that closes on itself, the worst case of the diameter.
    """
    if kind == "chain":
        return GridWorld.from_text(mazes.chain_of_rooms(max(2, round(states / 101)), 10, "A"), "chain")
    if kind == "rooms":
        side = round((states / 0.64) ** 0.5) + 2
        return GridWorld.from_text(mazes.random_rooms(np.random.default_rng(states), side, side, "A"), "rooms")
    if kind == "maze":
        random = np.random.default_rng(states)
        return GridWorld.from_text(mazes.to_text(mazes.with_letters(random, mazes.maze(random, states), "A")), "maze")
    if kind == "ring":
        side = round(states / 4) + 1
        grid = np.full((side, side), mazes.FREE)
        grid[1:-1, 1:-1] = mazes.WALL
        grid[0, 0], grid[-1, -1] = mazes.START, "A"
        return GridWorld.from_text(mazes.to_text(grid), "ring")
    raise ValueError(f"unknown kind of world: {kind}")


def states(kind: str, size: int) -> list[Record]:
    """What a map of about ``size`` states costs, from its text to a library update."""
    text = world_of(kind, size).text
    held = peak_mebibytes()
    world, reading = _timed(lambda: GridWorld.from_text(text), 3)
    goal = world.goals["A"]
    learner, tables = _timed(lambda: Learner(Dynamics(world.successors), goal, np.random.SFC64(0)), 3)
    records = [
        {"quantity": "states", "value": world.n_states},
        {"quantity": "read the map, s", "value": reading},
        {"quantity": "lay out the tables, s", "value": tables},
    ]
    for name, shortcut in (("every step simulated", False), ("with the shortcut", True)):
        records.append({"quantity": f"one step, {name}, s", "value": _seconds_a_step(world, shortcut)})
    records += [
        {"quantity": "first episode, steps", "value": _first_episode(world)},
        *_discovery(world, learner),
        {"quantity": "memory, MiB", "value": peak_mebibytes() - held},
    ]
    return records


def _timed(work: Callable[[], Any], repeats: int) -> tuple[Any, float]:
    """What the work gives, and the least CPU seconds of several repeats."""
    least = np.inf
    for _ in range(repeats):
        begin = time.process_time()
        result = work()
        least = min(least, time.process_time() - begin)
    return result, least


def _seconds_a_step(world: GridWorld, shortcut: bool) -> float:
    """Seconds of a step from starts all over the map, so that all tables are in use.

    Q stays zero (alpha is 0): the same law at every size, and for as long as one likes.
    """
    learner = Learner(
        Dynamics(world.successors),
        world.goals["A"],
        np.random.SFC64(1),
        alpha=0.0,
        shortcut=shortcut,
        max_steps=10**12,
    )
    starts = np.random.default_rng(0).integers(0, world.n_states, STEPS // STEPS_FROM_A_START).tolist()

    def walk() -> int:
        taken = 0
        for start in starts:
            learner.begin_episode(start)
            learner.explore(budget=STEPS_FROM_A_START)
            taken += learner.steps
        return taken

    walk()
    taken, seconds = _timed(walk, 3)
    return seconds / taken


def _first_episode(world: GridWorld) -> float:
    """Mean steps of a first episode: a property of the world, not of the code."""
    dynamics, steps = Dynamics(world.successors), []
    for seed in range(FIRST_EPISODES):
        learner = Learner(dynamics, world.goals["A"], np.random.SFC64(100 + seed), max_steps=10**12)
        learner.begin_episode(world.start)
        learner.explore()
        steps.append(learner.steps)
    return float(np.mean(steps))


def _discovery(world: GridWorld, learner: Learner) -> list[Record]:
    """Subgoal discovery and library update after a task in which everything was seen, on 30 shortest paths."""
    everything = np.full(world.n_states, 15, dtype=np.uint8)
    policy = world.transitions.shortest_path_policy(world.goals["A"])
    learner.begin_episode(world.start)
    learner.follow(policy, world.goals["A"])
    paths = [learner.erased_path()] * Parameters().subgoals.trajectories

    def after_a_task() -> None:
        graph = TransitionGraph(world.successors, everything)
        library = SkillLibrary(novelty=0.0)
        library.update(discover(paths, graph, [], 2), graph, 0)

    return [
        {"quantity": "discovery and library update, s", "value": _timed(after_a_task, 3)[1]},
        {"quantity": "searches of the graph, count", "value": searches_of(after_a_task)},
    ]


def searches_of(work: Callable[[], Any]) -> int:
    """Number of breadth-first searches that the work makes."""
    before = searches()
    work()
    return searches() - before


def diameter(kind: str, size: int) -> list[Record]:
    """The diameter of a world: CPU seconds and searches of the graph."""
    world = world_of(kind, size)
    graph = TransitionGraph(world.successors)
    return [
        {"quantity": "states", "value": world.n_states},
        {"quantity": "diameter, s", "value": _timed(graph.diameter, 1)[1]},
        {"quantity": "searches of the graph, count", "value": searches_of(graph.diameter)},
    ]


def library(size: int, states: int) -> list[Record]:
    """One selection, one update of the likelihood and one library update with ``size`` skills on a rooms map."""
    held = peak_mebibytes()
    world = world_of("rooms", states)
    random = np.random.default_rng(0)
    subgoals = random.choice(world.n_states, size=size, replace=False).tolist()
    goal = world.goals["A"]
    policy = np.zeros(world.n_states, dtype=np.int8)
    skills = [Skill(subgoal, policy.copy(), 0) for subgoal in subgoals]
    chosen = SkillSelection(prior(world.cells, [world.start, *subgoals], goal, world.diagonal))

    def begin_task() -> None:
        SkillSelection(prior(world.cells, [world.start, *subgoals], goal, world.diagonal))

    def draw() -> None:
        chosen.draw(random)

    def record() -> None:
        chosen.record([0], 100)

    graph = TransitionGraph(world.successors)
    route, state = [world.start], world.start
    to_goal = graph.shortest_path_policy(goal)
    while state != goal:
        state = int(world.successors[state, to_goal[state]])
        route.append(state)
    paths = [np.array(route)] * Parameters().subgoals.trajectories

    def update() -> None:
        grown = SkillLibrary(novelty=0.0, threshold=0.0, skills=list(skills))
        grown.update(discover(paths, graph, grown.subgoals, 2), graph, 0)

    return [
        {"quantity": "prior of a task, s", "value": _mean_seconds(begin_task, 100)},
        {"quantity": "one selection, s", "value": _mean_seconds(draw, 300)},
        {"quantity": "likelihood after an episode, s", "value": _mean_seconds(record, 300)},
        {"quantity": "discovery and library update, s", "value": _mean_seconds(update, 3)},
        {"quantity": "policies, bytes", "value": sum(skill.policy.nbytes for skill in skills)},
        {"quantity": "memory, MiB", "value": peak_mebibytes() - held},
    ]


def _mean_seconds(work: Callable[[], None], times: int) -> float:
    """CPU seconds of one call: the least of several means."""

    def again() -> None:
        for _ in range(times):
            work()

    again()
    return _timed(again, 7)[1] / times


def tasks(map_path: str, number: int) -> list[Record]:
    """One life of so many random tasks under PTL: time of a task, memory and library as the life goes on."""
    world = load_map(map_path)
    held = peak_mebibytes()
    marks = sorted({m for e in range(7) for m in (10**e, 2 * 10**e, 5 * 10**e) if m < number} | {number})
    records: list[Record] = []
    done, since, begin = 0, 0, time.process_time()
    learn_task = learning.learn_task

    def watched(*arguments: Any) -> learning.TaskRecord:
        nonlocal done, since, begin
        record = learn_task(*arguments)
        done += 1
        if done in marks:
            seconds = (time.process_time() - begin) / (done - since)
            skills = len(arguments[3].library)
            for quantity, value in (
                ("one task, s", seconds),
                ("memory, MiB", peak_mebibytes() - held),
                ("skills in the library, count", skills),
            ):
                records.append({"size": done, "quantity": quantity, "value": value})
            since, begin = done, time.process_time()
        return record

    learning.learn_task = watched  # type: ignore[assignment]
    try:
        grow_library(world, number, Parameters(), 0, "benchmark", 0)
    finally:
        learning.learn_task = learn_task
    return records


def large(side: int) -> list[Record]:
    """Two tasks under PTL on a square of small rooms with ``side`` cells each way, learned to their end."""
    world = GridWorld.from_text(mazes.random_rooms(np.random.default_rng(side), side, side, "AB"), "large")
    held = peak_mebibytes()
    begin = time.process_time()
    life = learn_life(world, tasks_of(world, "AB"), "ptl", Parameters(), 0, "benchmark", 0)
    seconds = time.process_time() - begin
    return [
        {"quantity": "states", "value": world.n_states},
        {"quantity": "two tasks, s", "value": seconds},
        {"quantity": "steps, count", "value": int(sum(record.steps.sum() for record in life.records))},
        {"quantity": "episodes, count", "value": sum(len(record.steps) for record in life.records)},
        {
            "quantity": "episodes at the step limit, count",
            "value": int(sum(record.truncated.sum() for record in life.records)),
        },
        {"quantity": "skills in the library, count", "value": len(life.library or [])},
        {"quantity": "memory, MiB", "value": peak_mebibytes() - held},
    ]


def survey_batch(
    map_path: str, method: str, batch: int, batches: int, trajectories: int, parameters: str
) -> list[Record]:
    """A batch of the survey of a map's subgoals by one of `surveys.METHODS`."""
    world, learning = load_map(map_path), Parameters.from_json(parameters).learning
    taken = surveys.costs(world, method, surveys.batch_of(world, batch, batches), trajectories, learning).sum(axis=0)
    return [
        {"quantity": quantity, "value": value}
        for quantity, value in zip(("core seconds", "steps", "pairs"), taken.tolist(), strict=True)
    ]


def survey(kind: str, size: int, method: str, number: int) -> list[Record]:
    """The survey of subgoals on a map of about ``size`` states, scaled up from ``number`` starts or goals."""
    world, parameters = world_of(kind, size), Parameters()
    held = peak_mebibytes()
    sample = surveys.sample_of(world, method, min(number, world.n_states), np.random.default_rng(0))
    taken = surveys.costs(world, method, sample, parameters.subgoals.trajectories, parameters.learning)
    seconds, steps, pairs = taken.sum(axis=0)
    scale = world.n_states * (world.n_states - 1) / pairs
    means = taken[:, 0] / taken[:, 2]
    return [
        {"quantity": "states", "value": world.n_states},
        {"quantity": f"{method}, s", "value": scale * seconds},
        {
            "quantity": f"{method}, relative standard error",
            "value": means.std(ddof=1) / means.mean() / len(means) ** 0.5,
        },
        {"quantity": f"{method}, steps", "value": scale * steps},
        {"quantity": f"{method}, pairs timed, count", "value": int(pairs)},
        {"quantity": f"{method}, memory, MiB", "value": peak_mebibytes() - held},
    ]


def life(kind: str, size: int, lives: int) -> list[Record]:
    """Lives of ten random tasks under PTL on a map of about ``size`` states, every episode to its goal: their mean."""
    world = world_of(kind, size)
    held = peak_mebibytes()
    parameters = Parameters().replace(learning__max_steps=surveys.NO_LIMIT)
    begin, steps = time.process_time(), 0
    for number in range(lives):
        grown = grow_library(world, TASKS_OF_A_LIFE, parameters, 0, "benchmark", number)
        steps += int(sum(record.steps.sum() for record in grown.records))
    return [
        {"quantity": "states", "value": world.n_states},
        {"quantity": "life of ten tasks, s", "value": (time.process_time() - begin) / lives},
        {"quantity": "life of ten tasks, steps", "value": steps / lives},
        {"quantity": "life of ten tasks, memory, MiB", "value": peak_mebibytes() - held},
    ]


MEASUREMENTS: dict[str, Callable[..., list[Record]]] = {
    "states": states,
    "diameter": diameter,
    "library": library,
    "tasks": tasks,
    "large": large,
    "survey_batch": survey_batch,
    "survey": survey,
    "life": life,
}


def records_of(arguments: list[str]) -> list[Record]:
    """Make the measurement that the first argument names, with the others, whole numbers where they look so."""
    kind, *rest = arguments
    return MEASUREMENTS[kind](*(int(text) if text.isdecimal() else text for text in rest))


if __name__ == "__main__":
    print(json.dumps(records_of(sys.argv[1:])))
