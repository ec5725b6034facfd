"""Skill selection: P(C, S, G) = P(C|S, G) P(S|G) P(G), as the article factorises it.

C is the convergence of the system, S the skill and G the goal. For a given goal a skill is drawn with probability
proportional to P(C|s_i, g) P(s_i|g). The article says that the prior P(s_i|g) is a heuristic on similarity with the
goal that disregards transition probabilities, and that the likelihood P(C|s_i, g) follows the agent's performance with
the skill; both forms below are our choice.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np


def prior(
    cells: np.ndarray,
    subgoals: Iterable[int],
    goal: int,
    diagonal: float,
    form: str = "exponential",
    width: float = 0.1,
) -> np.ndarray:
    """Return the prior probability P(s_i|g) of each subgoal for a goal (our choice of form).

    Parameters
    ----------
    cells : array, shape (n_states, 2)
        Row and column of each state.
    subgoals : iterable of int
        States of the k candidate subgoals.
    goal : int
    diagonal : float
        Diagonal of the map in cells (L); distances are measured in ``width * diagonal``.
    form : {"exponential", "gaussian", "uniform"}
        exp(-x), exp(-x**2 / 2) or constant in x, the Euclidean distance over ``width * diagonal``.

    Returns
    -------
    float array, shape (k,)
        Sums to 1.
    """
    states = np.fromiter(subgoals, dtype=np.int64)
    offset = cells[states] - cells[goal]
    distance = np.sqrt((offset * offset).sum(axis=1)) / (width * diagonal)
    if form == "exponential":
        exponent = -distance
    elif form == "gaussian":
        exponent = -(distance**2) / 2
    elif form == "uniform":
        exponent = np.zeros(len(distance))
    else:
        raise ValueError(f"unknown form of the prior: {form}")
    weights = np.exp(exponent - exponent.max())
    return weights / weights.sum()


def draw_index(probabilities: np.ndarray, random: np.random.Generator) -> int:
    """Draw an index with the given probabilities, from one uniform number."""
    cumulated = np.cumsum(probabilities)
    # Rounding may leave the last sum a little below 1.
    return min(int(np.searchsorted(cumulated, random.random(), side="right")), len(cumulated) - 1)


class SkillSelection:
    """Draws skills and learns from the episodes how well each one serves the present goal.

    Parameters
    ----------
    prior : float array, shape (k,)
        P(s_i|g).
    exponent : float
        kappa in P(C|s_i, g) proportional to v_i**kappa.
    weight : float
        beta, weight of the newest episode in the moving average v_i of 1 / length.
    """

    def __init__(self, prior: np.ndarray, exponent: float = 2.0, weight: float = 0.5) -> None:
        self.prior = prior
        self._exponent = exponent
        self._weight = weight
        self._performance = np.full(len(prior), np.nan)

    @property
    def performance(self) -> np.ndarray:
        """v_i, float (k,): moving average of 1 / length; an unused skill has the best v, 1 before any episode."""
        unused = np.isnan(self._performance)
        if unused.all():
            return np.ones(len(unused))
        return np.where(unused, np.fmax.reduce(self._performance), self._performance)

    def probabilities(self) -> np.ndarray:
        """Return the probability of drawing each skill, float (k,)."""
        performance = self.performance
        weights = self.prior * (performance / performance.max()) ** self._exponent
        return weights / weights.sum()

    def draw(self, random: np.random.Generator) -> int:
        """Draw a skill; one uniform number and one loop over the skills."""
        return draw_index(self.probabilities(), random)

    def record(self, used: Iterable[int], length: int) -> None:
        """Update every skill used in an episode with the episode's length in steps."""
        for skill in set(used):
            old = self._performance[skill]
            new = 1.0 / length
            self._performance[skill] = new if np.isnan(old) else old + self._weight * (new - old)
