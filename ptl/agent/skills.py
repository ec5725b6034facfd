"""Skills and the library that grows by at most one of them after each task."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from ptl.agent.finders import Finder, incremental
from ptl.agent.subgoals import Discovery
from ptl.world.transitions import TransitionGraph


@dataclass(frozen=True)
class Skill:
    """A policy that reaches a subgoal from the states visited in the task that taught it.

    Attributes
    ----------
    subgoal : int
    policy : int8 array, shape (n_states,)
        First action of a shortest path to the subgoal over the seen transitions, -1 where undefined.
    learned_after : int
        Index of the task after which it was added, counted from 0.
    initiation : bool array, shape (n_states,), or None
        Initiation set, see `Discovery.states_before` and `ptl.agent.plan.Leader`; None if the library keeps none.
    """

    subgoal: int
    policy: np.ndarray = field(repr=False)
    learned_after: int
    initiation: np.ndarray | None = field(default=None, repr=False)


@dataclass(frozen=True)
class Update:
    """The outcome of one library update: the state added, or -1, and the reason."""

    subgoal: int
    reason: str


@dataclass(repr=False)
class SkillLibrary:
    """The growing collection of skills, in the order in which they were added; ``for skill in library`` yields them.

    Parameters
    ----------
    novelty : float
        rho: the unknown rest of the paths must be at least this share of the diameter of the visited part.
    threshold : float
        theta: minimum value of the greatest incremental metric.
    finder : function
        Scores the states, see `ptl.agent.finders`.
    initiation_sets : bool
        Whether its skills have initiation sets.
    """

    novelty: float = 0.2
    threshold: float = 0.2
    finder: Finder = incremental
    initiation_sets: bool = False
    skills: list[Skill] = field(default_factory=list)

    def __len__(self) -> int:
        return len(self.skills)

    def __iter__(self) -> Iterator[Skill]:
        return iter(self.skills)

    def __getitem__(self, place: int) -> Skill:
        return self.skills[place]

    def __repr__(self) -> str:
        return f"<SkillLibrary: {len(self)} skills, subgoals {self.subgoals}>"

    @property
    def subgoals(self) -> list[int]:
        """Subgoals in the order in which they were added."""
        return [skill.subgoal for skill in self.skills]

    def known_states(self, start: int, successors: np.ndarray, known: str = "subgoals") -> list[int]:
        """Return the states that the library knows: its subgoals, or with "paths" also the skills' ways to them.

        Which of the two the article means is open; the default is our choice.

        Parameters
        ----------
        start : int
            State from which the skills' policies are followed.
        successors : int array, shape (n_states, 4)
            Next states of the map.
        known : {"subgoals", "paths"}
        """
        if known == "subgoals":
            return self.subgoals
        return sorted({state for skill in self.skills for state in (skill.subgoal, *_way(skill, start, successors))})

    def update(self, discovery: Discovery, graph: TransitionGraph, task_index: int) -> Update:
        """Add the state that the finder scores highest as a skill if three tests are passed (our choice).

        A skill is added if the unknown parts of the paths are long enough, the incremental metric reaches its threshold
        somewhere and the subgoal is new. The first two determine whether a skill is needed, independent of the finder,
        which determines where. Ties go to the state with the lowest number.
        """
        highest = discovery.incremental.product.max()
        if discovery.novelty < self.novelty * discovery.diameter:
            return Update(-1, "the unknown part of the paths is too short")
        # A metric of 0 everywhere has no argmax, even with a threshold of 0.
        if highest < self.threshold or highest == 0:
            return Update(-1, "no state stands out")
        candidate = int(self.finder(discovery, graph, self.subgoals).argmax())
        if candidate in self.subgoals:
            return Update(-1, "the subgoal is in the library already")
        initiation = discovery.states_before(candidate) if self.initiation_sets else None
        self.skills.append(Skill(candidate, graph.shortest_path_policy(candidate), task_index, initiation))
        return Update(candidate, "added")


def _way(skill: Skill, start: int, successors: np.ndarray) -> list[int]:
    """Return the states through which a skill's policy leads from ``start``, up to where it ends or is undefined.

    On another map than that of the task which taught the skill it may come back to a state, and ends there.
    """
    way: dict[int, None] = {}
    state = start
    while state != skill.subgoal and skill.policy[state] >= 0 and state not in way:
        way[state] = None
        state = int(successors[state, skill.policy[state]])
    return list(way)
