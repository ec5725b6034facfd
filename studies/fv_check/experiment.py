"""The experiment of Fernandez and Veloso (FV), to check the implementation of policy reuse.

Their setting (source: FV 2006, 2013): the map of environment 3, start cells drawn at random, trials of at
most 100 steps, 2000 trials, and a library of policies of tasks 1 to 5 (goals A to E here) while task Omega
(goal F) is learned. The measure is the gain W: the discounted return gamma**(steps - 1) of a trial, 0 if the goal was
not reached, averaged over the first k trials.

The learner is the class that the main comparison uses, ``ptl.methods.policy_reuse``. Our choices, where the source
states none that apply here:

* The library's policies are learned in the same setting by plain Q-learning (epsilon-greedy, epsilon = 0.1)
  over 20 000 trials each, anew for every seed.
* A start is drawn uniformly from the cells other than the goal.
* Plain Q-learning, shown for comparison, is the method ``no_transfer`` (epsilon-greedy, epsilon = 0.1).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

import numpy as np

from ptl import methods
from ptl.agent import seeding
from ptl.agent._kernel import Dynamics, Learner
from ptl.agent.policies import greedy_policy
from ptl.config import Parameters
from ptl.errors import UserError
from ptl.files.arrays import read_arrays, write_arrays
from ptl.files.provenance import code_digest
from ptl.files.schema import GAIN
from ptl.methods._base import BaseMethod
from ptl.world.gridworld import GridWorld

LETTERS: Mapping[int, str] = MappingProxyType({1: "A", 2: "B", 3: "C", 4: "D", 5: "E"})
"""FV's tasks 1 to 5 as goals of environment 3 (source: the map's public encodings)."""

NEW_TASK = "F"
"""FV's task Omega as a goal of environment 3."""

TRIALS, MAX_STEPS = 2000, 100
"""K and H of FV."""

LIBRARY_TRIALS = 20_000
"""Trials in which each policy of the library is learned (our choice)."""

PARAMETERS = Parameters.from_dict(
    {
        "learning": {"alpha": 0.05, "gamma": 0.95, "epsilon": 0.1, "max_steps": MAX_STEPS},
        "policy_reuse": {"psi": 1.0, "psi_decay": 0.95, "temperature": 0.0, "temperature_step": 0.05},
    }
)
"""FV's values, whatever the main comparison uses; epsilon is ours and serves plain Q-learning only."""


@dataclass(frozen=True)
class Arm:
    """One curve of the experiment.

    Attributes
    ----------
    tasks : tuple of int
        FV's tasks whose policies are in the library; without any it is plain Q-learning.
    published : float or None
        Mean gain over 2000 trials, read off FV's figure (their agent's position is noisy).
    """

    tasks: tuple[int, ...]
    published: float | None

    @property
    def name(self) -> str:
        """Name in files and tables."""
        return "library_" + "".join(map(str, self.tasks)) if self.tasks else "q_learning"

    @property
    def label(self) -> str:
        """Name in figures."""
        return f"library {{{', '.join(map(str, self.tasks))}}}" if self.tasks else "plain Q-learning"


ARMS = {
    arm.name: arm for arm in (Arm((), None), Arm((2, 3, 4), 0.07), Arm((1, 2, 3, 4), 0.25), Arm((2, 3, 4, 5), 0.275))
}
"""The curves by name, with the values read off FV's figure."""


# -- learning ------------------------------------------------------------------------------------------------


def learn_gains(
    world: GridWorld,
    goal: int,
    method: BaseMethod,
    trials: int,
    seed_names: Iterable[str | int],
    root_seed: int,
) -> tuple[np.ndarray, Learner]:
    """Learn one task from random starts.

    Returns
    -------
    gains : float array (trials,)
        Discounted return of each trial.
    learner : Learner
        With the final action values.
    """
    names = tuple(seed_names)
    learning = PARAMETERS.learning
    starts = random_starts(world, goal, trials, seeding.generator(root_seed, *names, "starts"))
    learner = Learner(
        Dynamics(world.successors),
        goal,
        seeding.bit_generator(root_seed, *names, "steps"),
        alpha=learning.alpha,
        gamma=learning.gamma,
        epsilon=learning.epsilon,
        max_steps=learning.max_steps,
        initial_q=method.begin_task(starts[0], goal),
    )
    gains = np.zeros(trials)
    for trial, start in enumerate(starts):
        learner.begin_episode(start)
        method.run_episode(learner)
        if learner.at_goal:
            gains[trial] = learning.gamma ** (learner.steps - 1)
    return gains, learner


def random_starts(world: GridWorld, goal: int, number: int, random: np.random.Generator) -> list[int]:
    """Draw start states uniformly from those that reach the goal and are not the goal."""
    distance = world.distances_to(goal)
    return random.choice(np.flatnonzero(distance > 0), size=number).tolist()


