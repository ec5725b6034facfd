"""Policy reuse under readings of its authors' experiment, all runs at once in numpy.

The source's robot has a position in continuous space, of which it observes the cell, and its moves are noisy (FV 2006,
2013). The kernel of this package knows neither, so this is a second implementation of the same law, PRQ-learning as in
`ptl.methods.policy_reuse`; without noise and with random ties the two agree within sampling error (tests).

A lane is one run with one library. All lanes take the n-th step of the k-th trial together, and one generator serves
all lanes of a reading, so a result depends on their number.

Stated by the source: positions are continuous, the observation is the cell, a move has the length 1 and uniform noise
of up to 0.2, and a move that would hit an obstacle is not executed. Our choices, where it says no more:

* A cell is a unit square. Noise is drawn for both axes. A trial starts anywhere in its cell, at the centre if there is
  no noise.
* A move that is blocked leaves the position, which the agent does not observe, as it was. Whether a move meets a
  wall is decided at every tenth of the way, or at its end only: both are readings. The latter lets a robot near a wall
  jump over it, because a move may be longer than a cell.
* The goal is reached when a move ends in its cell; a move that only crosses the cell does not count.
* The policies of the library are optimal on the map without noise, with ties of optimal actions by the rule of
  the reading. Learning them by Q-learning in each reading would take ten times as long as all the rest. With noise they
  gain almost as much as policies that know it (a test).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import permutations
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from ptl.config import Parameters
from ptl.world.gridworld import ACTIONS, MOVES, GridWorld

NOISE = 0.2
"""Maximum of the noise on either axis, in cells (source)."""

MARGIN = 2
"""Cells of wall around the map; no move is longer."""


class Motion(NamedTuple):
    """How the robot moves: maximum of the noise, and the parts of its way at which a move may meet a wall."""

    label: str
    noise: float
    checks: tuple[float, ...]


MOTIONS: Mapping[str, Motion] = MappingProxyType(
    {
        "exact": Motion("no noise", 0.0, (1.0,)),
        "noisy": Motion("noise ±0.2, walls along the move", NOISE, tuple(tenth / 10 for tenth in range(1, 11))),
        "noisy_end": Motion("noise ±0.2, walls at its end only", NOISE, (1.0,)),
    }
)
"""Readings of the robot's motion by name."""

TIES: Mapping[str, str] = MappingProxyType(
    {
        "random": "a random one",
        "first_ensw": "the first of E, N, S, W",
        "first_any": "the first, over all 24 orders",
    }
)
"""Readings of which of equal greedy actions is taken, by name.

No source that we know states the rule. A program that takes the maximum of a list takes the first, and a list has an
order. East, north, south, west is the one of the 24 for which an earlier calculation of ours came near the published
values, so it is fitted to them; therefore all orders, in turn over the runs, show what another order would give.
"""

ORDERS: Mapping[str, tuple[tuple[int, ...], ...]] = MappingProxyType(
    {"random": (), "first_ensw": ((3, 0, 1, 2),), "first_any": tuple(permutations(range(len(ACTIONS))))}
)
"""Orders of the actions under each reading of ties, which the runs take in turn."""


@dataclass(frozen=True)
class Outcome:
    """What lanes gained.

    Attributes
    ----------
    gain : float array (trials, lanes)
        Discounted return of each trial.
    arm_gain : float array (lanes, arms)
        Mean return of the trials of each arm, 0 before the first; arm 0 is the new policy.
    arm_trials : int array (lanes, arms)
    """

    gain: np.ndarray
    arm_gain: np.ndarray
    arm_trials: np.ndarray


class Robots:
    """Robots with continuous positions, one a lane.

    Parameters
    ----------
    world : GridWorld
    motion : Motion
    random : numpy.random.Generator
    """

    def __init__(self, world: GridWorld, motion: Motion, random: np.random.Generator) -> None:
        self.world = world
        states = np.pad(world.to_grid(np.arange(world.n_states), fill=-1).astype(np.intp), MARGIN, constant_values=-1)
        self._width = states.shape[1]
        self._state = states.ravel()
        self._corner = world.cells + float(MARGIN)
        self._noise = motion.noise
        self._checks = np.array(motion.checks)[:, np.newaxis, np.newaxis]
        self._random = random
        self.place(np.empty(0, dtype=np.intp))

    def place(self, states: np.ndarray) -> None:
        """Put robots into cells, anywhere in them if moves are noisy, int array (n,)."""
        inside = self._random.random((len(states), 2)) if self._noise else 0.5
        self.states, self.positions = states, self._corner[states] + inside

    def keep(self, these: np.ndarray) -> None:
        """Take the others away, bool array (n,)."""
        self.states, self.positions = self.states[these], self.positions[these]

    def move(self, actions: np.ndarray) -> None:
        """Let every robot make its move unless a wall is in the way, int array (n,)."""
        moves = MOVES[actions]
        if self._noise:
            moves = moves + self._random.uniform(-self._noise, self._noise, moves.shape)
        points = self.positions + self._checks * moves
        cells = points.astype(np.intp)
        met = self._state[cells[..., 0] * self._width + cells[..., 1]]
        free = (met >= 0).all(axis=0)
        self.states = np.where(free, met[-1], self.states)
        self.positions = np.where(free[:, np.newaxis], points[-1], self.positions)


def tie_ranks(ties: str, runs: int) -> tuple[np.ndarray, np.ndarray]:
    """Return how runs rank equal actions, of which the highest is taken.

    Returns
    -------
    ranks : float array (runs, 4)
        Fixed rank of each action, at least 1 apart if it decides.
    spread : float array (runs, 1)
        Factor on a uniform number that is added to each rank: 1 if chance decides, 0 if not.
    """
    orders = ORDERS[ties]
    if not orders:
        return np.zeros((runs, len(ACTIONS))), np.ones((runs, 1))
    ranks = len(ACTIONS) - np.argsort(orders, axis=1)  # argsort gives the place of each action in an order
    return ranks[np.arange(runs) % len(orders)].astype(float), np.zeros((runs, 1))


