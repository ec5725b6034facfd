"""The largest library: a skill to every visited state (Kaelbling, 1993)."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ptl.agent._kernel import Learner
from ptl.agent.plan import Guide, Leader
from ptl.agent.skills import SkillLibrary, Update
from ptl.agent.subgoals import Discovery
from ptl.config import Parameters
from ptl.methods.ptl import NULL_SKILL
from ptl.methods.ptl import Method as PartialTransfer
from ptl.world.gridworld import GridWorld
from ptl.world.transitions import TransitionGraph


@dataclass
class EveryState(SkillLibrary):
    """A library with a skill to every state visited so far; policies follow from the seen transitions when needed."""

    seen: np.ndarray = field(default_factory=lambda: np.zeros(0, dtype=np.uint8))
    visited: np.ndarray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))

    def __len__(self) -> int:
        return len(self.visited)

    @property
    def subgoals(self) -> list[int]:
        """All visited states."""
        return self.visited.tolist()

    def update(self, discovery: Discovery, graph: TransitionGraph, task_index: int) -> Update:
        """Add all states visited in the task."""
        before = len(self)
        self.visited = np.union1d(self.visited, graph.visited)
        return Update(-1, f"{len(self) - before} states added")


class Method(PartialTransfer):
    """As `ptl`, with a skill to every visited state: the limit case for selection.

    L. P. Kaelbling, Learning to achieve goals, IJCAI 1993. A skill is a shortest path over all transitions seen so
    far. The size of this library grows with the map.
    """

    label = "A skill to every state"
    colour = "#542788"

    def __init__(self, world: GridWorld, parameters: Parameters, random: np.random.Generator) -> None:
        super().__init__(world, parameters, random)
        self.library = EveryState()
        self.seen = np.zeros(world.n_states, dtype=np.uint8)

    def begin_task(self, start: int, goal: int) -> np.ndarray | None:
        self.graph = TransitionGraph(self.world.successors, self.seen)
        self._guides: dict[int, Guide] = {}
        return super().begin_task(start, goal)

    def guide(self, skill: int) -> Leader | None:
        subgoal = self.candidates[skill]
        if skill != NULL_SKILL and subgoal not in self._guides:
            self._guides[subgoal] = Guide(self.graph.shortest_path_policy(subgoal), subgoal)
        return None if skill == NULL_SKILL else self._guides[subgoal]

    def end_task(self, learner: Learner) -> None:
        self.seen |= learner.seen
