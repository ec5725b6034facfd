"""Skill selection: P(C, S, G) = P(C|S, G) P(S|G) P(G), as the article factorises it.

C is the convergence of the system, S the skill and G the goal. For a given goal a skill is drawn with probability
proportional to P(C|s_i, g) P(s_i|g). The article says that the prior P(s_i|g) is a heuristic on similarity with the
goal that disregards transition probabilities, and that the likelihood P(C|s_i, g) follows the agent's performance with
the skill; the forms of both are our choice. The likelihood and the draw are in `ptl.agent._selection`.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ptl.world.transitions import checked_states


def prior(
    cells: np.ndarray,
    subgoals: Iterable[int],
    goal: int,
    diagonal: float,
    form: str = "exponential",
    width: float = 0.1,
    allowed: np.ndarray | None = None,
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
    allowed : bool array, shape (k,), optional
        Candidates that may be drawn, at least one; the others have probability 0. All if not given.

    Returns
    -------
    float array, shape (k,)
        Finite, and sums to 1, however narrow the prior is.
    """
    states = checked_states(np.fromiter(subgoals, dtype=np.int64), len(cells))
    offset = cells[states] - cells[checked_states(goal, len(cells))]
    distance = np.sqrt((offset * offset).sum(axis=1))
    return prior_of_distances(distance, width * diagonal, form, allowed)


def prior_of_distances(
    distance: np.ndarray, unit: float, form: str = "exponential", allowed: np.ndarray | None = None
) -> np.ndarray:
    """Return the prior of candidates at these distances, float (k,), in the forms of `prior`.

    Parameters
    ----------
    distance : array, shape (k,)
        What is not allowed may have any.
    unit : float
        Distance at which the exponential form has fallen to 1/e.
    form, allowed
        As in `prior`.
    """
    if not unit > 0:
        raise ValueError(f"the width of the prior must be above 0, not {unit}")
    possible = np.ones(len(distance), dtype=bool) if allowed is None else allowed
    # logarithms relative to the nearest candidate: its own is 0, even if others overflow
    beyond = distance - distance[possible].min()
    with np.errstate(over="ignore"):
        if form == "exponential":
            logarithms = -(beyond / unit)
        elif form == "gaussian":
            logarithms = -(beyond / unit) * ((2 * distance - beyond) / 2) / unit
        elif form == "uniform":
            logarithms = np.zeros(len(distance))
        else:
            raise ValueError(f"unknown form of the prior: {form}")
    weights = np.exp(np.where(possible, logarithms, -np.inf))
    return weights / weights.sum()
