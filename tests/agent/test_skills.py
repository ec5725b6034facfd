"""Skill policies and the library's three tests."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import mazes
import numpy as np
import oracles
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ptl.agent.policies import greedy_policy
from ptl.agent.skills import Skill, SkillLibrary
from ptl.agent.subgoals import FDMetric
from ptl.world.gridworld import GridWorld
from ptl.world.transitions import TransitionGraph


def discovery(metric: list[float], novelty: float = 10.0, diameter: int = 20) -> Any:
    """Return what a library asks of a discovery."""
    values = np.array(metric)
    return SimpleNamespace(incremental=FDMetric(np.ones_like(values), values), novelty=novelty, diameter=diameter)


@pytest.fixture
def graph() -> TransitionGraph:
    return GridWorld.from_text("I..A\n").transitions


def test_library_adds_the_argmax(graph):
    library = SkillLibrary(novelty=0.2, threshold=0.2)
    assert library.update(discovery([0.1, 0.5, 0.5, 0.0]), graph, 3).subgoal == 1  # the tie goes to the lower number
    assert library.subgoals == [1]
    assert library.skills[0].learned_after == 3
    np.testing.assert_array_equal(library.skills[0].policy, [3, -1, 2, 2])


@pytest.mark.parametrize(
    ("metric", "novelty", "diameter", "reason"),
    [
        ([0, 0.5, 0, 0], 3.9, 20, "too short"),
        ([0, 0.19, 0, 0], 10, 20, "stands out"),
        ([0, 0.0, 0, 0], 10, 20, "stands out"),
    ],
)
def test_library_refuses(graph, metric, novelty, diameter, reason):
    library = SkillLibrary(novelty=0.2, threshold=0.2)
    update = library.update(discovery(metric, novelty, diameter), graph, 0)
    assert update.subgoal == -1 and reason in update.reason and len(library) == 0


def test_limits_themselves_pass(graph):
    library = SkillLibrary(novelty=0.2, threshold=0.2)
    assert library.update(discovery([0, 0.2, 0, 0], 4.0, 20), graph, 0).subgoal == 1


def test_library_takes_no_subgoal_twice(graph):
    library = SkillLibrary()
    library.update(discovery([0, 0.5, 0, 0]), graph, 0)
    again = library.update(discovery([0, 0.5, 0.4, 0]), graph, 1)
    assert again.subgoal == -1 and "already" in again.reason and len(library) == 1


@settings(max_examples=40, deadline=None)
@given(mazes.maps(), st.integers(0, 2**32 - 1))
def test_skill_policies_are_shortest_paths_over_seen_transitions(text, seed):
    world = GridWorld.from_text(text)
    random = np.random.default_rng(seed)
    seen = random.integers(0, 16, world.n_states).astype(np.uint8)
    target = int(random.integers(world.n_states))
    known = np.array([[seen[s] >> a & 1 for a in range(4)] for s in range(world.n_states)], dtype=bool)
    expected = oracles.distances_over(world.successors, known, target)
    policy = TransitionGraph(world.successors, seen).shortest_path_policy(target)
    for state in range(world.n_states):
        if state == target or expected[state] < 0:
            assert policy[state] == -1
            continue
        here, steps = state, 0
        while here != target:
            assert known[here, policy[here]]
            here, steps = world.successors[here, policy[here]], steps + 1
        assert steps == expected[state]


@settings(max_examples=40, deadline=None)
@given(mazes.maps(), st.integers(0, 2**32 - 1))
def test_diameter_is_the_longest_of_all_shortest_paths(text, seed):
    world = GridWorld.from_text(text)
    seen = np.random.default_rng(seed).integers(0, 16, world.n_states).astype(np.uint8)
    known = np.array([[seen[s] >> a & 1 for a in range(4)] for s in range(world.n_states)], dtype=bool)
    longest = max(
        oracles.distances_over(world.successors, known, s, both_ways=True).max() for s in range(world.n_states)
    )
    assert TransitionGraph(world.successors, seen).diameter() == longest


def test_greedy_policy_takes_the_first_of_equals_and_says_nothing_where_uninformed():
    q = np.array([[0, 0, 0, 0], [0.5, 0.5, 0.5, 0.5], [0, 0.2, 0.2, 0.1], [0.1, 0, 0, 0.3]])
    np.testing.assert_array_equal(greedy_policy(q), [-1, -1, 1, 3])
    np.testing.assert_array_equal(greedy_policy(q, everywhere=True), [0, 0, 1, 3])


def test_the_library_knows_its_subgoals_or_the_ways_to_them():
    world = GridWorld.from_text("I.......A\n")
    library = SkillLibrary(skills=[Skill(4, TransitionGraph(world.successors).shortest_path_policy(4), 0)])
    assert library.known_states(1, world.successors) == [4]
    assert library.known_states(1, world.successors, "paths") == [1, 2, 3, 4]
    undefined = np.full(9, -1, dtype=np.int8)
    assert SkillLibrary(skills=[Skill(4, undefined, 0)]).known_states(1, world.successors, "paths") == [4]
