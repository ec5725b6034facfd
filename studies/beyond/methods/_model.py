"""A model of the world that counts what actions led to."""

from __future__ import annotations

import numpy as np

from ptl.world.transitions import TransitionGraph

N_ACTIONS = 4
UNTRIED = -1
TOLERANCE = 1e-3
"""Relative change of the values at which value iteration ends."""


class Pair:
    """A state and an action: how often it was tried, and what it led to.

    Attributes
    ----------
    tries : int
    usual : int
        Most frequent state after it, the first of several; `UNTRIED` before it is tried.
    outcomes : dict of int to int
        Tries that led to each state.
    odd, row : int
        Last state after it that was not the usual one, and how many of the last tries led there one after another.
    used : int
        Tries at the last change of the model that was due to this pair.
    """

    __slots__ = ("odd", "outcomes", "row", "tries", "used", "usual")

    def __init__(self) -> None:
        self.tries = self.row = self.used = 0
        self.usual = self.odd = UNTRIED
        self.outcomes: dict[int, int] = {}


class Model:
    """Counts of transitions; a pair of state and action is known after some visits, and its counts go on.

    Parameters
    ----------
    n_states : int
    visits : int
        m, tries after which a pair is known; `doubt` may double it.
    forgets : bool
        Whether a known pair forgets what has become false: once m tries one after another have led to the same state,
        another than the usual one, they replace its counts. With m = 1 the last try alone counts.

    Attributes
    ----------
    pairs : list of lists of Pair
    doubted : bool
        Whether the next `doubt` is a second one.
    edges : int
        Grows with every change of a known pair's usual state.
    changes : int
        Grows with every change that matters to plans: those of ``edges``, and twice as many tries of a pair with
        several outcomes (as Jaksch, Ortner and Auer, JMLR 11, 2010, plan again).
    """

    def __init__(self, n_states: int, visits: int = 1, forgets: bool = False) -> None:
        self.visits, self.forgets = visits, forgets
        self.pairs = [[Pair() for _ in range(N_ACTIONS)] for _ in range(n_states)]
        self.doubted = False
        self.edges = self.changes = 0
        self._usual = np.zeros((n_states, N_ACTIONS), dtype=np.int32)
        self._known = np.zeros(n_states, dtype=np.uint8)
        # outcomes of the known pairs and their shares, (outcomes, actions, states): sums over the first axes are fast;
        # those of a pair are written again when a plan is wanted
        self._after = np.zeros((1, N_ACTIONS, n_states), dtype=np.int64)
        self._share = np.zeros((1, N_ACTIONS, n_states))
        self._changed: set[tuple[int, int]] = set()
        self._uncertain: set[tuple[int, int]] = set()
        self._goal, self._values = -1, np.zeros(n_states)

    def note(self, state: int, action: int, after: int) -> None:
        """Record the state that an action led to."""
        pair = self.pairs[state][action]
        outcomes, before = pair.outcomes, pair.usual
        pair.tries += 1
        if after == before:
            outcomes[after] += 1
            pair.row = 0
            if pair.tries > self.visits and len(outcomes) == 1:
                return  # by far the most frequent case
        else:
            outcomes[after] = outcomes.get(after, 0) + 1
            self._note_odd(pair, after)
        if pair.tries == self.visits or (pair.usual != before and pair.tries > self.visits):
            self._usual[state, action] = pair.usual
            self._known[state] |= 1 << action
            self.edges += 1
            self._change(state, action, pair)
        elif len(pair.outcomes) > 1 and pair.tries >= 2 * pair.used and pair.tries > self.visits:
            self._change(state, action, pair)

    def _note_odd(self, pair: Pair, after: int) -> None:
        pair.row = pair.row + 1 if after == pair.odd else 1
        pair.odd = after
        if self.forgets and pair.row >= self.visits and pair.tries - pair.row >= self.visits:
            pair.outcomes = {after: pair.row}
            # at least one more than m, so that the pair does not count as known for the first time again
            pair.tries = max(pair.row, self.visits + 1)
            pair.usual, pair.row, pair.used = after, 0, 0
        else:
            pair.usual = max(pair.outcomes, key=pair.outcomes.__getitem__)

    def _change(self, state: int, action: int, pair: Pair) -> None:
        self.changes += 1
        pair.used = pair.tries
        self._changed.add((state, action))

    def doubt(self) -> None:
        """Believe less: what left the agent where it was is to be tried once more; the second time m doubles.

        For when neither the goal nor anything unknown can be reached, so that a wall has opened, or an uncertain move
        has been believed too early.
        """
        if self.doubted:
            self.visits *= 2
        for state, action in np.argwhere(~self.unknown).tolist():
            pair = self.pairs[state][action]
            if not self.doubted and pair.usual == state:
                pair.tries, pair.row, pair.used, pair.usual, pair.outcomes = self.visits - 1, 0, 0, UNTRIED, {}
            if pair.tries < self.visits:
                self._known[state] &= ~np.uint8(1 << action)
                self._share[:, action, state] = 0.0
                self._changed.discard((state, action))
                self._uncertain.discard((state, action))
        self.doubted = not self.doubted
        self.edges += 1
        self.changes += 1

    @property
    def unknown(self) -> np.ndarray:
        """Which pairs have not been tried often enough, bool (n_states, 4)."""
        return (self._known[:, None] >> np.arange(N_ACTIONS) & 1) == 0

    # -- plans --------------------------------------------------------------------------------------------------

    def steps_from(self, origin: int) -> np.ndarray:
        """Return the steps to every state over known pairs, int32 (n_states,), -1 if no path leads.

        In this and all other paths each pair leads to its usual state.
        """
        return self._graph().steps_from([origin])

    def way_to(self, origin: int, target: int) -> list[int]:
        """Return the actions of a shortest path over known pairs; the path must exist."""
        policy, way = self.route_to(target), []
        while origin != target:
            way.append(int(policy[origin]))
            origin = int(self._usual[origin, way[-1]])
        return way

    def route_to(self, goal: int) -> np.ndarray:
        """Return the first action of a shortest path over known pairs, int8 (n_states,), -1 at the goal or if none."""
        return self._graph().shortest_path_policy(goal)

    def policy_to(self, goal: int, gamma: float) -> np.ndarray:
        """Return the best actions for reaching a goal over known pairs, int8 (n_states,), -1 at the goal or if none.

        By value iteration with the shares of the outcomes, from the values of shortest paths or of the last plan for
        the same goal; where no known pair has more than one outcome, shortest paths are the result already. There is an
        action where the usual outcomes lead to the goal: a rare one may never come again.
        """
        self._write_shares()
        if not self._uncertain:
            return self.route_to(goal)
        if goal != self._goal:
            self._goal, self._values = goal, np.zeros_like(self._values)
        steps = self._graph().steps_to(goal)
        start = np.where(self._values > 0, self._values, gamma ** np.maximum(steps - 1.0, 0.0))
        # a value that no path supports would fade for thousands of sweeps
        values, before = np.where(steps > 0, start, 0.0), np.full(len(start), np.inf)
        while (np.abs(values - before) > TOLERANCE * values).any():
            ahead = gamma * values
            ahead[goal] = 1.0
            of_actions = (self._share * ahead[self._after]).sum(axis=0)
            before, values = values, of_actions.max(axis=0)
            values[goal] = 0.0
        self._values = values
        return np.where(steps > 0, of_actions.argmax(axis=0), -1).astype(np.int8)

    def way_to_unknown(self, origin: int, random: np.random.Generator) -> list[int] | None:
        """Return the actions of a shortest path to a state with a pair that is not known, and that pair's action.

        Ties of states at the same distance and of actions in a state are broken uniformly at random. None if all pairs
        of all reachable states are known.
        """
        before: dict[int, tuple[int, int]] = {}
        layer = [origin]
        while layer:
            unknown = [(s, a) for s in layer for a, pair in enumerate(self.pairs[s]) if pair.tries < self.visits]
            if unknown:
                state, action = unknown[int(random.random() * len(unknown))]
                return [*self._actions(origin, state, before), action]
            layer = self._next_layer(layer, before, origin)
        return None

    def _graph(self) -> TransitionGraph:
        return TransitionGraph(self._usual, self._known)

    def _write_shares(self) -> None:
        for state, action in self._changed:
            pair = self.pairs[state][action]
            number = len(pair.outcomes)
            if number > len(self._after):
                more = [(0, number - len(self._after)), (0, 0), (0, 0)]
                self._after, self._share = np.pad(self._after, more), np.pad(self._share, more)
            self._after[:number, action, state] = list(pair.outcomes)
            self._share[:, action, state] = 0.0
            self._share[:number, action, state] = np.array(list(pair.outcomes.values())) / sum(pair.outcomes.values())
            (self._uncertain.add if number > 1 else self._uncertain.discard)((state, action))
        self._changed.clear()

    def _next_layer(self, layer: list[int], before: dict[int, tuple[int, int]], origin: int) -> list[int]:
        """Return the states one step beyond a layer; ``before`` maps each to the state and action that led to it."""
        new = []
        for state in layer:
            for action, pair in enumerate(self.pairs[state]):
                after = pair.usual
                if after != origin and after not in before:
                    before[after] = (state, action)
                    new.append(after)
        return new

    @staticmethod
    def _actions(origin: int, state: int, before: dict[int, tuple[int, int]]) -> list[int]:
        actions = []
        while state != origin:
            state, action = before[state]
            actions.append(action)
        return actions[::-1]
