"""Learn a stored life again and record what its file does not contain: probabilities and the steps of first episodes.

Equal seeds give equal lives, so the package's own code is run a second time, and a life that differs from its file in
a single step, draw or value is refused.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ptl import methods
from ptl.agent import seeding
from ptl.agent._kernel import Dynamics, Learner
from ptl.errors import UserError
from ptl.files.store import AGAIN, Result
from ptl.jobs.learn import TaskView, tasks_in
from ptl.learning.life import Task, TaskRecord, learn_task
from ptl.methods._base import BaseMethod
from ptl.methods.policy_reuse import Method as PolicyReuse
from ptl.methods.ptl import Method as PartialTransfer

MAX_RECORDED_STEPS = 5000
"""Maximum number of recorded steps of a first episode (our choice, for the size of the page)."""

OWN_GUIDE = -1
"""Candidate number of a policy that is neither a skill of the library nor the policy of an earlier task."""


@dataclass
class Notes:
    """Notes taken while one task was learned.

    Attributes
    ----------
    informed : bool
        Whether the task started from action values other than zero.
    chances : list of float arrays, shape (candidates,)
        Probability of each candidate at the beginning of each episode; empty if the method has its own selection rule.
    actions : uint8 array
        Actions of the first episode, at most `MAX_RECORDED_STEPS`.
    parts : list of [int, int]
        Parts of the first episode in order: the candidate that guided (0 for none, `OWN_GUIDE`) and its steps.
    """

    informed: bool
    chances: list[np.ndarray] = field(default_factory=list)
    actions: np.ndarray = field(default_factory=lambda: np.empty(0, dtype=np.uint8))
    parts: list[list[int]] = field(default_factory=list)


def replay(result: Result, kind: type[BaseMethod] | None = None) -> Iterator[Notes]:
    """Learn the tasks of a file again and yield the notes of each.

    Parameters
    ----------
    kind : type, optional
        Class of the file's method, if it is no built-in one.

    Raises
    ------
    UserError
        If a task's steps, draws or values differ from those of the file.
    """
    job, world = result.job, result.world
    names, parameters = (job.method, job.environment, job.seed), job.settings
    choices = seeding.generator(job.root_seed, *names, "choices")
    method = _Watched((kind or methods.load(job.method))(world, parameters, choices))
    dynamics = Dynamics(world.successors, world.slip)
    for index, stored in enumerate(tasks_in(result).values()):
        task = Task(stored.name, stored.start, stored.goal)
        steps = seeding.bit_generator(job.root_seed, *names, "steps", index)
        _check_equal(result, stored, learn_task(world, dynamics, task, method, parameters, steps, index))
        yield method.notes


def probabilities(method: BaseMethod) -> np.ndarray | None:
    """Return the probability of each candidate in the next episode, None if it has no candidates or an unknown rule."""
    if isinstance(method, PolicyReuse):
        return method.arm_probabilities()
    if not isinstance(method, PartialTransfer):
        return None
    named = getattr(method, "named_skill", method.kept_skill)
    if named is not None:
        return np.eye(len(method.candidates))[named]
    if type(method).draw_skill is PartialTransfer.draw_skill:
        return method.selection.probabilities()
    return None


class _Watched(BaseMethod):
    """A method that is recorded while it learns."""

    notes: Notes

    def __init__(self, method: BaseMethod) -> None:
        self.method = method
        self.library = method.library

    def __getattr__(self, name: str) -> Any:
        return getattr(self.method, name)

    def begin_task(self, start: int, goal: int) -> np.ndarray | None:
        initial_q = self.method.begin_task(start, goal)
        self.notes = Notes(informed=initial_q is not None)
        return initial_q

    def run_episode(self, learner: Learner) -> list[int] | None:
        chances = probabilities(self.method)
        if chances is not None:
            self.notes.chances.append(chances)
        if self.notes.parts:
            learner.record(0)
            return self.method.run_episode(learner)
        learner.record(MAX_RECORDED_STEPS)
        watched = _WatchedLearner(learner, self._guides())
        drawn = self.method.run_episode(watched)  # type: ignore[arg-type]  # acts as the learner
        self.notes.actions, self.notes.parts = learner.recorded, watched.parts
        return drawn

    def end_task(self, learner: Learner) -> None:
        self.method.end_task(learner)

    def _guides(self) -> list[np.ndarray]:
        if isinstance(self.method, PolicyReuse):
            return self.method.past_policies
        return [skill.policy for skill in self.library.skills] if self.library else []


class _WatchedLearner:
    """Forward every call to a learner and record which candidate guided it for how many steps."""

    def __init__(self, learner: Learner, guides: list[np.ndarray]) -> None:
        self._learner = learner
        self._guides = guides
        self.parts: list[list[int]] = []

    def __getattr__(self, name: str) -> Any:
        return getattr(self._learner, name)

    def explore(self, *arguments: Any, **options: Any) -> None:
        self._note(0, self._learner.explore, *arguments, **options)
        if options.get("budget") == 1:  # the steps between states in which a skill may lead are one part
            self._join()

    def follow(self, policy: np.ndarray, *arguments: Any, **options: Any) -> None:
        self._note(self._candidate(policy), self._learner.follow, policy, *arguments, **options)

    def reuse(self, policy: np.ndarray, *arguments: Any, **options: Any) -> None:
        self._note(self._candidate(policy), self._learner.reuse, policy, *arguments, **options)

    def act(self, action: int, **options: Any) -> int:
        after = self._learner.act(action, **options)
        self.parts.append([0, 1])
        self._join()
        return after

    def _join(self) -> None:
        """Make one part of the last two if neither has a guide."""
        if len(self.parts) > 1 and self.parts[-1][0] == self.parts[-2][0] == 0:
            self.parts[-2][1] += self.parts.pop()[1]

    def _candidate(self, policy: np.ndarray) -> int:
        return next((i for i, guide in enumerate(self._guides, 1) if guide is policy), OWN_GUIDE)

    def _note(self, candidate: int, call: Any, *arguments: Any, **options: Any) -> None:
        before = self._learner.steps
        call(*arguments, **options)
        self.parts.append([candidate, self._learner.steps - before])


def _check_equal(result: Result, stored: TaskView, again: TaskRecord) -> None:
    drawn = np.array([candidate for episode in again.selected for candidate in episode], dtype=np.int32)
    pairs = (("steps", stored.steps, again.steps), ("draws", stored.selected, drawn), ("values", stored.q, again.q))
    for name, kept, learned in pairs:
        if not np.array_equal(kept, learned):
            raise UserError(
                f"{result.path}: task {stored.name} learned again gives other {name} than the file has; {AGAIN}"
            )