def learn_arm(
    world: GridWorld,
    arm: Arm,
    seed: int,
    root_seed: int,
    trials: int = TRIALS,
    library_trials: int = LIBRARY_TRIALS,
) -> tuple[np.ndarray, np.ndarray]:
    """Learn FV's new task with one library and one seed.

    Returns
    -------
    gains : float array (trials,)
    quality : float array (tasks in the library,)
        Mean gain of each policy in its own task over all starts, as a share of the optimum.
    """
    names = ("fernandez_veloso", seed)
    method = _new_method("policy_reuse" if arm.tasks else "no_transfer", world, root_seed, *names, arm.name)
    quality = []
    for task in arm.tasks:
        goal = world.goal(LETTERS[task])
        # named by seed and task only: the same policy in every library
        past = (*names, "past", task)
        teacher = _new_method("no_transfer", world, root_seed, *past)
        _, learner = learn_gains(world, goal, teacher, library_trials, past, root_seed)
        method.end_task(learner)
        quality.append(policy_quality(world, greedy_policy(learner.q), goal))
    gains, _ = learn_gains(world, world.goal(NEW_TASK), method, trials, (*names, arm.name), root_seed)
    return gains, np.array(quality)


def _new_method(identifier: str, world: GridWorld, root_seed: int, *names: str | int) -> BaseMethod:
    return methods.load(identifier)(world, PARAMETERS, seeding.generator(root_seed, *names, "choices"))


def policy_quality(world: GridWorld, policy: np.ndarray, goal: int) -> float:
    """Return the mean discounted return of a policy over all starts that reach the goal, as a share of the optimum's.

    Parameters
    ----------
    policy : int8 array (n_states,)
        Action of each state, -1 (where the agent would stand still) if undefined.
    """
    gamma = PARAMETERS.learning.gamma
    distance = world.distances_to(goal)
    starts = np.flatnonzero(distance > 0)
    state = starts.copy()
    gain = np.zeros(len(starts))
    successors = np.where(policy >= 0, world.successors[np.arange(world.n_states), policy], np.arange(world.n_states))
    for step in range(MAX_STEPS):
        before = state
        state = np.where(state == goal, goal, successors[state])
        gain[(state == goal) & (before != goal)] = gamma**step
    within = distance[starts] <= MAX_STEPS
    return float(gain.sum() / (within * gamma ** (distance[starts] - 1.0)).sum())


# -- files ---------------------------------------------------------------------------------------------------


def run_job(
    world: GridWorld,
    arm_name: str,
    seeds: Iterable[int],
    root_seed: int,
    trials: int,
    library_trials: int,
    output: Path,
) -> None:
    """Learn one arm with several seeds and write the gains, float array (seeds, trials)."""
    if arm_name not in ARMS:
        raise UserError(f"library {arm_name!r} is unknown; known are {', '.join(ARMS)}")
    arm = ARMS[arm_name]
    seeds = list(seeds)
    lives = [learn_arm(world, arm, seed, root_seed, trials, library_trials) for seed in seeds]
    arrays = {
        "seeds": np.array(seeds, dtype=np.int64),
        "gain": np.array([gains for gains, _ in lives]),
        "policy_quality": np.array([quality for _, quality in lives]),
    }
    origin = {
        "arm": arm_name,
        "root_seed": root_seed,
        "library_trials": library_trials,
        "parameters": PARAMETERS.to_dict(),
        "map": world.text,
        "code": code_digest("studies.fv_check.experiment", "ptl.methods.policy_reuse", "ptl.methods.no_transfer"),
    }
    write_arrays(output, GAIN, arrays, origin)


@dataclass(frozen=True)
class Gains:
    """Results of one job: gains (seeds, trials) and quality of the library's policies (seeds, tasks)."""

    arm: Arm
    gain: np.ndarray
    quality: np.ndarray

    @property
    def mean_gain(self) -> np.ndarray:
        """W over the first k trials for k = 1, 2, ..., float array (seeds, trials)."""
        return np.cumsum(self.gain, axis=1) / np.arange(1, self.gain.shape[1] + 1)


def read_gains(paths: Iterable[str | Path]) -> list[Gains]:
    """Read the files of several arms; they come in the order of `ARMS`.

    Raises
    ------
    UserError
        When a file is damaged, an arm is given twice, or numbers of trials differ.
    """
    found: dict[str, Gains] = {}
    for path in paths:
        arrays, origin = read_arrays(path, GAIN)
        name = str(origin["arm"])
        if name not in ARMS:
            raise UserError(f"{path}: library {name!r} is unknown; known are {', '.join(ARMS)}")
        if name in found:
            raise UserError(f"{path}: library {name} is given twice; name each file once")
        found[name] = Gains(ARMS[name], arrays["gain"], arrays["policy_quality"])
    trials = {gains.gain.shape[1] for gains in found.values()}
    if len(trials) > 1:
        raise UserError(
            f"files with {' and '.join(map(str, sorted(trials)))} trials cannot be compared; make them again"
        )
    return [found[name] for name in ARMS if name in found]
