"""Growth of the library: one life of many tasks with random start and goal (the article's figure 14)."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

from ptl.agent import seeding
from ptl.config import Parameters
from ptl.learning.life import Life, Task, learn_life
from ptl.world.gridworld import GridWorld

METHOD = "ptl"
"""Identifier of the method whose library is watched (our choice of its variants)."""


def random_tasks(world: GridWorld, number: int, random: np.random.Generator) -> list[Task]:
    """Draw tasks with start and goal uniform over the states that the map's start reaches, never equal."""
    reachable = np.flatnonzero(world.distances_to(world.start) >= 0)
    pairs = (random.choice(reachable, size=2, replace=False).tolist() for _ in range(number))
    return [Task(str(index), start, goal) for index, (start, goal) in enumerate(pairs, start=1)]


def grow_library(
    world: GridWorld,
    number: int,
    parameters: Parameters,
    root_seed: int,
    environment: str,
    run: int,
    *,
    watch: Callable[[list[Task]], Iterable[Task]] = iter,
) -> Life:
    """Learn ``number`` random tasks with a fresh library; ``watch`` may wrap the tasks, say in a progress bar."""
    random = seeding.generator(root_seed, "growth", environment, run, "tasks")
    tasks = random_tasks(world, number, random)
    return learn_life(world, watch(tasks), METHOD, parameters, root_seed, "growth", environment, run)
