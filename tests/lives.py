"""Small lives for tests: learned in a fraction of a second, and written as result files."""

from __future__ import annotations

from pathlib import Path

from projects import ROOMS as ROOMS_MAP

from ptl.config import Parameters
from ptl.files import store
from ptl.files.outside import learning_code
from ptl.files.store import Result
from ptl.jobs.learn import Learn
from ptl.learning.life import Life, learn_life, tasks_of
from ptl.world.gridworld import GridWorld, map_digest

ROOT_SEED = 1
ROOMS = GridWorld.from_text(ROOMS_MAP, "rooms")
QUICK = Parameters().replace(learning__episodes=20, subgoals__trajectories=5)


def live(
    method: str, seed: int = 0, *, world: GridWorld = ROOMS, tasks: str = "", parameters: Parameters = QUICK
) -> Life:
    """Learn the tasks, all goals of the world by default."""
    letters = tasks_of(world, tasks or "".join(world.goals))
    return learn_life(world, letters, method, parameters, ROOT_SEED, world.name, seed)


def job(
    method: str, seed: int = 0, *, world: GridWorld = ROOMS, tasks: str = "", parameters: Parameters = QUICK
) -> Learn:
    """The job of such a life, with the digest of the present code."""
    return Learn(
        root_seed=ROOT_SEED,
        parameters=parameters.to_dict(),
        maps={world.name: map_digest(world.text)},
        code=learning_code(method),
        environment=world.name,
        tasks=tasks or "".join(world.goals),
        method=method,
        reference=method,
        seed=seed,
    )


def write_life(
    folder: Path,
    method: str,
    seed: int = 0,
    *,
    world: GridWorld = ROOMS,
    tasks: str = "",
    parameters: Parameters = QUICK,
) -> Path:
    """Learn and write one life; return the path, at its place below a folder of results."""
    work = job(method, seed, world=world, tasks=tasks, parameters=parameters)
    path = folder / work.place
    worlds = {world.name: world}
    store.write(path, work, work.run(worlds), worlds)
    return path


def read_lives(*paths: Path) -> list[Result]:
    """Read such files."""
    return [store.read(path) for path in paths]
