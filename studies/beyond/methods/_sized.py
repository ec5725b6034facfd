"""PTL with libraries of a given size: a fixed number of skills after each task, needed or not."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ptl.agent.skills import Skill, SkillLibrary, Update
from ptl.agent.subgoals import Discovery, discover
from ptl.config import Parameters
from ptl.methods.ptl import Method as PartialTransfer
from ptl.world.gridworld import GridWorld
from ptl.world.transitions import TransitionGraph


@dataclass
class SizedLibrary(SkillLibrary):
    """Adds the best ``per_task`` states that are not stored, one after another, without the library's conditions."""

    per_task: int = 1
    cover_radius: int = 2

    def update(self, discovery: Discovery, graph: TransitionGraph, task_index: int) -> Update:
        """Add skills until there are enough or the finder has no further candidate; return the last one added."""
        update = Update(-1, "the finder has no candidate")
        for _ in range(self.per_task if len(discovery.paths) else 0):
            scores = np.array(self.finder(discovery, graph, self.subgoals), dtype=float)
            scores[self.subgoals] = 0.0
            candidate = int(scores.argmax())
            if scores[candidate] <= 0:
                break
            self.skills.append(Skill(candidate, graph.shortest_path_policy(candidate), task_index))
            update = Update(candidate, "added")
            discovery = discover(discovery.paths, graph, self.subgoals, self.cover_radius, discovery.form)
        return update


def sized(kind: type[PartialTransfer], identifier: str, per_task: int) -> type[PartialTransfer]:
    """Return a variant of PTL that adds ``per_task`` skills after each task, called ``<identifier>_x<per_task>``."""

    class Sized(kind):  # type: ignore[valid-type, misc]
        name = f"{identifier}_x{per_task}"

        def __init__(self, world: GridWorld, parameters: Parameters, random: np.random.Generator) -> None:
            super().__init__(world, parameters, random)
            radius = parameters.subgoals.cover_radius
            self.library = SizedLibrary(finder=self.finder(), per_task=per_task, cover_radius=radius)

    return Sized
