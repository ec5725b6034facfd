"""Partial transfer learning with a skill library, in grid worlds.

A small library behind the reproduction package:

>>> import ptl
>>> world = ptl.load_map("config/environments/env2.txt")
>>> life = ptl.learn_life(world, "ABC", parameters=ptl.Parameters(episodes=50))
>>> [record.task.name for record in life.records]
['A', 'B', 'C']
>>> len(life.library) == len([skill.subgoal for skill in life.library])
True

`learn_life` has a default for everything but map and tasks. `plot_map`, `plot_values` and `plot_curve` draw on axes of
matplotlib; ``examples/first_look.ipynb`` shows them.

Everything named here is loaded when it is first used, so that a job pays only for what it needs.
"""

from importlib import import_module
from typing import Any

__version__ = "1.0.0"

_PLACES = {
    "GridWorld": "ptl.world.gridworld",
    "load_map": "ptl.world.map_files",
    "read_map": "ptl.world.map_files",
    "MapOptions": "ptl.config",
    "Parameters": "ptl.config",
    "Learning": "ptl.config",
    "Skills": "ptl.config",
    "Subgoals": "ptl.config",
    "PolicyReuse": "ptl.config",
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
    "read": "ptl.jobs.kinds",
    "tasks_in": "ptl.jobs.learn",
    "skills_of": "ptl.jobs.learn",
    "measure": "ptl.measures.measures",
    "plot_map": "ptl.report.plots",
    "plot_values": "ptl.report.plots",
    "plot_curve": "ptl.report.plots",
    "UserError": "ptl.errors",
}

__all__ = ["__version__", *_PLACES]


def __getattr__(name: str) -> Any:
    if name not in _PLACES:
        raise AttributeError(f"module 'ptl' has no attribute {name!r}")
    return getattr(import_module(_PLACES[name]), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *_PLACES})
