"""Plain-Python Q-learner: the yardstick of the compiled kernel.

It draws the same random numbers as ``ptl.agent._kernel.Learner`` and must give the same Q bit for bit, but takes no
short cuts: every step is simulated with the full update, the whole trajectory is stored, and loops are erased
from the stored trajectory by their definition. Nothing here is shared with the kernel.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

WORD_HALF = 1 << 32
LOW_HALF = WORD_HALF - 1


def erase_loops(trajectory: Iterable[int]) -> list[int]:
    """Loop-erased trajectory: on meeting a state again, drop everything since its first visit."""
    path: list[int] = []
    position: dict[int, int] = {}
    for state in trajectory:
        if state in position:
            for dropped in path[position[state] + 1 :]:
                del position[dropped]
            del path[position[state] + 1 :]
        else:
            position[state] = len(path)
            path.append(state)
    return path


class ReferenceLearner:
    """Tabular one-step Q-learning of one task, with the public surface of ``ptl.agent._kernel.Learner``.

    ``successors`` is the (n, 4) table of next states; ``bit_generator`` a numpy bit generator.
    ``shortcut=False`` makes every exploring step an ordinary epsilon-greedy one: other draws, the same law.
    ``trajectory`` holds all states of the present episode, the start included.
    """

    def __init__(
        self,
        successors: np.ndarray | Sequence[Sequence[int]],
        goal: int,
        bit_generator: np.random.BitGenerator,
        alpha: float = 0.05,
        gamma: float = 0.95,
        epsilon: float = 0.1,
        max_steps: int = 10**7,
        initial_q: np.ndarray | None = None,
        shortcut: bool = True,
    ) -> None:
        self._successors = [[int(after) for after in row] for row in successors]
        self._goal = int(goal)
        self._bit_generator = bit_generator
        self._spare_half: int | None = None
        self._alpha = alpha
        self._gamma = gamma
        self._epsilon = epsilon
        self._max_steps = max_steps
        self._shortcut = shortcut
        n_states = len(self._successors)
        if initial_q is None:
            self._q = [[0.0] * 4 for _ in range(n_states)]
        else:
            self._q = np.asarray(initial_q, dtype=np.float64).tolist()
        self._informed = [any(row) for row in self._q]
        self._seen = [0] * n_states
        self._within_two = [self._states_within_two_steps(state) for state in range(n_states)]
        self.trajectory: list[int] = []

    # -- what can be asked

    @property
    def state(self) -> int:
        """State of the agent."""
        return self.trajectory[-1]

    @property
    def steps(self) -> int:
        """Primitive steps of this episode so far."""
        return len(self.trajectory) - 1

    @property
    def at_goal(self) -> bool:
        """Whether the episode has ended at the goal."""
        return self.state == self._goal

    @property
    def truncated(self) -> bool:
        """Whether the episode has run into its step limit before the goal."""
        return self.steps >= self._max_steps and not self.at_goal

    @property
    def q(self) -> np.ndarray:
        """Action values, float64 array (n_states, 4)."""
        return np.array(self._q, dtype=np.float64)

    @property
    def seen(self) -> np.ndarray:
        """Actions taken in this task, uint8 array (n_states,), bit a set for action a."""
        return np.array(self._seen, dtype=np.uint8)

    def erased_path(self) -> np.ndarray:
        """Loop-erased path of this episode, int32 array (l + 1,)."""
        return np.array(erase_loops(self.trajectory), dtype=np.int32)

    # -- what can be done

    def begin_episode(self, start: int) -> None:
        """Put the agent on a state and its step count to zero."""
        self.trajectory = [int(start)]

    def explore(
        self,
        budget: int | None = None,
        epsilon: float | None = None,
        bonus: np.ndarray | None = None,
        mask: np.ndarray | None = None,
    ) -> None:
        """Act epsilon-greedily until the goal, ``budget`` primitive steps or the episode's ``max_steps``.

        With a bonus (n, 4), greedily over Q + bonus; with a mask (n, 4), among the allowed actions.
        """
        left = self._max_steps - self.steps
        if budget is not None:
            left = min(left, budget)
        threshold = int((self._epsilon if epsilon is None else epsilon) * WORD_HALF)
        biased = bonus is not None or mask is not None
        while left > 0 and not self.at_goal:
            if biased:
                here = self.state
                added = None if bonus is None else bonus[here]
                self._step(self.choose(epsilon, added, None if mask is None else mask[here]))
                left -= 1
            elif self._shortcut and left >= 2 and self._is_cold(self.state):
                word = self._bit_generator.random_raw()
                for _ in range(16):
                    self._step(word & 3)
                    self._step(word >> 2 & 3)
                    word >>= 4
                    left -= 2
                    if left < 2 or not self._is_cold(self.state):
                        break
            else:
                self._epsilon_greedy_step(threshold)
                left -= 1

    def choose(
        self,
        epsilon: float | None = None,
        bonus: Sequence[float] | None = None,
        mask: Sequence[bool] | None = None,
    ) -> int:
        """Draw an epsilon-greedy action of the present state, over Q + bonus and among the allowed actions."""
        allowed = [action for action in range(4) if mask is None or mask[action]]
        slot, fraction = divmod(self._draw32() * 12, WORD_HALF)
        if fraction < int((self._epsilon if epsilon is None else epsilon) * WORD_HALF):
            return slot & 3 if len(allowed) == 4 else allowed[slot * len(allowed) // 12]
        worth = [value + (0.0 if bonus is None else bonus[action]) for action, value in enumerate(self._q[self.state])]
        greedy = [action for action in allowed if worth[action] == max(worth[other] for other in allowed)]
        return greedy[slot * len(greedy) // 12]

    def act(self, action: int, learn: bool = True) -> int:
        """Take one action and return the state that it leads to."""
        self._step(action, learn)
        return self.state

    def update(self, state: int, action: int, target: float) -> None:
        """Move an action value towards a target."""
        self.set_value(state, action, self._q[state][action] + self._alpha * (target - self._q[state][action]))

    def set_value(self, state: int, action: int, value: float) -> None:
        """Set an action value."""
        self._q[state][action] = value
        if value != 0.0:
            self._informed[state] = True

    def set_q(self, q: np.ndarray) -> None:
        """Set all action values."""
        for state, row in enumerate(q.tolist()):
            for action, value in enumerate(row):
                self.set_value(state, action, value)

    def values_of(self, state: int) -> tuple[float, ...]:
        """Return the four action values of a state."""
        return tuple(self._q[state])

    def follow(self, policy: Sequence[int], subgoal: int | None = None, budget: int | None = None) -> None:
        """Follow ``policy`` until the subgoal, an undefined state (-1), the goal, ``budget`` steps or ``max_steps``."""
        end = self._max_steps if budget is None else min(self._max_steps, self.steps + budget)
        while self.steps < end and not self.at_goal and self.state != subgoal:
            action = int(policy[self.state])
            if action < 0:
                break
            self._step(action)

    def reuse(self, policy: Sequence[int], psi: float, decay: float, subgoal: int | None = None) -> None:
        """pi-reuse (Fernandez and Veloso) of ``policy`` until the goal or ``max_steps``.

        With a subgoal until this or until psi has vanished.
        """
        threshold = int(psi * WORD_HALF)
        while threshold > 0:
            if self.steps >= self._max_steps or self.at_goal or self.state == subgoal:
                return
            draw = self._draw32()
            past_action = int(policy[self.state])
            if draw < threshold and past_action >= 0:
                self._step(past_action)
            else:
                self._epsilon_greedy_step(threshold)
            psi *= decay
            threshold = int(psi * WORD_HALF)
        if subgoal is None:
            self.explore(epsilon=0.0)

    # -- one step

    def _step(self, action: int, learn: bool = True) -> None:
        state = self.trajectory[-1]
        after = self._successors[state][action]
        if learn:
            target = 1.0 if after == self._goal else self._gamma * max(self._q[after])
            row = self._q[state]
            row[action] += self._alpha * (target - row[action])
            if row[action] != 0.0:
                self._informed[state] = True
        self._seen[state] |= 1 << action
        self.trajectory.append(after)

    def _epsilon_greedy_step(self, threshold: int) -> None:
        slot, fraction = divmod(self._draw32() * 12, WORD_HALF)
        if fraction < threshold:
            action = slot & 3
        else:
            row = self._q[self.trajectory[-1]]
            best = max(row)
            greedy = [action for action in range(4) if row[action] == best]
            action = greedy[slot * len(greedy) // 12]
        self._step(action)

    def _draw32(self) -> int:
        if self._spare_half is not None:
            half, self._spare_half = self._spare_half, None
            return half
        word = self._bit_generator.random_raw()
        self._spare_half = word >> 32
        return word & LOW_HALF

    # -- where nothing is known yet

    def _states_within_two_steps(self, state: int) -> list[int]:
        one_step = self._successors[state]
        return [state, *{after for near in one_step for after in (near, *self._successors[near])} - {state}]

    def _is_cold(self, state: int) -> bool:
        """Whether no state within two steps is the goal or has ever had a Q other than 0 in this task.

        (Q can fall back to exactly 0 if alpha is high and Q was given; the state stays informed.)
        """
        return not any(near == self._goal or self._informed[near] for near in self._within_two[state])
