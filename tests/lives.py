"""Small lives for tests: learned in a fraction of a second, and written as result files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from projects import ROOMS as ROOMS_MAP

from ptl.config import Parameters
from ptl.files.outside import learning_code
from ptl.files.provenance import code_digest
from ptl.files.results import write_learning
from ptl.learning.life import Life, learn_life, tasks_of
from ptl.world.gridworld import GridWorld

ROOT_SEED = 1
ROOMS = GridWorld.from_text(ROOMS_MAP, "rooms")
QUICK = Parameters().replace(learning__episodes=20, subgoals__trajectories=5)


def live(
    method: str, seed: int = 0, *, world: GridWorld = ROOMS, tasks: str = "", parameters: Parameters = QUICK
) -> Life:
    """Learn the tasks, all goals of the world by default."""
    letters = tasks_of(world, tasks or "".join(world.goals))
    return learn_life(world, letters, method, parameters, ROOT_SEED, world.name, seed)


def origin(
    method: str, seed: int, *, world: GridWorld = ROOMS, parameters: Parameters = QUICK, module: str = "life"
) -> dict[str, Any]:
    """Origin of a life, with the digest of the present code."""
    return {
        "environment": world.name,
        "method": method,
        "seed": seed,
        "root_seed": ROOT_SEED,
        "parameters": parameters.to_dict(),
        "code": learning_code(method)
        if module == "life"
        else code_digest(f"ptl.learning.{module}", f"ptl.methods.{method}"),
    }


def write_life(
    folder: Path,
    method: str,
    seed: int = 0,
    *,
    world: GridWorld = ROOMS,
    tasks: str = "",
    parameters: Parameters = QUICK,
) -> Path:
    """Learn and write one life; return the path, named as in a run."""
    path = folder / world.name / method / f"seed_{seed:03d}.h5"
    life = live(method, seed, world=world, tasks=tasks, parameters=parameters)
    write_learning(path, life, world, origin(method, seed, world=world, parameters=parameters))
    return path
