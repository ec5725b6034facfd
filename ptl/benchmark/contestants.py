"""Learners that are timed against each other on the same task under the same law, and what bounds their speed.

All learners do tabular one-step Q-learning with the same alpha, gamma and epsilon, uniform ties and no step limit, on
the same map. Each contestant is a class; an instance learns one task, and only `run` is timed.
"""

from __future__ import annotations

import random
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
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
    for module, package in {"gymnasium": "gymnasium", "mdp": "mdplib", "numba": "numba"}.items():
        if find_spec(module) is None:
            raise UserError(f"{package} is not installed; run 'make benchmark', which installs it first")


class Timed(Protocol):
    """What can be timed: ``run`` does some episodes from the start to the goal and returns their primitive steps."""

    def __init__(self, task: Task, seed: int, initial_q: np.ndarray | None = None) -> None: ...

    def run(self, episodes: int) -> int:
        """Run; return the number of steps taken."""
        ...


class Contestant(Timed, Protocol):
    """A learner."""

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


class Mdplib:
    """The Q-learning of mdplib, a library of tabular methods in C++.

    Its epsilon falls from 1 and its ties go to the first action, so it shares the law of the others only where every
    action is random: its epsilon is held at 1, whatever the task says. It knows no episodes: the goal leads to the
    start, and `run` takes `STEPS` steps whatever the number of episodes.
    """

    STEPS = 1_000_000

    def __init__(self, task: Task, seed: int, initial_q: np.ndarray | None = None) -> None:
        from mdp.core import MDP

        if initial_q is not None:
            raise ValueError("mdplib begins with Q = 0")
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
        """Learn anew; return the number of steps taken."""
        task = self._task
        self._model.QLearning(
            task.gamma, 1.0, task.alpha, s0=task.start, max_iter=self.STEPS, verbose=False, seed=self._seed
        )
        return self.STEPS

    @property
    def values(self) -> np.ndarray:
        """Greatest action value of each state, float array (n_states,)."""
        return np.array(self._model.value)


# -- limits --------------------------------------------------------------------------------------------------


class BareWalk:
    """The random walk to the goal and nothing else: one look-up after another, with random bits that cost nothing."""

    steps_a_lookup = 1

    def __init__(self, task: Task, seed: int, initial_q: np.ndarray | None = None) -> None:
        from ptl.benchmark import numba_loop

        self._walk = numba_loop.walk
        table = task.successors.copy()
        table[task.goal] = task.goal
        bits = 2 * self.steps_a_lookup
        if self.steps_a_lookup == 2:
            table = table[table].reshape(len(table), 16)
        places = (task.start << bits, task.goal << bits)
        words = np.random.SFC64(seed).random_raw(2**12)
        self._arguments = ((table << bits).astype(np.uint32).ravel(), bits, *places, words)
        self.run(0)  # compiles the loop

    def run(self, episodes: int) -> int:
        """Walk; return the number of steps taken."""
        return self.steps_a_lookup * self._walk(*self._arguments, episodes)


class BareWalkByTwos(BareWalk):
    """The same with the table of two steps at a time; the step that would leave the goal counts as well."""

    steps_a_lookup = 2


class RandomWords:
    """Random words as the kernel draws them, by numpy's C interface: `WORDS` of them a run."""

    WORDS = 10_000_000

    def __init__(self, task: Task, seed: int, initial_q: np.ndarray | None = None) -> None:
        from ptl.benchmark import numba_loop

        self._draw = numba_loop.draw
        self._generator = np.random.SFC64(seed)  # owns the state
        interface = self._generator.ctypes
        self._arguments = (interface.next_uint64, interface.state_address)
        self._draw(*self._arguments, 0)  # compiles the loop

    def run(self, episodes: int) -> int:
        """Draw; return the number of words."""
        self._draw(*self._arguments, self.WORDS)
        return self.WORDS
