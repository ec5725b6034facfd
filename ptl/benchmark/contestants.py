"""Learners that are timed against each other on the same task under the same law.

All of them do tabular one-step Q-learning with the same alpha, gamma and epsilon, uniform ties and no step limit, on
the same map. Each contestant is a class; an instance learns one task, and only `run` is timed.
"""

from __future__ import annotations

import random
from importlib.util import find_spec
from typing import Protocol

import numpy as np

from ptl.agent._kernel import Dynamics, Learner
from ptl.benchmark.task import Task
from ptl.errors import UserError


def check_installed() -> None:
    """Refuse to start without the libraries that some contestants come from.

    Raises
    ------
    UserError
    """
    for module in ("gymnasium", "numba"):
        if find_spec(module) is None:
            raise UserError(f"{module} is not installed; run 'make benchmark', which installs it first")


class Contestant(Protocol):
    """A learner: ``run`` learns some episodes from the start to the goal and returns their primitive steps."""

    def __init__(self, task: Task, seed: int, initial_q: np.ndarray | None = None) -> None: ...

    def run(self, episodes: int) -> int:
        """Learn; return the number of steps taken."""
        ...

    @property
    def q(self) -> np.ndarray:
        """Action values, float array (n_states, 4)."""
        ...


class Kernel:
    """The compiled kernel, two steps at a time where Q is zero all around."""

    shortcut = True

    def __init__(self, task: Task, seed: int, initial_q: np.ndarray | None = None) -> None:
        self._start = task.start
        self._learner = Learner(
            Dynamics(task.successors),
            task.goal,
            np.random.SFC64(seed),
            alpha=task.alpha,
            gamma=task.gamma,
            epsilon=task.epsilon,
            max_steps=10**12,
            initial_q=initial_q,
            shortcut=self.shortcut,
        )

    def run(self, episodes: int) -> int:
        """Learn; return the number of steps taken."""
        learner, start, steps = self._learner, self._start, 0
        for _ in range(episodes):
            learner.begin_episode(start)
            learner.explore()
            steps += learner.steps
        return steps

    @property
    def q(self) -> np.ndarray:
        """Action values, float array (n_states, 4)."""
        return self._learner.q


class KernelEveryStep(Kernel):
    """The compiled kernel, every step simulated."""

    shortcut = False


class PlainLoop:
    """Plain Python: one loop over lists, no calls but those of the standard library."""

    def __init__(self, task: Task, seed: int, initial_q: np.ndarray | None = None) -> None:
        self._task = task
        self._successors: list[list[int]] = task.successors.tolist()  # type: ignore[assignment]
        self._random = random.Random(seed)
        self._q: list[list[float]] = task.initial_q(initial_q).tolist()  # type: ignore[assignment]

    def run(self, episodes: int) -> int:
        """Learn; return the number of steps taken."""
        q, successors, draw = self._q, self._successors, self._random.random
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

    @property
    def q(self) -> np.ndarray:
        """Action values, float array (n_states, 4)."""
        return np.array(self._q)


class GymnasiumLoop:
    """The usual tutorial: a Gymnasium environment, a numpy Q-table and a numpy Generator."""

    def __init__(self, task: Task, seed: int, initial_q: np.ndarray | None = None) -> None:
        from ptl.world.gymnasium_env import GridWorldEnv

        self._world = GridWorldEnv(task.world, task.letter)
        self._task = task
        self._random = np.random.default_rng(seed)
        self._q = task.initial_q(initial_q)

    def run(self, episodes: int) -> int:
        """Learn; return the number of steps taken."""
        world, generator, q, task = self._world, self._random, self._q, self._task
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

    @property
    def q(self) -> np.ndarray:
        """Action values, float array (n_states, 4)."""
        return self._q


class NumbaLoop:
    """One loop over arrays, compiled by Numba."""

    def __init__(self, task: Task, seed: int, initial_q: np.ndarray | None = None) -> None:
        from ptl.benchmark import numba_loop

        self._learn = numba_loop.learn
        self._task = task
        generator = np.random.default_rng(seed)
        self._arguments = (task.start, task.goal, task.alpha, task.gamma, task.epsilon, generator)
        self._q = task.initial_q(initial_q)
        self.run(0)  # compiles the loop

    def run(self, episodes: int) -> int:
        """Learn; return the number of steps taken."""
        return self._learn(self._task.successors, self._q, *self._arguments, episodes)

    @property
    def q(self) -> np.ndarray:
        """Action values, float array (n_states, 4)."""
        return self._q
