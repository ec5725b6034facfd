"""Controls and rivals of the article's finder of subgoals, see `ptl.agent.finders`."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ptl.agent.finders import Finder
from ptl.agent.subgoals import Discovery
from ptl.world.transitions import TransitionGraph

SAME = 1e-6
"""Entries of an eigenvector closer than this are equal."""


def original_fd(discovery: Discovery, graph: TransitionGraph, stored: Sequence[int]) -> np.ndarray:
    """Score by the original FD metric, which ignores the library (Kretchmar et al., 2003)."""
    return discovery.original.product


def task_goal(discovery: Discovery, graph: TransitionGraph, stored: Sequence[int]) -> np.ndarray:
    """Score the task's goal alone (control: no discovery at all)."""
    scores = np.zeros(graph.n_states)
    scores[discovery.goal] = 1.0
    return scores


def random_state(random: np.random.Generator) -> Finder:
    """Return a finder that takes a visited state at random (control: does the choice of the state matter?)."""

    def scores(discovery: Discovery, graph: TransitionGraph, stored: Sequence[int]) -> np.ndarray:
        visited = graph.steps_from([discovery.start]) >= 0
        return np.where(visited, 1.0 - random.random(graph.n_states), 0.0)

    return scores


def farthest(discovery: Discovery, graph: TransitionGraph, stored: Sequence[int]) -> np.ndarray:
    """Score by the steps from the start and the stored subgoals, whichever is nearest (Gonzalez, 1985: k-centre).

    Steps are counted over transitions seen in the task, so an unvisited state is no candidate.
    """
    return np.maximum(graph.steps_from([discovery.start, *stored]), 0).astype(float)


def covering(discovery: Discovery, graph: TransitionGraph, stored: Sequence[int]) -> np.ndarray:
    """Score by the Fiedler vector of the seen graph, away from the start (Jinnai et al., 2019: covering options).

    An option there joins the two ends of the vector, and the next vector is that of the graph with this edge. Skills
    here are used from the start, so that the edges of the stored skills join the start to their subgoals, and the
    end that is farther from the start is taken (our choice). States without a path from the start are no candidates.
    """
    reached = np.flatnonzero(graph.steps_from([discovery.start]) >= 0)
    number = np.full(graph.n_states, -1)
    number[reached] = np.arange(len(reached))
    adjacent = np.zeros((len(reached), len(reached)), dtype=bool)
    states, actions = np.nonzero(graph.known)
    adjacent[number[states], number[graph.successors[states, actions]]] = True
    start = number[discovery.start]
    adjacent[start, [number[subgoal] for subgoal in stored if number[subgoal] >= 0]] = True
    adjacent |= adjacent.T
    np.fill_diagonal(adjacent, False)
    laplacian = np.diag(adjacent.sum(axis=1)) - adjacent.astype(float)
    scores = np.zeros(graph.n_states)
    if len(reached) > 1:
        fiedler = np.linalg.eigh(laplacian)[1][:, 1]
        if fiedler[start] > 0:
            fiedler = -fiedler
        # equal entries differ by rounding, which must not choose among them
        scores[reached] = np.round((fiedler - fiedler[start]) / SAME).clip(0) * SAME
    return scores
