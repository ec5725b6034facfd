"""The learner in plain Python: tabular Q-learning of one task, in one file that can be read alone.

This file defines what the compiled `ptl.agent._kernel.Learner` computes. From the same random numbers both give the
same steps, paths and action values, bit for bit; the tests compare them call by call. The kernel is hundreds of times
as fast, so every published number comes from it and none from here.

*World.* States are numbered from 0, actions are 0 to 3 for north, south, west and east, and every move is
deterministic: action a in state s leads to ``successors[s][a]``, which is s itself in front of a wall.

*Task.* An episode begins at a start state and ends at the goal, or unsuccessfully after ``max_steps`` steps. The reward
is 1 for the step into the goal and 0 for all others.

*Update.* Every primitive step makes the update of one-step Q-learning (Watkins and Dayan, 1992), whoever chose the
action:

    Q(s, a) += alpha (r + gamma max_b Q(s', b) - Q(s, a)),

where the target is r alone if s' is the goal. Q is 0 at first unless values are given. Numbers are IEEE doubles, and
the order of the operations is the one written here.

*Choice.* An action is drawn at random with probability epsilon, and greedily otherwise. Actions whose values are
exactly equal tie, and ties break uniformly (our choice), or go to the first action.

*Parts of an episode.* `explore` acts epsilon-greedily, `follow` obeys a stored policy up to its subgoal (a skill of
PTL, partial transfer learning), and `reuse` is the pi-reuse of Fernandez and Veloso (2006). A method calls them one
after another until the episode ends.

*Random numbers.* See `RandomBits`, `ReferenceLearner.choose` and `ReferenceLearner.explore` for the bits that each draw
takes (our choice).

``docs/reconstruction.md`` says which values the article states, which come from a source and which are our choice.

References
----------
C. Watkins and P. Dayan: Q-learning. Machine Learning 8, 279-292 (1992).

F. Fernandez and M. Veloso: Probabilistic policy reuse in a reinforcement learning agent. AAMAS (2006).

G. Lawler: A self-avoiding random walk. Duke Mathematical Journal 47, 655-693 (1980).

Examples
--------
A corridor of four states, whose last one is the goal:

>>> corridor = [[0, 0, 0, 1], [1, 1, 0, 2], [2, 2, 1, 3], [3, 3, 2, 3]]
>>> learner = ReferenceLearner(corridor, 3, RandomBits(np.random.SFC64(1)), alpha=0.5)
>>> for _ in range(50):
...     learner.begin_episode(0)
...     learner.explore()
>>> learner.q.argmax(axis=1).tolist()
[3, 3, 3, 0]
>>> learner.erased_path().tolist()
[0, 1, 2, 3]
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

ACTIONS = range(4)
"""North, south, west, east."""

SLOTS = 12
"""Equal parts of a draw: a multiple of 1, 2, 3 and 4, so that any number of tied actions gets equal shares."""

TWO_32 = 2**32


def erase_loops(trajectory: Iterable[int]) -> list[int]:
    """Return the loop-erased trajectory: when a state is met again, all since its first visit is dropped (Lawler)."""
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


class RandomBits:
    """The random numbers of a learner: the 64-bit words of a bit generator in order, whole or in halves.

    Parameters
    ----------
    bit_generator : numpy.random.BitGenerator
    """

    def __init__(self, bit_generator: np.random.BitGenerator) -> None:
        self._bit_generator = bit_generator
        self._high_half: int | None = None

    def word(self) -> int:
        """Return the next whole word, 0 to 2**64 - 1. A half that is left over stays for the next call of `half`."""
        return int(self._bit_generator.random_raw())

    def half(self) -> int:
        """Return the next half, 0 to 2**32 - 1: the low half of a word, then its high half."""
        if self._high_half is not None:
            half, self._high_half = self._high_half, None
            return half
        self._high_half, low_half = divmod(self.word(), TWO_32)
        return low_half


class ReferenceLearner:
    """Learns one task in one world, episode by episode.

    Parameters
    ----------
    successors : int array, shape (n_states, 4)
        State after a step in each direction.
    goal : int
        State at which an episode ends with reward 1.
    random : RandomBits
        Source of all randomness.
    alpha, gamma : float
        Learning rate, and discount per step.
    epsilon : float
        Probability of a uniformly random action in `explore`.
    max_steps : int
        Steps after which an episode is truncated.
    initial_q : float array, shape (n_states, 4), optional
        Values to start from instead of 0.
    shortcut : bool
        Whether `explore` draws the actions of two steps together where no value is known. The distribution of
        episodes is the same without; the random numbers are not. It is never done if ties go to the first action.
    ties : {"random", "first"}
        Which of equal greedy actions is taken: any, or the first.
    slip : float
        Probability that the direction of a step is drawn uniformly from the four, whatever the action.

    Attributes
    ----------
    trajectory : list of int
        All states of the present episode, the start first.
    directions : list of int
        Direction of every step of the present episode: that of the action, unless the step slipped.
    """

    def __init__(
        self,
        successors: np.ndarray | Sequence[Sequence[int]],
        goal: int,
        random: RandomBits,
        *,
        alpha: float = 0.05,
        gamma: float = 0.95,
        epsilon: float = 0.1,
        max_steps: int = 10**7,
        initial_q: np.ndarray | None = None,
        shortcut: bool = True,
        ties: str = "random",
        slip: float = 0.0,
    ) -> None:
        self._successors = [[int(after) for after in row] for row in successors]
        self._goal = int(goal)
        self._random = random
        self._alpha = alpha
        self._gamma = gamma
        self._epsilon = epsilon
        self._max_steps = max_steps
        self._slip = slip
        self._first_of_ties = ties == "first"
        self._shortcut = shortcut and not self._first_of_ties
        n_states = len(self._successors)
        values = np.zeros((n_states, 4)) if initial_q is None else np.asarray(initial_q, dtype=np.float64)
        self._q: list[list[float]] = values.tolist()
        self._informed = [any(row) for row in self._q]
        self._seen = [0] * n_states
        self._within_two = [self._states_within_two_steps(state) for state in range(n_states)]
        self.trajectory: list[int] = []
        self.directions: list[int] = []

    # -- state of the learner

    @property
    def state(self) -> int:
        """State of the agent."""
        return self.trajectory[-1]

    @property
    def steps(self) -> int:
        """Primitive steps of this episode so far."""
        return len(self.directions)

    @property
    def at_goal(self) -> bool:
        """Whether the episode has ended at the goal."""
        return self.state == self._goal

    @property
    def truncated(self) -> bool:
        """Whether the episode has reached its step limit before the goal."""
        return self.steps >= self._max_steps and not self.at_goal

    @property
    def q(self) -> np.ndarray:
        """Action values, float64 array (n_states, 4)."""
        return np.array(self._q, dtype=np.float64)

    @property
    def seen(self) -> np.ndarray:
        """Directions of the steps of this task, uint8 array (n_states,), bit d set if one led in direction d.

        So these are the transitions that the agent has seen. Without slip they are the actions taken.
        """
        return np.array(self._seen, dtype=np.uint8)

    @property
    def transitions(self) -> np.ndarray:
        """Transitions seen in this task: the state after a step in each direction, int32 (n_states, 4), or -1."""
        rows = zip(self._successors, self._seen, strict=True)
        table = [[after if seen >> action & 1 else -1 for action, after in enumerate(row)] for row, seen in rows]
        return np.array(table, dtype=np.int32)

    def values_of(self, state: int) -> tuple[float, ...]:
        """Return the four action values of a state."""
        return tuple(self._q[state])

    def erased_path(self) -> np.ndarray:
        """Return the loop-erased path of this episode from its start to the present state, int32 array (l + 1,)."""
        return np.array(erase_loops(self.trajectory), dtype=np.int32)

    # -- one step

    def act(self, action: int, learn: bool = True) -> int:
        """Take one action, make the update of Q-learning for it, and return the state that the step leads to.

        In a world that slips a half word u decides on the direction of the step: 4 u is a direction (its high 32 bits)
        and a fraction (its low 32 bits), and the step goes in that direction if the fraction is below the slip, and in
        that of the action otherwise. The update is that of the action, whatever the direction.

        Parameters
        ----------
        action : int
            0 to 3.
        learn : bool
            Whether Q is updated; a method with its own update takes its steps without.
        """
        direction = action
        if self._slip > 0:
            drawn, fraction = divmod(4 * self._random.half(), TWO_32)
            if fraction < _threshold(self._slip):
                direction = drawn
        return self._step(action, direction, learn)

    def _step(self, action: int, direction: int, learn: bool = True) -> int:
        """Step in a direction after an action was chosen."""
        state = self.state
        after = self._successors[state][direction]
        if learn:
            self.update(state, action, 1.0 if after == self._goal else self._gamma * max(self._q[after]))
        self._seen[state] |= 1 << direction
        self.directions.append(direction)
        self.trajectory.append(after)
        return after

    def update(self, state: int, action: int, target: float) -> None:
        """Move an action value towards a target, Q(s, a) += alpha (target - Q(s, a))."""
        value = self._q[state][action]
        self.set_value(state, action, value + self._alpha * (target - value))

    def set_value(self, state: int, action: int, value: float) -> None:
        """Set an action value."""
        self._q[state][action] = value
        if value != 0.0:
            self._informed[state] = True

    def set_q(self, q: np.ndarray) -> None:
        """Set all action values, float array (n_states, 4)."""
        for state, row in enumerate(q.tolist()):
            for action, value in enumerate(row):
                self.set_value(state, action, value)

    def choose(
        self,
        epsilon: float | None = None,
        *,
        bonus: Sequence[float] | np.ndarray | None = None,
        mask: Sequence[bool] | np.ndarray | None = None,
    ) -> int:
        """Return an epsilon-greedy action of the present state without taking it.

        A half word u makes the whole draw. The product 12 u is one of 12 slots (its high 32 bits) and a fraction (its
        low 32 bits). The action is random if the fraction is below epsilon, and greedy otherwise; the slot says which
        of the random or of the tied greedy actions it is.

        Parameters
        ----------
        epsilon : float, optional
            Probability of a random action, instead of the learner's.
        bonus : float array, shape (4,), optional
            Added to Q for the choice of the greedy action; Q stays as it is.
        mask : bool array, shape (4,), optional
            Allowed actions, at least one; greedy and random actions are drawn among them.
        """
        slot, fraction = divmod(SLOTS * self._random.half(), TWO_32)
        allowed = [action for action in ACTIONS if mask is None or mask[action]]
        if fraction < _threshold(self._epsilon if epsilon is None else epsilon):
            return slot % 4 if len(allowed) == 4 else allowed[slot * len(allowed) // SLOTS]
        worth = self._q[self.state]
        if bonus is not None:
            worth = [value + added for value, added in zip(worth, bonus, strict=True)]
        best = max(worth[action] for action in allowed)
        greedy = [action for action in allowed if worth[action] == best]
        return greedy[0 if self._first_of_ties else slot * len(greedy) // SLOTS]

    # -- parts of an episode

    def begin_episode(self, start: int) -> None:
        """Put the agent on a state and its step count to zero."""
        self.trajectory = [int(start)]
        self.directions = []

    def explore(
        self,
        budget: int | None = None,
        epsilon: float | None = None,
        *,
        bonus: np.ndarray | None = None,
        mask: np.ndarray | None = None,
    ) -> None:
        """Act epsilon-greedily until the goal, the episode's step limit, or ``budget`` steps from here.

        Where nothing is known within two steps all actions tie, so the next two actions are uniform and independent
        whatever epsilon is. There, without a bonus or a mask, and if two steps or more are left, one whole word makes
        up to 16 pairs of steps of two bits each, the lowest bits first, as long as these conditions hold. Elsewhere
        `choose` draws the action of each step. The bits of a pair are directions: that of a uniform action is uniform,
        whether the step slips or not, and the update leaves Q as it is, whatever the action.

        Parameters
        ----------
        budget : int, optional
        epsilon : float, optional
            Probability of a random action, instead of the learner's.
        bonus : float array, shape (n_states, 4), optional
        mask : bool array, shape (n_states, 4), optional
            As in `choose`, for each state.
        """
        end = self._last_step(budget)
        biased = bonus is not None or mask is not None
        while self.steps < end and not self.at_goal:
            if not biased and self._takes_pairs(end):
                word = self._random.word()
                for _ in range(16):
                    for _ in range(2):
                        self._step(word % 4, word % 4)
                        word //= 4
                    if not self._takes_pairs(end):
                        break
            else:
                here = self.state
                added, allowed = (None if table is None else table[here] for table in (bonus, mask))
                self.act(self.choose(epsilon, bonus=added, mask=allowed))

    def follow(self, policy: Sequence[int] | np.ndarray, subgoal: int | None = None, budget: int | None = None) -> None:
        """Follow a policy until its subgoal, a state where it is undefined, or an end as in `explore`.

        Parameters
        ----------
        policy : int array, shape (n_states,)
            Action of each state, -1 where undefined.
        subgoal : int, optional
        budget : int, optional
        """
        end = self._last_step(budget)
        while self.steps < end and not self.at_goal and self.state != subgoal and policy[self.state] >= 0:
            self.act(int(policy[self.state]))

    def reuse(
        self, policy: Sequence[int] | np.ndarray, psi: float = 1.0, decay: float = 0.95, subgoal: int | None = None
    ) -> None:
        """Reuse a past policy until the goal or the episode's step limit: pi-reuse (Fernandez and Veloso).

        In step h the past policy acts with probability psi_h. Otherwise, and where it is undefined (our choice), the
        new policy does, at random with probability psi_h and greedily with 1 - psi_h. One half word decides between
        the policies; `choose` draws another one. Once psi_h is below 2**-32, the resolution of a draw, the rest of the
        episode is greedy (our choice).

        Parameters
        ----------
        policy : int array, shape (n_states,)
            Action of the past policy in each state, -1 where undefined.
        psi, decay : float
            psi_1, and the factor from psi_h to psi_{h+1}.
        subgoal : int, optional
            State at which reuse ends; it then also ends when psi_h is below that resolution.
        """
        while _threshold(psi) > 0:
            if self.steps >= self._max_steps or self.at_goal or self.state == subgoal:
                return
            past_action = int(policy[self.state])
            if self._random.half() < _threshold(psi) and past_action >= 0:
                self.act(past_action)
            else:
                self.act(self.choose(psi))
            psi *= decay
        if subgoal is None:
            self.explore(epsilon=0.0)

    def _last_step(self, budget: int | None) -> int:
        """Return the number of steps at which a part of the episode ends."""
        return self._max_steps if budget is None else min(self._max_steps, self.steps + budget)

    # -- where nothing is known

    def _takes_pairs(self, end: int) -> bool:
        """Return whether the next two actions are drawn together.

        So they are if no state within two steps is the goal or has had a value other than 0 in this task. (A value can
        fall back to 0; the state stays informed.)
        """
        if not self._shortcut or end - self.steps < 2:
            return False
        return not any(near == self._goal or self._informed[near] for near in self._within_two[self.state])

    def _states_within_two_steps(self, state: int) -> set[int]:
        one_step = self._successors[state]
        return {state, *one_step, *(after for near in one_step for after in self._successors[near])}


def _threshold(probability: float) -> int:
    """Return the number of half words out of 2**32 that represent a probability."""
    return int(probability * TWO_32)
