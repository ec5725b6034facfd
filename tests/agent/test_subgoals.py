"""Subgoal discovery on examples worked out by hand."""

from __future__ import annotations

import numpy as np
import pytest

from ptl.agent.subgoals import covered_states, discover, fd_metric
from ptl.world.gridworld import GridWorld
from ptl.world.transitions import TransitionGraph

CORRIDOR = GridWorld.from_text("I.......A\n")  # states 0..8


def all_seen(world: GridWorld) -> TransitionGraph:
    return TransitionGraph(world.successors, np.full(world.n_states, 15, dtype=np.uint8))


def test_fd_metric_by_hand():
    paths = [np.array([0, 1, 2, 3, 4]), np.array([0, 5, 4])]
    metric = fd_metric(paths, 6)
    np.testing.assert_allclose(metric.frequency, [1, 0.5, 0.5, 0.5, 1, 0.5])
    # Path 1 has l = 4: d = 0, 1/2, 1, 1/2, 0; path 2 has l = 2: d = 0, 1, 0.
    np.testing.assert_allclose(metric.distance, [0, 0.5, 1, 0.5, 0, 1])
    np.testing.assert_allclose(metric.product, [0, 0.25, 0.5, 0.25, 0, 0.5])


def test_fd_metric_vanishes_at_both_ends_and_on_a_path_without_steps():
    metric = fd_metric([np.array([3])], 4)
    np.testing.assert_array_equal(metric.product, np.zeros(4))
    assert metric.frequency[3] == 1


def test_fd_metric_without_any_success():
    np.testing.assert_array_equal(fd_metric([], 3).product, np.zeros(3))


def test_odd_length_has_two_middles():
    metric = fd_metric([np.array([0, 1, 2, 3])], 4)
    np.testing.assert_allclose(metric.distance, [0, 2 / 3, 2 / 3, 0])


def test_the_parabola_is_flatter_than_the_tent():
    metric = fd_metric([np.array([0, 1, 2, 3, 4])], 5, "parabola")
    np.testing.assert_allclose(metric.distance, [0, 3 / 4, 1, 3 / 4, 0])


def test_covered_states_are_those_within_the_radius():
    np.testing.assert_array_equal(
        covered_states(all_seen(CORRIDOR), [3], 2), [False, True, True, True, True, True, False, False, False]
    )
    np.testing.assert_array_equal(covered_states(all_seen(CORRIDOR), [], 2), np.zeros(9, dtype=bool))


def test_only_seen_transitions_cover():
    seen = np.full(9, 15, dtype=np.uint8)
    seen[4] = 0b0111  # never went east from state 4
    graph = TransitionGraph(CORRIDOR.successors, seen)
    np.testing.assert_array_equal(np.flatnonzero(covered_states(graph, [3], 2)), [1, 2, 3, 4])


@pytest.mark.parametrize(("known", "rest"), [([1, 2, 5], [5, 6, 7, 8]), ([8], [8]), ([], range(9))])
def test_a_rest_starts_at_the_last_covered_state(known, rest):
    discovery = discover([np.arange(9)], all_seen(CORRIDOR), known, cover_radius=0)
    assert np.flatnonzero(discovery.incremental.frequency).tolist() == list(rest)


def test_discovery_puts_the_focus_on_the_unknown_part():
    discovery = discover([np.arange(9)] * 3, all_seen(CORRIDOR), [2], cover_radius=2)
    assert discovery.original.product.argmax() == 4
    # Covered: 0..4; the rest 4..8 has its middle at 6 and a length of 4 steps.
    assert discovery.incremental.product.argmax() == 6
    assert discovery.novelty == 4
    assert discovery.diameter == 8


def test_empty_library_leaves_both_metrics_equal():
    discovery = discover([np.arange(9)], all_seen(CORRIDOR), [], cover_radius=2)
    np.testing.assert_array_equal(discovery.original.product, discovery.incremental.product)


@pytest.mark.parametrize("radius", [0, 1, 3])
def test_frequency_of_the_rests_is_over_all_paths(radius):
    paths = [np.arange(9), np.array([0, 1])]
    discovery = discover(paths, all_seen(CORRIDOR), [5], cover_radius=radius)
    assert discovery.incremental.frequency[8] == 0.5
