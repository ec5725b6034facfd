"""How likely each skill or arm was as the episodes passed.

A learning file holds what was drawn in each episode and how long the episode was. That determines the
probabilities, so the method's own code is run again on the stored episodes; there is no second version of it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ptl import methods
from ptl.errors import UserError
from ptl.methods._base import BaseMethod
from ptl.methods.policy_reuse import Method as PolicyReuse
from ptl.methods.ptl import Method as PartialTransfer
from ptl.parameters import Parameters
from ptl.store import LearningFile, TaskView


@dataclass(frozen=True)
class Choices:
    """What a method chose from in one task.

    Attributes
    ----------
    probabilities : float array, shape (episodes, candidates), or None
        Probability of each candidate at the beginning of the episode; None if the method draws by a rule of
        its own.
    initial_q : float array, shape (n_states, 4), or None
        Action values that the task started from, None for zero.
    """

    probabilities: np.ndarray | None
    initial_q: np.ndarray | None


class _StoredEpisode:
    """Stands in for the learner: every call returns at once, and the last stored draw reaches the end."""

    def __init__(self, drawn: list[int], steps: int, truncated: bool) -> None:
        self._waiting = list(drawn)
        self.steps = steps
        self._truncated = truncated

    def next_draw(self) -> int:
        return self._waiting.pop(0)

    @property
    def at_goal(self) -> bool:
        return not self._waiting and not self._truncated

    @property
    def truncated(self) -> bool:
        return not self._waiting and self._truncated

    def explore(self, budget: int | None = None, epsilon: float | None = None) -> None:
        """Nothing: the outcome is stored."""

    def follow(self, policy: np.ndarray, subgoal: int) -> None:
        """Nothing: the outcome is stored."""

    def reuse(self, policy: np.ndarray, psi: float, decay: float) -> None:
        """Nothing: the outcome is stored."""


def replay(file: LearningFile) -> Iterator[Choices]:
    """Run the method's bookkeeping over the stored episodes, task by task.

    Raises
    ------
    UserError
        If the file's draws are not such as its method makes.
    """
    kind = methods.load(file.method)
    method = _with_stored_draws(kind)(file.world, Parameters.from_dict(file.parameters), np.random.default_rng(0))
    for index, task in enumerate(file.tasks.values()):
        if method.library is not None:
            method.library.skills = [skill for skill in file.library or [] if skill.learned_after < index]
        initial_q = method.begin_task(task.start, task.goal)
        probabilities = _replay_task(file, task, method, kind)
        method.end_task(task.q)
        yield Choices(probabilities, initial_q)


def _with_stored_draws(kind: type[BaseMethod]) -> type[BaseMethod]:
    class Stored(kind):  # type: ignore[valid-type,misc]
        """The method; within an episode it draws what was drawn."""

        episode: Any = None

        def draw_skill(self) -> int:
            return self.episode.next_draw()

        def arm_probabilities(self) -> np.ndarray:
            chances = super().arm_probabilities()
            return chances if self.episode is None else np.eye(len(chances))[self.episode.next_draw()]

    return Stored


def _replay_task(file: LearningFile, task: TaskView, method: BaseMethod, kind: type[BaseMethod]) -> np.ndarray | None:
    history = []
    offsets, selected = task.selected_offsets, task.selected
    for number, (steps, truncated) in enumerate(zip(task.steps, task.truncated, strict=True)):
        now = probabilities(method, kind)
        if now is None:
            return None
        history.append(now)
        drawn = selected[offsets[number] : offsets[number + 1]].tolist()
        possible = drawn and min(drawn) >= 0 and max(drawn) < len(now)
        if not possible or _run(method, _StoredEpisode(drawn, int(steps), bool(truncated))) != drawn:
            raise UserError(
                f"{file.file.filename}: task {task.name}, episode {number + 1} holds the draws {drawn} of"
                f" {len(now)} candidates, which {file.method} does not make; make the file again"
            )
    return np.array(history)


def _run(method: Any, episode: _StoredEpisode) -> list[int]:
    method.episode = episode
    drawn = method.run_episode(episode)
    method.episode = None
    return drawn


def probabilities(method: BaseMethod, kind: type[BaseMethod]) -> np.ndarray | None:
    """Probability of each candidate in the next episode, None if there is none or the rule is not known."""
    if isinstance(method, PolicyReuse):
        return method.arm_probabilities()
    if not isinstance(method, PartialTransfer):
        return None
    if hasattr(method, "named_skill"):
        return np.eye(len(method.candidates))[method.named_skill]
    if kind.draw_skill is PartialTransfer.draw_skill:  # type: ignore[attr-defined]
        return method.selection.probabilities()
    return None
