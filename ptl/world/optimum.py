"""Expected steps to a goal where steps may slip: of a policy, and of the best one."""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import spsolve

from ptl.world.gridworld import GridWorld
from ptl.world.transitions import N_ACTIONS, TransitionGraph, checked_states

TOLERANCE = 1e-9
"""Relative gain below which two actions are equally good."""


def steps_of_policy(world: GridWorld, policy: np.ndarray, goal: int) -> np.ndarray:
    """Return the expected steps of a policy from every state to a goal.

    With slip p the expected steps m solve m(s) = 1 + (1 - p) m(s_a) + p times the mean of m(s_d) over the four
    directions d, where s_d is the state after a step in direction d, a the policy's action and m = 0 at the goal.

    Parameters
    ----------
    policy : int array, shape (n_states,)
        Action of each state; that of the goal is not used.
    goal : int

    Returns
    -------
    float array, shape (n_states,)
        inf in states from which the policy may never reach the goal.

    Raises
    ------
    ValueError
        If the goal is not a state, or the policy does not give an action from 0 to 3 in each state.
    """
    actions = checked_states(policy, N_ACTIONS)
    if actions.shape != (world.n_states,):
        raise ValueError(f"a policy needs an action for each of {world.n_states} states, not the shape {actions.shape}")
    steps = world.distances_to(goal)
    if world.slip == 0:
        steps = TransitionGraph(world.successors, (1 << actions).astype(np.uint8)).steps_to(goal)
    states = np.flatnonzero(steps > 0)
    place = np.full(world.n_states, -1)
    place[states] = np.arange(len(states))
    chance = np.full((world.n_states, N_ACTIONS), world.slip / N_ACTIONS)
    chance[np.arange(world.n_states), actions] += 1 - world.slip
    after = place[world.successors[states]]
    rows, directions = np.nonzero(after >= 0)
    chances = chance[states][rows, directions]
    moves = sparse.coo_array((chances, (rows, after[rows, directions])), shape=(len(states),) * 2)
    expected = np.full(world.n_states, np.inf)
    expected[goal] = 0
    if len(states):
        expected[states] = spsolve((sparse.eye_array(len(states)) - moves).tocsc(), np.ones(len(states)))
    return expected


def optimum(world: GridWorld, goal: int) -> float:
    """Return the least expected steps from the start to a goal: the shortest path where no step slips."""
    if world.slip == 0:
        return float(world.shortest_path_length(world.start, goal))
    return float(optimal_steps(world, goal)[world.start])


def optimal_steps(world: GridWorld, goal: int) -> np.ndarray:
    """Return the least expected steps from every state to a goal, by policy iteration.

    The first policy follows shortest paths; without slip these are the answer.

    Returns
    -------
    float array, shape (n_states,)
        inf in states that the goal cannot be reached from.

    Raises
    ------
    ValueError
        If the goal is not a state.
    """
    states = np.arange(world.n_states)
    policy = np.maximum(world.transitions.shortest_path_policy(goal), 0)
    while True:
        expected = steps_of_policy(world, policy, goal)
        after = expected[world.successors]
        best = after.argmin(axis=1)
        better = after[states, best] < after[states, policy] * (1 - TOLERANCE)
        better[goal] = False
        if world.slip == 1 or not better.any():
            return expected
        policy = np.where(better, best, policy)
