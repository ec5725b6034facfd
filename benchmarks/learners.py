"""Learners of one task whose speeds are compared.

All do tabular one-step Q-learning with the same alpha, gamma and epsilon, ties broken uniformly and no step limit, on
the same map. An instance learns one task; only ``run`` is timed.
"""

from __future__ import annotations

import random
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Protocol

import numpy as np

from ptl.agent._kernel import Dynamics, Learner
from ptl.world.gridworld import GridWorld


@dataclass(frozen=True)
class Problem:
    """A task with the parameters of Q-learning.

    Attributes
    ----------
    world : GridWorld
    letter : str
        Letter of the goal.
    alpha, gamma, epsilon : float
    """

    world: GridWorld
    letter: str
    alpha: float = 0.05
    gamma: float = 0.95
    epsilon: float = 0.1

    @property
    def start(self) -> int:
        """State in which every episode begins."""
        return self.world.start

    @property
    def goal(self) -> int:
        """State that ends an episode, with reward 1."""
        return self.world.goal(self.letter)

    @property
    def successors(self) -> np.ndarray:
        """Next states, int array (n_states, 4)."""
        return self.world.successors


class Timed(Protocol):
    """A learner or walk that can be timed."""

    def run(self, episodes: int) -> int:
        """Do some episodes from the start to the goal; return the number of primitive steps."""
        ...


class Kernel:
    """The compiled kernel of the package; with ``shortcut``, two steps at a time where Q is zero all around."""

    def __init__(self, task: Problem, seed: int, shortcut: bool = True) -> None:
        self._start = task.start
        self._learner = Learner(
            Dynamics(task.successors),
            task.goal,
            np.random.SFC64(seed),
            alpha=task.alpha,
            gamma=task.gamma,
            epsilon=task.epsilon,
            max_steps=10**12,
            shortcut=shortcut,
        )

    def run(self, episodes: int) -> int:
        """Learn; return the number of steps."""
        steps = 0
        for _ in range(episodes):
            self._learner.begin_episode(self._start)
            self._learner.explore()
            steps += self._learner.steps
        return steps

    @property
    def q(self) -> np.ndarray:
        """Action values, float array (n_states, 4)."""
        return self._learner.q


class PlainLoop:
    """Plain Python: one loop over lists, no calls but those of the standard library."""

    def __init__(self, task: Problem, seed: int) -> None:
        self._task = task
        self._successors: list[list[int]] = task.successors.tolist()
        self._random = random.Random(seed)
        self.q = [[0.0] * 4 for _ in self._successors]

    def run(self, episodes: int) -> int:
        """Learn; return the number of steps."""
        q, successors, draw = self.q, self._successors, self._random.random
        start, goal = self._task.start, self._task.goal
        alpha, gamma, epsilon = self._task.alpha, self._task.gamma, self._task.epsilon
        steps = 0
        for _ in range(episodes):
            state = start
            while state != goal:
                values = q[state]
                if draw() < epsilon:
                    action = int(4 * draw())
                else:
                    best = max(values)
                    if values.count(best) == 1:
                        action = values.index(best)
                    else:
                        tied = [a for a in (0, 1, 2, 3) if values[a] == best]
                        action = tied[int(len(tied) * draw())]
                state = successors[state][action]
                target = 1.0 if state == goal else gamma * max(q[state])
                values[action] += alpha * (target - values[action])
                steps += 1
        return steps


class GymnasiumLoop:
    """The usual tutorial: a Gymnasium environment, a numpy Q-table and a numpy Generator."""

    def __init__(self, task: Problem, seed: int) -> None:
        from ptl.world.gymnasium_env import GridWorldEnv

        self._world = GridWorldEnv(task.world, task.letter)
        self._task = task
        self._random = np.random.default_rng(seed)
        self.q = np.zeros(task.successors.shape)

    def run(self, episodes: int) -> int:
        """Learn; return the number of steps."""
        world, generator, q, task = self._world, self._random, self.q, self._task
        steps = 0
        for _ in range(episodes):
            state, _ = world.reset()
            ended = False
            while not ended:
                if generator.random() < task.epsilon:
                    action = int(generator.integers(4))
                else:
                    action = int(generator.choice(np.flatnonzero(q[state] == q[state].max())))
                after, reward, ended, _, _ = world.step(np.int64(action))
                target = reward if ended else reward + task.gamma * q[after].max()
                q[state, action] += task.alpha * (target - q[state, action])
                state = after
                steps += 1
        return steps


class Mdplib:
    """The Q-learning of mdplib, a library of tabular methods in C++.

    Its epsilon falls from 1 and ties go to its first action, so it has the step distribution of the others only where
    every action is random: its epsilon is fixed at 1, regardless of the task. It has no episodes: the goal leads to
    the start, and `run` takes `STEPS` steps regardless of the number of episodes.
    """

    STEPS = 1_000_000

    def __init__(self, task: Problem, seed: int) -> None:
        from mdp.core import MDP

        self._task, self._seed = task, seed
        after = task.successors.copy()
        after[task.goal] = task.start
        rows = [
            f"{state},{action},{after[state, action]},1,{int(after[state, action] == task.goal)}\n"
            for state, action in np.ndindex(after.shape)
        ]
        with TemporaryDirectory() as folder:
            table = Path(folder, "transitions.csv")
            table.write_text("sn,a,sn1,prob,reward\n" + "".join(rows), encoding="ascii")
            names = [list(range(length)) for length in after.shape]
            self._model = MDP(*names, None, None, build_transition_file=False, transition_file=str(table))

    def run(self, episodes: int) -> int:
        """Learn anew; return the number of steps."""
        task = self._task
        self._model.QLearning(
            task.gamma, 1.0, task.alpha, s0=task.start, max_iter=self.STEPS, verbose=False, seed=self._seed
        )
        return self.STEPS

    @property
    def values(self) -> np.ndarray:
        """Maximum action value of each state, float array (n_states,)."""
        return np.array(self._model.value)
