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
from types import MappingProxyType

import numpy as np

from ptl import methods
from ptl.agent import seeding
from ptl.agent._kernel import Dynamics, Learner
from ptl.agent.policies import greedy_policy
from ptl.config import Parameters
from ptl.methods._base import BaseMethod
from ptl.world.gridworld import GridWorld

LETTERS: Mapping[str, str] = MappingProxyType({"1": "A", "2": "B", "3": "C", "4": "D", "5": "E"})
"""FV's tasks 1 to 5 as goals of environment 3 (source: the map's public encodings)."""

NEW_TASK = "F"
"""FV's task Omega as a goal of environment 3."""

MAX_STEPS = 100
"""H of FV."""

PARAMETERS = Parameters.from_dict(
    {
        "learning": {"alpha": 0.05, "gamma": 0.95, "epsilon": 0.1, "max_steps": MAX_STEPS},
        "policy_reuse": {"psi": 1.0, "psi_decay": 0.95, "temperature": 0.0, "temperature_step": 0.05},
    }
)
"""FV's values, independent of the main comparison; epsilon is ours and used by plain Q-learning only."""

REUSE, PLAIN = "policy_reuse", "no_transfer"
"""Methods that learn the new task with a library and without, and the library's policies (the latter)."""

STREAM = "fernandez_veloso"
"""First name of every random stream."""


@dataclass(frozen=True)
class PastTasks:
    """A library of the experiment: the tasks of its policies.

    Attributes
    ----------
    tasks : str
        FV's numbers of the tasks, such as "234"; empty for plain Q-learning.
    published : float or None
        Mean gain over 2000 trials, read off FV's figure (their agent's position is noisy).
    """

    tasks: str
    published: float | None

    @property
    def name(self) -> str:
        """Name in files and tables."""
        return f"library_{self.tasks}" if self.tasks else "q_learning"

    @property
    def label(self) -> str:
        """Name in figures."""
        return f"library {{{', '.join(self.tasks)}}}" if self.tasks else "plain Q-learning"


LIBRARIES = tuple(PastTasks(*values) for values in (("", None), ("234", 0.07), ("1234", 0.25), ("2345", 0.275)))
"""The libraries that are compared, with the values read off FV's figure."""


def learn_library(
    world: GridWorld,
    tasks: str,
    parameters: Parameters,
    root_seed: int,
    seed: int,
    trials: int,
    library_trials: int,
) -> tuple[np.ndarray, np.ndarray]:
    """Learn FV's new task with the policies of past tasks, with one seed.

    Returns
    -------
    gains : float array (trials,)
    quality : float array (past tasks,)
        Mean gain of each policy in its own task over all starts, as a share of the optimum.
    """
    names = (STREAM, seed)
    name = PastTasks(tasks, None).name
    method = _new_method(REUSE if tasks else PLAIN, world, parameters, root_seed, *names, name)
    quality = []
    for task in tasks:
        goal = world.goal(LETTERS[task])
        # named by seed and task only: the same policy in every library
        past = (*names, "past", int(task))
        teacher = _new_method(PLAIN, world, parameters, root_seed, *past)
        _, learner = learn_gains(world, goal, teacher, parameters, library_trials, past, root_seed)
        method.end_task(learner)
        quality.append(policy_quality(world, greedy_policy(learner.q), goal, parameters))
    gains, _ = learn_gains(world, world.goal(NEW_TASK), method, parameters, trials, (*names, name), root_seed)
    return gains, np.array(quality)


def learn_gains(
    world: GridWorld,
    goal: int,
    method: BaseMethod,
    parameters: Parameters,
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
    learning = parameters.learning
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


def policy_quality(world: GridWorld, policy: np.ndarray, goal: int, parameters: Parameters) -> float:
    """Return the mean discounted return of a policy over all starts that reach the goal, as a share of the optimum's.

    Parameters
    ----------
    policy : int8 array (n_states,)
        Action of each state, -1 (the agent stays in place) if undefined.
    """
    gamma, limit = parameters.learning.gamma, parameters.learning.max_steps
    distance = world.distances_to(goal)
    starts = np.flatnonzero(distance > 0)
    state = starts.copy()
    gain = np.zeros(len(starts))
    successors = np.where(policy >= 0, world.successors[np.arange(world.n_states), policy], np.arange(world.n_states))
    for step in range(limit):
        before = state
        state = np.where(state == goal, goal, successors[state])
        gain[(state == goal) & (before != goal)] = gamma**step
    within = distance[starts] <= limit
    return float(gain.sum() / (within * gamma ** (distance[starts] - 1.0)).sum())


def _new_method(
    identifier: str, world: GridWorld, parameters: Parameters, root_seed: int, *names: str | int
) -> BaseMethod:
    return methods.load(identifier)(world, parameters, seeding.generator(root_seed, *names, "choices"))
