"""Rivals of the article's finder of subgoals against results worked out by hand or by brute force."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from mazes import random_world

from ptl.agent.finders import incremental
from ptl.agent.skills import SkillLibrary
from ptl.agent.subgoals import discover
from ptl.world.gridworld import GridWorld
from ptl.world.transitions import TransitionGraph
from studies.beyond import finders

CORRIDOR = GridWorld.from_text("I.......A\n")
ALL_SEEN = TransitionGraph(CORRIDOR.successors)
WHOLE_PATH = [np.arange(9)] * 3


def score(finder, paths=WHOLE_PATH, graph=ALL_SEEN, stored=()):
    return finder(discover(paths, graph, list(stored), 2), graph, list(stored))


def test_the_original_metric_knows_nothing_of_the_library():
    assert score(finders.original_fd, stored=[4]).argmax() == 4


def test_the_goal_alone_is_a_candidate():
    assert score(finders.task_goal).tolist() == [0] * 8 + [1]


def test_a_random_state_is_any_visited_one():
    seen = np.zeros(9, dtype=np.uint8)
    seen[:5] = 8  # east, so that states 0 to 5 are visited
    graph = TransitionGraph(CORRIDOR.successors, seen)
    finder = finders.random_state(np.random.default_rng(1))
    picked = [score(finder, [np.arange(6)], graph).argmax() for _ in range(600)]
    counts = np.bincount(picked, minlength=9)
    assert counts[6:].sum() == 0
    assert abs(counts[:6] - 100).max() < 4 * np.sqrt(600 * 1 / 6 * 5 / 6)


@pytest.mark.parametrize("seed", range(5))
def test_farthest_is_greedy_k_centre(seed):
    """Each new subgoal is at the greatest distance from the nearest centre, by distances between all pairs."""
    world = random_world(np.random.default_rng(seed))
    distance = np.array([world.distances_to(state) for state in range(world.n_states)])
    centres = [world.start]
    for _ in range(4):
        path = [np.array([world.start])]
        scores = score(finders.farthest, path, world.transitions, centres[1:])
        reachable = np.flatnonzero(distance[world.start] >= 0)
        nearest = {state: min(distance[state][centre] for centre in centres) for state in reachable}
        assert scores[reachable].tolist() == list(nearest.values())
        centres.append(int(scores.argmax()))
        assert nearest[centres[-1]] == max(nearest.values())


def test_greedy_k_centre_is_within_twice_the_optimum():
    world = GridWorld.from_text("I....\n.###.\n....A\n")
    distance = np.array([world.distances_to(state) for state in range(world.n_states)])
    centres = [world.start]
    while len(centres) < 3:
        centres.append(int(score(finders.farthest, [np.array([world.start])], world.transitions, centres[1:]).argmax()))
    best = min(distance[list(chosen)].min(axis=0).max() for chosen in itertools.combinations(range(world.n_states), 3))
    assert distance[centres].min(axis=0).max() <= 2 * best


@pytest.mark.parametrize("start", [0, 8])
def test_the_fiedler_vector_of_a_path_ends_at_its_other_end(start):
    scores = score(finders.covering, [np.array([start, abs(start - 1)])])
    assert scores.argmax() == 8 - start
    assert (np.diff(scores) * (1 if start == 0 else -1) > 0).all()
    # on a path the vector is a half wave: cos(pi (i + 1/2) / n)
    wave = np.cos(np.pi * (np.arange(9) + 0.5) / 9)
    wave /= np.linalg.norm(wave)
    expected = np.abs(wave - wave[start])
    np.testing.assert_allclose(scores, expected, atol=2e-6)


def test_a_stored_skill_closes_the_path_to_a_ring():
    """With an edge between its ends the path is a ring; the next subgoal is no end of the path."""
    assert 2 <= score(finders.covering, stored=[8]).argmax() <= 6


def test_the_conditions_are_the_same_for_every_finder():
    """The incremental metric determines whether a skill is added, the finder where."""
    long, short = WHOLE_PATH, [np.arange(2)]
    for finder in (incremental, finders.original_fd, finders.task_goal, finders.farthest, finders.covering):
        library = SkillLibrary(finder=finder)
        assert library.update(discover(short, ALL_SEEN, [], 2), ALL_SEEN, 0).subgoal == -1
        place = int(score(finder).argmax())
        assert library.update(discover(long, ALL_SEEN, [], 2), ALL_SEEN, 0).subgoal == place
        assert library.skills[0].policy.tolist() == ALL_SEEN.shortest_path_policy(place).tolist()
