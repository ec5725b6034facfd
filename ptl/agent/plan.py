"""A plan: one episode of a method, described instead of programmed.

The loop over episodes is `ptl.agent._episodes.run_episodes`. It is the compiled form of `Plan.run`:
the same calls of the learner, the same random numbers, the same results (tests compare them).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np

if TYPE_CHECKING:
    from ptl.agent._kernel import Learner

MAX_PATIENCE = 1e18
"""Maximum patience in steps, more than any episode takes; a patience that grows further is cut to it."""


class Leader(Protocol):
    """What leads an agent: a stored policy. `Guide` and `ptl.agent.skills.Skill` are two of them."""

    @property
    def policy(self) -> np.ndarray:
        """Action of each state, int8 (n_states,), -1 where undefined; it must never change."""

    @property
    def subgoal(self) -> int | None:
        """State at which the lead ends, if it does."""

    @property
    def initiation(self) -> np.ndarray | None:
        """Initiation set, bool (n_states,): states in which it leads again."""


@dataclass(frozen=True)
class Guide:
    """A stored policy that leads the agent, see `Leader`."""

    policy: np.ndarray = field(repr=False)
    subgoal: int | None = None
    initiation: np.ndarray | None = field(default=None, repr=False)


class Mixing(NamedTuple):
    """A policy mixed into the agent's own by pi-reuse, see `Learner.reuse`.

    Without a subgoal it lasts to the end of the episode, as Fernandez and Veloso have it.
    """

    psi: float
    decay: float


@dataclass(frozen=True)
class Plan:
    """One episode: draw a candidate, let its guide lead, explore; draw again when patience runs out.

    Without an argument: explore until the goal.

    Parameters
    ----------
    draw : function
        Returns the number of the candidate to use next, 0 to 2**31 - 1. Without it nothing is drawn.
    guide : function
        Returns what leads when a candidate has been drawn, None for nothing.
    note : function
        Told of each episode the candidates drawn, its length in steps and whether it reached the goal.
    mixing : Mixing, optional
        Mixes a guide's policy into the agent's own. Without it the policy is followed to its subgoal, to a state
        where it is undefined, or for as many steps as there are states: a policy whose way is now closed would never
        end (our choice).
    epsilon : float, optional
        Of exploring, instead of the learner's.
    patience : float, optional
        Steps of exploring, rounded and at least 1, before a candidate is drawn again; without it, to the end.
    growth : float
        Factor on the patience at every further draw, at least 1.

    A guide with an initiation set also leads wherever exploring comes to a state of the set in which all action values
    are equal, so that nothing is known there yet, each state once an episode; when patience runs out, the agent
    explores as many steps again without it (our choice: the goal may be where the guide never leads).
    """

    draw: Callable[[], int] | None = None
    guide: Callable[[int], Leader | None] | None = None
    note: Callable[[list[int], int, bool], object] | None = None
    mixing: Mixing | None = None
    epsilon: float | None = None
    patience: float | None = None
    growth: float = 1.0

    def __post_init__(self) -> None:
        if self.patience is not None and not self.patience > 0:
            raise ValueError(f"the patience of a plan must be above 0, not {self.patience}")
        if not self.growth >= 1:
            raise ValueError(f"the growth of a plan must be at least 1, not {self.growth}")

    def run(self, learner: Learner) -> list[int]:
        """Run an episode that has begun by the learner's own calls; return the candidates drawn in order."""
        drawn: list[int] = []
        led: set[int] = set()
        patience = self.patience
        while True:
            guide = None
            if self.draw is not None:
                drawn.append(self.draw())
                guide = None if self.guide is None else self.guide(drawn[-1])
            budget = None if patience is None else max(1, round(min(patience, MAX_PATIENCE)))
            if guide is not None:
                self._lead(learner, guide)
                if guide.initiation is not None:
                    self._explore_led(learner, guide, budget, led)
            learner.explore(budget=budget, epsilon=self.epsilon)
            if learner.at_goal or learner.truncated:
                break
            if patience is not None:
                patience *= self.growth
        if self.note is not None:
            self.note(drawn, learner.steps, learner.at_goal)
        return drawn

    def _lead(self, learner: Learner, guide: Leader) -> None:
        if self.mixing is not None:
            learner.reuse(guide.policy, *self.mixing, **({} if guide.subgoal is None else {"subgoal": guide.subgoal}))
        else:
            learner.follow(guide.policy, guide.subgoal, budget=len(guide.policy))

    def _explore_led(self, learner: Learner, guide: Leader, budget: int | None, led: set[int]) -> None:
        """Explore, led again from each state of the initiation set that is not in ``led`` and knows nothing."""
        assert guide.initiation is not None
        left = budget
        while not (learner.at_goal or learner.truncated):
            state = learner.state
            if guide.initiation[state] and state not in led and len(set(learner.values_of(state))) == 1:
                led.add(state)
                self._lead(learner, guide)
                continue
            if left == 0:
                return
            learner.explore(budget=1, epsilon=self.epsilon)
            left = None if left is None else left - 1
