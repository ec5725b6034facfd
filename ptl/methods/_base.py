"""The interface of a method: what it does before, in and after the episodes of a task."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from ptl.agent.plan import Plan
from ptl.agent.skills import SkillLibrary
from ptl.config import Parameters
from ptl.world.gridworld import GridWorld

if TYPE_CHECKING:
    from ptl.agent._kernel import Learner


class BaseMethod:
    """One learner's life under one method; the state that passes from task to task lives in the instance.

    A method defines its episodes in one of two ways: it describes them by `plan`, and the loop over episodes is
    compiled, or it runs each by `run_episode`, in Python.

    Parameters
    ----------
    world : GridWorld
    parameters : Parameters
    random : numpy.random.Generator
        For the method's own choices; the steps of the agent draw from another stream.

    Attributes
    ----------
    label, colour : str
        How tables and figures show the method (colour as ``#rrggbb``).
    name : str
        Identifier in files and random streams; a class ``Method`` leaves it out and is called after its file.
    library : SkillLibrary or None
        The skill library if the method keeps one; it is updated after each task.
    """

    label: ClassVar[str]
    colour: ClassVar[str]
    name: ClassVar[str]

    def __init__(self, world: GridWorld, parameters: Parameters, random: np.random.Generator) -> None:
        self.world = world
        self.parameters = parameters
        self.random = random
        self.library: SkillLibrary | None = None

    def begin_task(self, start: int, goal: int) -> np.ndarray | None:
        """Prepare for a new task; return initial action values (n_states, 4), or None for zero."""
        return None

    def plan(self) -> Plan:
        """Return what to do in each episode of the task that has begun."""
        raise NotImplementedError

    def run_episode(self, learner: Learner) -> list[int] | None:
        """Bring the agent from the start to the goal, by the plan; return the skills or arms drawn if any."""
        return self.plan().run(learner)

    def end_task(self, learner: Learner) -> None:
        """Keep what later tasks need, such as the final ``learner.q`` and what was ``learner.seen``."""
