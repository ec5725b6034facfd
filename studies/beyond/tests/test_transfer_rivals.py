"""Rivals that keep policies: the policy library, and successor features."""

from __future__ import annotations

import numpy as np
import pytest

from ptl import methods
from ptl.agent._kernel import Dynamics, Learner
from ptl.config import Parameters
from ptl.learning.life import learn_life, tasks_of
from ptl.world.gridworld import GridWorld
from studies.beyond.methods import reference
from studies.beyond.methods.plpr import is_similar
from studies.beyond.methods.successor_features import discounted_visits

NORTH, SOUTH, WEST, EAST = range(4)
LINE = GridWorld.from_text("B.I..A\n", "line")


def make(name: str, world: GridWorld) -> methods.BaseMethod:
    return methods.load(reference(name))(world, Parameters(), np.random.default_rng(0))


# -- the policy library


@pytest.mark.parametrize(
    ("gains", "similar"),
    [
        ([0.4], False),  # an empty library
        ([0.4, 0.09], False),
        ([0.4, 0.1], True),  # exactly delta W
        ([0.4, 0.05, 0.3], True),
        ([0.4, 0.05, 0.02], False),
        ([0.0, 0.0], True),  # nothing was gained at all
    ],
)
def test_a_policy_is_similar_if_one_of_the_library_gains_a_quarter_as_much(gains, similar):
    assert is_similar(np.array(gains)) == similar


def test_a_task_once_more_adds_no_policy():
    """Reused for its own task a policy gains as much as the new one; westwards it gains nothing."""
    method = make("plpr", LINE)
    sizes = []
    for goal in "AAB":
        learner = Learner(Dynamics(LINE.successors), LINE.goal(goal), np.random.SFC64(1))
        method.begin_task(LINE.start, LINE.goal(goal))
        # W of the new policy, and of the first task's policy by the steps of its episodes
        method.selection.record([0], 3)
        if len(method.guides) > 1:
            method.selection.record([1], 3 if goal == "A" else 90)
        method.end_task(learner)
        sizes.append(len(method.past_policies))
    assert sizes == [1, 1, 2]


def test_a_life_keeps_a_basis_of_policies():
    life = learn_life(LINE, tasks_of(LINE, "AB"), reference("plpr"), Parameters().replace(learning__episodes=30), 2)
    assert {arm for episode in life.records[1].selected for arm in episode} == {0, 1}


# -- successor features


def test_successor_features_of_a_chain_by_hand():
    """0 -> 1 -> 2, and 2 to itself: (I - gamma P)^-1 has 1, gamma, gamma^2 / (1 - gamma) in its first row."""
    after, policy, gamma = np.array([[1] * 4, [2] * 4, [2] * 4]), np.array([EAST, WEST, NORTH]), 0.9
    matrix = np.linalg.inv(np.eye(3) - gamma * np.array([[0, 1, 0], [0, 0, 1], [0, 0, 1]]))
    np.testing.assert_allclose(matrix[0], [1, 0.9, 0.81 / 0.1])
    columns = [discounted_visits(policy, after, goal, gamma) for goal in range(3)]
    np.testing.assert_allclose(np.transpose(columns), matrix)
    # a policy that ends in 2 visits it once
    np.testing.assert_allclose(discounted_visits(np.array([EAST, WEST, -1]), after, 2, gamma), [0.81, 0.9, 1])


def test_past_policies_are_worth_what_they_lead_to():
    """The policy to A passes 3 and 4 (states of the line 0 to 5, start 2); of B it knows nothing."""
    method = make("successor_features", LINE)
    method.begin_task(LINE.start, LINE.goal("A"))
    assert not method.past.any()
    q = np.zeros((6, 4))
    q[2:5, EAST] = 0.95 ** np.arange(2, -1, -1)
    method.seen[2:5] = 1 << EAST | 1 << WEST
    learner = Learner(Dynamics(LINE.successors), LINE.goal("A"), np.random.SFC64(1), initial_q=q)
    method.end_task(learner)
    method.begin_task(LINE.start, 4)
    expected = np.zeros((6, 4))
    # a step into 4 is worth 1, one that leaves k steps of the policy to it gamma^k
    expected[2, [EAST, WEST]] = 0.95, 0.0
    expected[3, [EAST, WEST]] = 1.0, 0.95**2
    expected[4, [EAST, WEST]] = 0.0, 0.95
    np.testing.assert_allclose(method.past, expected)
    method.begin_task(LINE.start, LINE.goal("B"))
    assert not method.past.any()


def test_a_goal_on_the_way_of_a_past_policy_is_found_at_once():
    world = GridWorld.from_text("#.....#\nI..B..A\n#.....#\n", "way")
    few = Parameters().replace(learning__episodes=200, learning__epsilon=0.02)
    firsts = [
        learn_life(world, tasks_of(world, "AB"), reference("successor_features"), few, seed).records[1].steps[0]
        for seed in range(20)
    ]
    plain = [learn_life(world, "B", "no_transfer", few, seed).records[0].steps[0] for seed in range(20)]
    assert np.median(firsts) < np.median(plain) / 3
