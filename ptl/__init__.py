"""Partial transfer learning with a skill library, in grid worlds.

A small library behind the reproduction package:

>>> import ptl
>>> world = ptl.load_map("config/environments/env2.txt")
>>> life = ptl.learn_life(world, ptl.tasks_of(world, "ABC"), "ptl", ptl.Parameters(), root_seed=1)
>>> [record.task.name for record in life.records]
['A', 'B', 'C']

Everything named here is loaded when it is first used, so that a job pays only for what it needs.
"""

from importlib import import_module
from typing import Any

__version__ = "1.0.0"

_PLACES = {
    "GridWorld": "ptl.gridworld",
    "load_map": "ptl.gridworld",
    "Parameters": "ptl.parameters",
    "Task": "ptl.learning",
    "TaskRecord": "ptl.learning",
    "Life": "ptl.learning",
    "tasks_of": "ptl.learning",
    "learn_life": "ptl.learning",
    "learn_task": "ptl.learning",
    "Dynamics": "ptl._kernel",
    "Learner": "ptl._kernel",
    "TransitionGraph": "ptl.transitions",
    "discover": "ptl.subgoals",
    "fd_metric": "ptl.subgoals",
    "Skill": "ptl.skills",
    "SkillLibrary": "ptl.skills",
    "SkillSelection": "ptl.selection",
    "greedy_policy": "ptl.policies",
    "open_learning": "ptl.store",
    "write_learning": "ptl.store",
    "measure_files": "ptl.measures",
    "UserError": "ptl.errors",
}

__all__ = ["__version__", *_PLACES]


def __getattr__(name: str) -> Any:
    if name not in _PLACES:
        raise AttributeError(f"module 'ptl' has no attribute {name!r}")
    return getattr(import_module(_PLACES[name]), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *_PLACES})
