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
    "GridWorld": "ptl.world.gridworld",
    "load_map": "ptl.world.map_files",
    "Parameters": "ptl.config",
    "Task": "ptl.learning.life",
    "TaskRecord": "ptl.learning.life",
    "Life": "ptl.learning.life",
    "tasks_of": "ptl.learning.life",
    "learn_life": "ptl.learning.life",
    "learn_task": "ptl.learning.life",
    "Dynamics": "ptl.agent._kernel",
    "Learner": "ptl.agent._kernel",
    "TransitionGraph": "ptl.world.transitions",
    "discover": "ptl.agent.subgoals",
    "fd_metric": "ptl.agent.subgoals",
    "Skill": "ptl.agent.skills",
    "SkillLibrary": "ptl.agent.skills",
    "SkillSelection": "ptl.agent._selection",
    "greedy_policy": "ptl.agent.policies",
    "Learn": "ptl.jobs.learn",
    "read": "ptl.files.store",
    "tasks_in": "ptl.jobs.learn",
    "skills_of": "ptl.jobs.learn",
    "measure": "ptl.measures.measures",
    "UserError": "ptl.errors",
}

__all__ = ["__version__", *_PLACES]


def __getattr__(name: str) -> Any:
    if name not in _PLACES:
        raise AttributeError(f"module 'ptl' has no attribute {name!r}")
    return getattr(import_module(_PLACES[name]), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *_PLACES})
