"""mushroom-rl's tabular Q-learning on a grid world.

mushroom-rl imports PyTorch whatever part of it is used; its tabular learning never calls it. To spare everyone some
gigabytes, the benchmark's requirements leave PyTorch out, and while mushroom-rl is imported a placeholder stands in.
Afterwards any use of the placeholder raises, so nothing that is timed can have gone through it. An installed PyTorch
is used as it is.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, MutableSequence
from contextlib import contextmanager
from importlib import import_module
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from importlib.util import find_spec
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from ptl.benchmark.task import Task


class _Placeholder(ModuleType):
    """Anything of PyTorch: module, class, function or value; usable only while mushroom-rl is being imported."""

    __path__: MutableSequence[str] = []  # noqa: RUF012  as in ModuleType
    sealed = False

    def __getattr__(self, name: str) -> _Placeholder:
        if name.startswith("__"):
            raise AttributeError(name)
        self._refuse_when_sealed(name)
        return _Placeholder(f"{self.__name__}.{name}")

    def __call__(self, *args: Any, **kwargs: Any) -> _Placeholder:
        self._refuse_when_sealed("()")
        return _Placeholder(f"{self.__name__}()")

    def __mro_entries__(self, bases: tuple) -> tuple[type]:
        return (object,)

    def _refuse_when_sealed(self, name: str) -> None:
        if _Placeholder.sealed:
            raise RuntimeError(f"{self.__name__}{name}: PyTorch is needed here, but only a placeholder was imported")


class _PlaceholderFinder(MetaPathFinder, Loader):
    def find_spec(self, fullname: str, path: Any, target: Any = None) -> ModuleSpec | None:
        return ModuleSpec(fullname, self, is_package=True) if fullname.split(".")[0] == "torch" else None

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        return _Placeholder(spec.name)

    def exec_module(self, module: ModuleType) -> None:
        pass


@contextmanager
def _torch_importable() -> Iterator[None]:
    if find_spec("torch") is not None:
        yield
        return
    # These look for PyTorch among the loaded modules, so they come before the placeholder.
    import_module("scipy.stats")
    import_module("sklearn.utils.extmath")

    finder = _PlaceholderFinder()
    sys.meta_path.insert(0, finder)
    try:
        yield
    finally:
        sys.meta_path.remove(finder)
        for name in [name for name, module in sys.modules.items() if isinstance(module, _Placeholder)]:
            del sys.modules[name]
        _Placeholder.sealed = True


with _torch_importable():
    from mushroom_rl.algorithms.value import QLearning
    from mushroom_rl.core import Core, Environment, MDPInfo
    from mushroom_rl.policy import EpsGreedy
    from mushroom_rl.utils import spaces
    from mushroom_rl.utils.parameters import Parameter


class World(Environment):
    """States 0..n-1, four actions, reward 1 at the goal, which ends the episode."""

    def __init__(self, task: Task) -> None:
        self._task = task
        self._state = np.array([task.start])
        n_states, n_actions = task.successors.shape
        super().__init__(MDPInfo(spaces.Discrete(n_states), spaces.Discrete(n_actions), task.gamma, np.inf))

    def reset(self, state: np.ndarray | None = None) -> np.ndarray:
        """Put the agent on the start."""
        self._state = np.array([self._task.start])
        return self._state

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, dict]:
        """One primitive step."""
        after = self._task.successors[self._state[0], action[0]]
        self._state = np.array([after])
        ended = bool(after == self._task.goal)
        return self._state, float(ended), ended, {}


def make_core(task: Task, initial_q: np.ndarray | None = None) -> Core:
    """mushroom-rl's training loop for a task, with its Q-learning and epsilon-greedy policy."""
    world = World(task)
    agent = QLearning(world.info, EpsGreedy(Parameter(task.epsilon)), Parameter(task.alpha))
    if initial_q is not None:
        agent.Q.table[...] = initial_q
    return Core(agent, world)