def optimal_policies(
    world: GridWorld, goals: Sequence[int], ranks: np.ndarray, spread: np.ndarray, random: np.random.Generator
) -> np.ndarray:
    """Return shortest-path policies, int8 (runs, goals, n_states), -1 at the goal; each run breaks its own ties."""
    policies = np.empty((len(ranks), len(goals), world.n_states), dtype=np.int8)
    for index, goal in enumerate(goals):
        distance = world.distances_to(goal)
        nearer = distance[world.successors] < distance[:, np.newaxis]
        rank = ranks[:, np.newaxis] + spread[..., np.newaxis] * random.random((len(ranks), *nearer.shape))
        policies[:, index] = np.where(nearer, rank, -1).argmax(axis=2)
        policies[:, index, goal] = -1
    return policies


def learn(
    robots: Robots,
    goal: int,
    libraries: Sequence[np.ndarray],
    ranks: np.ndarray,
    spread: np.ndarray,
    parameters: Parameters,
    trials: int,
    random: np.random.Generator,
    watch: Callable[[Sequence[int]], Iterable[int]] = iter,
) -> Outcome:
    """Learn one task from random starts by PRQ-learning in every lane.

    Parameters
    ----------
    libraries : sequence of int8 arrays (past policies, n_states)
        Library of each lane, with action -1 where a policy says nothing (the new policy acts).
    ranks, spread : float arrays (lanes, 4) and (lanes, 1)
        See `tie_ranks`.
    watch : callable
        Wraps the numbers of the trials, say in a progress bar.
    """
    learning, reuse = parameters.learning, parameters.policy_reuse
    lanes, states = len(libraries), robots.world.n_states
    starts = start_states(robots.world, goal)
    arms = 1 + np.array([len(library) for library in libraries])
    exists = np.arange(arms.max()) < arms[:, np.newaxis]
    by_arm = np.full((*exists.shape, states), -1, dtype=np.int8)
    for own, library in zip(by_arm, libraries, strict=True):
        own[1 : len(library) + 1] = library
    policies = by_arm.reshape(-1)
    q = np.zeros((4, lanes * states))
    values, best = q.reshape(-1), np.zeros(lanes * states)
    gain = np.zeros((trials, lanes))
    arm_gain, arm_trials = np.zeros(exists.shape), np.zeros(exists.shape, dtype=np.int64)
    temperature = reuse.temperature

    for trial in watch(range(trials)):
        likely = np.exp(temperature * (arm_gain - arm_gain.max(axis=1, keepdims=True)))
        passed = np.where(exists, likely, 0).cumsum(axis=1)
        arm = (random.random((lanes, 1)) * passed[:, -1:] >= passed).sum(axis=1)
        lane, psi = np.arange(lanes), reuse.psi
        first, guide, reusing = lane * states, (lane * exists.shape[1] + arm) * states, arm > 0
        fixed, loose = ranks.T, spread.T
        robots.place(random.choice(starts, lanes))
        for step in range(learning.max_steps):
            row = first + robots.states
            follow, explore, which, *chance = random.random((7, len(lane)))
            known = q.take(row, axis=1)
            action = np.where(known == best[row], fixed + loose * chance, -1).argmax(axis=0)
            action = np.where(reusing & (explore < psi), (4 * which).astype(np.intp), action)
            past = policies[guide + robots.states]
            action = np.where((follow < psi) & (past >= 0), past, action)
            robots.move(action)
            arrived = robots.states == goal
            changed = action * q.shape[1] + row
            target = arrived + learning.gamma * best[first + robots.states]
            values[changed] += learning.alpha * (target - values[changed])
            best[row] = q.take(row, axis=1).max(axis=0)
            psi *= reuse.psi_decay
            if arrived.any():
                gain[trial, lane[arrived]] = learning.gamma**step
                left = ~arrived
                robots.keep(left)
                lane, first, guide, reusing = lane[left], first[left], guide[left], reusing[left]
                fixed, loose = fixed[:, left], loose[:, left]
                if not len(lane):
                    break
        used = np.arange(lanes), arm
        arm_gain[used] = (arm_gain[used] * arm_trials[used] + gain[trial]) / (arm_trials[used] + 1)
        arm_trials[used] += 1
        temperature += reuse.temperature_step
    return Outcome(gain, arm_gain, arm_trials)


def policy_quality(robots: Robots, goal: int, policies: np.ndarray, parameters: Parameters) -> float:
    """Return the mean discounted return of policies from every start, relative to that of shortest paths without noise.

    Parameters
    ----------
    policies : int8 array (runs, n_states)
        Used in turn, one for each start.
    """
    gamma, limit = parameters.learning.gamma, parameters.learning.max_steps
    starts = start_states(robots.world, goal)
    robots.place(starts)
    run, total = np.arange(len(starts)) % len(policies), 0.0
    for step in range(limit):
        robots.move(policies[run, robots.states])
        left = robots.states != goal
        total += np.count_nonzero(~left) * gamma**step
        robots.keep(left)
        run = run[left]
    distance = robots.world.distances_to(goal)[starts]
    return float(total / (gamma ** (distance[distance <= limit] - 1.0)).sum())


def start_states(world: GridWorld, goal: int) -> np.ndarray:
    """Return the states at which a trial may start: all that reach the goal and are not the goal."""
    return np.flatnonzero(world.distances_to(goal) > 0)
