"""Generated maps by family, size, seed and sequence of tasks. Our choice throughout."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ptl.errors import UserError
from ptl.world.gridworld import GridWorld, map_digest
from ptl.world.mazes import FREE, GOALS, START, WALL, draw, largest_part, stream, to_text

MAIN = "increasing"
"""Sequence of tasks of the main comparison, as in the article."""

RETURNING = "returning"
"""Sequence of the main comparison, or of a given map, after which the first task comes again."""


# -- sequences of tasks --------------------------------------------------------------------------------------


def _drawn(world: GridWorld, rng: np.random.Generator, number: int) -> list[int]:
    others = np.delete(np.arange(world.n_states), world.start)
    return rng.choice(others, number, replace=False).tolist()


def _increasing(world: GridWorld, rng: np.random.Generator, number: int) -> list[int]:
    distance = world.distances_to(world.start)
    return sorted(_drawn(world, rng, number), key=lambda state: (distance[state], state))


def _reversed(world: GridWorld, rng: np.random.Generator, number: int) -> list[int]:
    return _increasing(world, rng, number)[::-1]


def _clustered(world: GridWorld, rng: np.random.Generator, number: int) -> list[int]:
    centre = _drawn(world, rng, 1)[0]
    nearest = np.argsort(world.distances_to(centre), kind="stable")
    near = nearest[nearest != world.start][: max(2 * number, world.n_states // 15)]
    return rng.choice(near, number, replace=False).tolist()


def _adversarial(world: GridWorld, rng: np.random.Generator, number: int) -> list[int]:
    places = [world.start, *_drawn(world, rng, 1)]
    while len(places) <= number:
        # from its nearest place, as the crow flies or as the agent walks, the next goal is farther than it looks
        least = np.min([_detour(world, place) for place in places], axis=0)
        places.append(int(least.argmax()))
    return places[1:]


def _detour(world: GridWorld, place: int) -> np.ndarray:
    """Return shortest path / straight line from a place to every state, 0 at the place."""
    offset = world.cells - world.cells[place]
    straight = np.sqrt((offset * offset).sum(axis=1))
    return np.divide(world.distances_to(place), straight, out=np.zeros(world.n_states), where=straight > 0)


SEQUENCES: dict[str, Callable[[GridWorld, np.random.Generator, int], list[int]]] = {
    "increasing": _increasing,
    "random": _drawn,
    "clustered": _clustered,
    "reversed": _reversed,
    "adversarial": _adversarial,
    RETURNING: _increasing,
}
"""Orders in which goals come: by shortest path from the start (as in the article), as drawn, all in one corner, by
decreasing path, each the state with the greatest detour from the start and all earlier goals, and as in the article
with the first task once more at the end."""


# -- maps ----------------------------------------------------------------------------------------------------


def make_map(family: str, size: int, seed: int, sequence: str = MAIN) -> GridWorld:
    """Return a map of a family; the walls and the start are the same for all sequences of a seed."""
    return place_tasks(draw(family, size, seed), f"{family}_{size}_{seed}", seed, sequence)


def place_tasks(grid: np.ndarray, name: str, seed: int, sequence: str = MAIN) -> GridWorld:
    """Put a start and six goals on a grid, whose free cells outside its largest part become walls.

    Increasing, random and reversed sequences of a seed have the same goals.
    """
    part = largest_part(grid)
    bounded = np.full(grid.shape, WALL)
    bounded[tuple(np.transpose(part))] = FREE
    if len(part) <= 2 * len(GOALS):
        raise UserError(f"{name}: has {len(part)} connected cells; a map with six tasks needs {2 * len(GOALS) + 1}")
    start, other = stream(name, seed, "start").choice(len(part), 2, replace=False)
    bounded[part[start]], bounded[part[other]] = START, GOALS[0]
    world = GridWorld.from_text(to_text(bounded), name)
    kind = sequence if sequence in ("clustered", "adversarial") else "goals"
    goals = SEQUENCES[sequence](world, stream(name, seed, kind), len(GOALS))
    bounded[part[other]] = FREE
    for letter, goal in zip(GOALS, goals, strict=True):
        bounded[tuple(world.cells[goal])] = letter
    return GridWorld.from_text(to_text(bounded), name)


def checked_map(family: str, size: int, seed: int, digest: str, sequence: str = MAIN) -> GridWorld:
    """Return a map of a family; ``digest`` is that of the map with increasing tasks.

    Raises
    ------
    UserError
        If the map has another digest.
    """
    made = make_map(family, size, seed)
    if (actual := map_digest(made.text)) != digest:
        raise UserError(
            f"map {made.name}: has the digest {actual}, not {digest} as planned; use the version of numpy in"
            " requirements.lock"
        )
    return made if sequence == MAIN else make_map(family, size, seed, sequence)


def winding(world: GridWorld) -> float:
    """Return the mean over a map's goals of shortest path / straight line from the start."""
    return float(_detour(world, world.start)[list(world.goals.values())].mean())
