"""Exact values that learning on a map must agree with, computed from the transition table alone.

``successors`` is always the (n, 4) table of next states.  Nothing here uses the package.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import shortest_path


def distances(successors: np.ndarray) -> np.ndarray:
    """Shortest path lengths in steps between all pairs, (n, n) float, ``inf`` where there is no path."""
    n_states = len(successors)
    before, after = np.repeat(np.arange(n_states), 4), np.asarray(successors).ravel()
    moves = before != after
    graph = csr_array((np.ones(moves.sum()), (before[moves], after[moves])), shape=(n_states, n_states))
    return shortest_path(graph, directed=True, unweighted=True)


def transition_matrix(successors: np.ndarray) -> np.ndarray:
    """(n, n) transition probabilities of the walk that takes each action with probability 1/4."""
    n_states = len(successors)
    matrix = np.zeros((n_states, n_states))
    np.add.at(matrix, (np.repeat(np.arange(n_states), 4), np.asarray(successors).ravel()), 0.25)
    return matrix


def transient_matrix(successors: np.ndarray, start: int, goal: int) -> tuple[np.ndarray, np.ndarray]:
    """States the walk from ``start`` may visit before ``goal`` (start first), and its matrix on them."""
    reached = [start]
    known = {start, goal}
    for state in reached:
        for after in np.asarray(successors)[state].tolist():
            if after not in known:
                known.add(after)
                reached.append(after)
    states = np.array(reached)
    return states, transition_matrix(successors)[np.ix_(states, states)]


def hitting_time(successors: np.ndarray, start: int, goal: int) -> tuple[float, float]:
    """Mean and standard deviation, in steps, of the uniform random walk's time from start to goal.

    With Q the transient part of the walk, the mean solves (I - Q) m = 1 and the second moment
    (I - Q) v = 1 + 2 Q m.
    """
    if start == goal:
        return 0.0, 0.0
    states, matrix = transient_matrix(successors, start, goal)
    system = np.eye(len(states)) - matrix
    mean = np.linalg.solve(system, np.ones(len(states)))
    second = np.linalg.solve(system, 1.0 + 2.0 * matrix @ mean)
    return float(mean[0]), float(np.sqrt(second[0] - mean[0] ** 2))


def length_distribution(successors: np.ndarray, start: int, goal: int, longest: int) -> np.ndarray:
    """P(walk reaches the goal at exactly step t) for t = 0..longest (start is not the goal)."""
    states, matrix = transient_matrix(successors, start, goal)
    into_goal = transition_matrix(successors)[states, goal]
    present = np.zeros(len(states))
    present[0] = 1.0
    probabilities = np.zeros(longest + 1)
    for step in range(1, longest + 1):
        probabilities[step] = present @ into_goal
        present = present @ matrix
    return probabilities


def erased_path_probability(successors: np.ndarray, path: np.ndarray) -> float:
    """Probability that the loop-erased random walk from path[0] to path[-1] is exactly ``path``.

    Lawler's product: at each state of the path in turn, the expected number of visits to it by the walk that
    ends at the goal and at the earlier states of the path, times the probability of the step to the next.
    """
    transitions = transition_matrix(successors)
    path = np.asarray(path)
    goal = int(path[-1])
    inhabited = sorted(reachable(successors, int(path[0])))
    removed = {goal}
    probability = 1.0
    for state, after in zip(path[:-1].tolist(), path[1:].tolist(), strict=True):
        kept = [other for other in inhabited if other not in removed]
        matrix = transitions[np.ix_(kept, kept)]
        visits = np.linalg.solve(np.eye(len(kept)) - matrix, np.eye(len(kept))[:, kept.index(state)])
        probability *= visits[kept.index(state)] * transitions[state, after]
        removed.add(state)
    return float(probability)


def reachable(successors: np.ndarray, state: int) -> set[int]:
    """States that some sequence of moves leads to, the state itself among them."""
    found, waiting = {state}, [state]
    while waiting:
        for after in np.asarray(successors)[waiting.pop()].tolist():
            if after not in found:
                found.add(after)
                waiting.append(after)
    return found


def distances_over(successors: np.ndarray, known: np.ndarray, target: int, *, both_ways: bool = False) -> np.ndarray:
    """Steps from every state to ``target`` over the known transitions only, shape (n_states,), -1 if unreachable."""
    states, actions = np.nonzero(known)
    n = len(successors)
    graph = csr_array((np.ones(len(states)), (states, successors[states, actions])), shape=(n, n))
    steps = shortest_path(graph.T, unweighted=True, directed=not both_ways, indices=target)
    return np.where(np.isinf(steps), -1, steps).astype(int)


def hitting_times(successors: np.ndarray, goal: int) -> np.ndarray:
    """Mean steps of the uniform random walk from every state to a goal that all of them reach, (n,)."""
    others = np.flatnonzero(np.arange(len(successors)) != goal)
    times = np.zeros(len(successors))
    matrix = transition_matrix(successors)[np.ix_(others, others)]
    times[others] = np.linalg.solve(np.eye(len(others)) - matrix, np.ones(len(others)))
    return times


def led_hitting_time(
    successors: np.ndarray, start: int, goal: int, policy: np.ndarray, subgoal: int, initiation: np.ndarray
) -> float:
    """Mean steps from start to goal of a uniform walk that is carried to a subgoal from its initiation set.

    It is carried from the start first, and later from each state of the set at its first visit while walking.  With U
    the set's states that have carried it, the times h_U solve (I - P) h_U = 1 on the states where it walks; where it
    is carried k steps to s', h_U(s) = k + h_{U + s}(s').
    """
    n_states = len(successors)
    transitions = transition_matrix(successors)

    def carried(state: int) -> tuple[int, int]:
        steps = 0
        while state not in (subgoal, goal) and policy[state] >= 0:
            state, steps = int(successors[state, policy[state]]), steps + 1
        return state, steps

    @cache
    def times(used: frozenset[int]) -> np.ndarray:
        system, right = np.eye(n_states) - transitions, np.ones(n_states)
        fixed = {goal: 0.0}
        for state in set(np.flatnonzero(initiation).tolist()) - used - {goal}:
            end, steps = carried(state)
            fixed[state] = steps + times(used | {state})[end]
        for state, time in fixed.items():
            system[state], right[state] = np.eye(n_states)[state], time
        return np.linalg.solve(system, right)

    end, steps = carried(start)
    return float(steps + times(frozenset())[end])


def mixed_hitting_time(
    successors: np.ndarray, start: int, goal: int, policy: np.ndarray, subgoal: int, psi: float, decay: float
) -> float:
    """Mean steps from start to goal of a uniform walk in which step h follows a policy with probability psi decay**h.

    The policy is left for good at its subgoal.
    """
    n_states = len(successors)
    transitions, walking = transition_matrix(successors), hitting_times(successors, goal)
    followed = transitions.copy()
    followed[policy >= 0] = np.eye(n_states)[successors[np.arange(n_states), policy][policy >= 0]]
    present = np.eye(n_states)[start]
    expected = 0.0
    while psi > 1e-12 and present.any():
        for end in (goal, subgoal):
            expected += present[end] * walking[end]
            present[end] = 0.0
        expected += present.sum()
        present = present @ (psi * followed + (1 - psi) * transitions)
        psi *= decay
    return float(expected + present @ walking)
