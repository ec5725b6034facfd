"""A model of a deterministic world, filled as actions are tried."""

from __future__ import annotations

import numpy as np

N_ACTIONS = 4
UNTRIED = -1


class Model:
    """The state that each tried action led to.

    Parameters
    ----------
    n_states : int

    Attributes
    ----------
    after : list of lists of int
        State after each action of each state, `UNTRIED` before it is tried.
    size : int
        Number of tried pairs of state and action.
    """

    def __init__(self, n_states: int) -> None:
        self.after = [[UNTRIED] * N_ACTIONS for _ in range(n_states)]
        self.size = 0

    def note(self, state: int, action: int, after: int) -> None:
        """Record the state that an action led to."""
        self.size += self.after[state][action] == UNTRIED
        self.after[state][action] = after

    def way_to(self, origin: int, goal: int) -> list[int] | None:
        """Return the actions of a shortest path over tried actions, None if there is no path."""
        before: dict[int, tuple[int, int]] = {}
        layer = [origin]
        while layer and goal not in before and goal != origin:
            layer = self._next_layer(layer, before, origin)
        return self._actions(origin, goal, before) if goal in before or goal == origin else None

    def way_to_untried(self, origin: int, random: np.random.Generator) -> list[int] | None:
        """Return the actions of a shortest path to a state with an untried action, and that action.

        Ties of states at the same distance and of actions in a state are broken uniformly at random. None if all
        actions of all reachable states have been tried.
        """
        before: dict[int, tuple[int, int]] = {}
        layer = [origin]
        while layer:
            untried = [(s, a) for s in layer for a in range(N_ACTIONS) if self.after[s][a] == UNTRIED]
            if untried:
                state, action = untried[int(random.random() * len(untried))]
                return [*self._actions(origin, state, before), action]
            layer = self._next_layer(layer, before, origin)
        return None

    def _next_layer(self, layer: list[int], before: dict[int, tuple[int, int]], origin: int) -> list[int]:
        """Return the states one step beyond a layer; ``before`` maps each to the state and action that led to it."""
        new = []
        for state in layer:
            for action, after in enumerate(self.after[state]):
                if after != UNTRIED and after != origin and after not in before:
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
