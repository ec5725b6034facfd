"""Small learning files for the tests of the explorer: two maps, five methods, two seeds."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import NamedTuple

from lives import job, write_life
from mazes import chain_of_rooms

from ptl.agent.skills import Skill
from ptl.config import Parameters
from ptl.files import store
from ptl.jobs.learn import Learn, TaskView, skills_of, tasks_in
from ptl.world.gridworld import GridWorld

METHODS = ("no_transfer", "full_transfer", "policy_reuse", "ptl", "ptl_supervised")
SEEDS = (3, 8)
PARAMETERS = Parameters().replace(learning__episodes=40, subgoals__trajectories=10)
MAPS = {
    "chain": chain_of_rooms(5, size=5, goals="ABC"),
    "flat": "########\n#I.#..A#\n#..#...#\n#......#\n#..#####\n#.....B#\n########\n",
}
WORLDS = {name: GridWorld.from_text(text, name) for name, text in MAPS.items()}
TASKS = {"chain": "CAB", "flat": "AB"}
TITLES = {"chain": "Chain of rooms", "flat": "Flat </script><b>&amp;"}

chain_job = partial(job, world=WORLDS["chain"], tasks=TASKS["chain"], parameters=PARAMETERS)
"""The job of a method and a seed on the chain of rooms."""


def write_runs(folder: Path) -> list[Path]:
    """Learn and write everything; the paths in the order environments, methods, seeds."""
    return [
        write_life(folder, method, seed, world=world, tasks=TASKS[name], parameters=PARAMETERS)
        for name, world in WORLDS.items()
        for method in METHODS
        for seed in SEEDS
    ]


class Stored(NamedTuple):
    """Contents of a learning file."""

    job: Learn
    world: GridWorld
    tasks: dict[str, TaskView]
    library: list[Skill] | None


def opened(path: Path) -> Stored:
    """Read a learning file."""
    result = store.read(path)
    return Stored(result.job, result.world, tasks_in(result), skills_of(result.arrays))
