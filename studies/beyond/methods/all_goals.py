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
from ptl.world.transitions import N_ACTIONS, TransitionGraph
from studies.beyond.methods._transitions import UNSEEN, graph_of, updated


@dataclass
class EveryState(SkillLibrary):
    """A library with a skill to every state visited so far; policies follow from the seen transitions when needed."""

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
    far, of which the newest counts. The size of this library grows with the map.
    """

    label = "A skill to every state"
    colour = "#542788"

    def __init__(self, world: GridWorld, parameters: Parameters, random: np.random.Generator) -> None:
        super().__init__(world, parameters, random)
        self.library = EveryState()
        self.after = np.full((world.n_states, N_ACTIONS), UNSEEN)

    def begin_task(self, start: int, goal: int) -> np.ndarray | None:
        self.graph = graph_of(self.after)
        self._guides: dict[int, Guide] = {}
        return super().begin_task(start, goal)

    def guide(self, skill: int) -> Leader | None:
        subgoal = self.candidates[skill]
        if skill != NULL_SKILL and subgoal not in self._guides:
            self._guides[subgoal] = Guide(self.graph.shortest_path_policy(subgoal), subgoal)
        return None if skill == NULL_SKILL else self._guides[subgoal]

    def end_task(self, learner: Learner) -> None:
        self.after = updated(self.after, learner.transitions)
