"""Small learning files for the tests of the explorer: two maps, five methods, two seeds."""

from __future__ import annotations

from pathlib import Path

from mazes import chain_of_rooms

from ptl.config import Parameters
from ptl.files.results import write_learning
from ptl.learning.life import Life, learn_life, tasks_of
from ptl.world.gridworld import GridWorld

METHODS = ("no_transfer", "full_transfer", "policy_reuse", "ptl", "ptl_supervised")
SEEDS = (3, 8)
PARAMETERS = Parameters().replace(learning__episodes=40, subgoals__trajectories=10)
MAPS = {
    "chain": chain_of_rooms(5, size=5, goals="ABC"),
    "flat": "########\n#I.#..A#\n#..#...#\n#......#\n#..#####\n#.....B#\n########\n",
}
TASKS = {"chain": "CAB", "flat": "AB"}
TITLES = {"chain": "Chain of rooms", "flat": "Flat </script><b>&amp;"}


def origin(environment: str, method: str, seed: int, parameters: Parameters = PARAMETERS) -> dict:
    return {
        "environment": environment,
        "method": method,
        "seed": seed,
        "root_seed": 5,
        "parameters": parameters.to_dict(),
        "code": "0" * 16,
    }


def learn(environment: str, method: str, seed: int, parameters: Parameters = PARAMETERS) -> tuple[Life, GridWorld]:
    world = GridWorld.from_text(MAPS[environment], environment)
    tasks = tasks_of(world, TASKS[environment])
    return learn_life(world, tasks, method, parameters, 5, environment, seed), world


def write_runs(folder: Path) -> list[Path]:
    """Learn and write everything; the paths in the order environments, methods, seeds."""
    paths = []
    for environment in MAPS:
        for method in METHODS:
            for seed in SEEDS:
                path = folder / environment / method / f"seed_{seed:03d}.h5"
                life, world = learn(environment, method, seed)
                write_learning(path, life, world, origin(environment, method, seed))
                paths.append(path)
    return paths
