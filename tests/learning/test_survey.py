"""The exhaustive survey of subgoals does what single tasks do."""

from __future__ import annotations

import numpy as np
import pytest
from reference import ReferenceLearner

from ptl.agent import seeding
from ptl.agent._kernel import Dynamics, Learner
from ptl.agent.subgoals import fd_metric
from ptl.config import Learning
from ptl.errors import UserError
from ptl.learning._survey import subgoals_from
from ptl.learning.survey import add_up, chosen_starts, subgoal_frequencies
from ptl.world.gridworld import GridWorld

ROOMS = GridWorld.from_text("#########\n#I..#...#\n#.......#\n#...#..A#\n#########\n")


def one_by_one(world: GridWorld, start: int, goals, bit_generator, trajectories: int) -> list[int]:
    """The same tasks through the plain reference and the plain metric, on one stream of random numbers."""
    subgoals = []
    spare_half = None
    for goal in goals:
        learner = ReferenceLearner(world.successors, int(goal), bit_generator)
        learner._spare_half = spare_half
        paths = []
        while len(paths) < trajectories:
            learner.begin_episode(start)
            learner.explore()
            paths.append(learner.erased_path())
        spare_half = learner._spare_half
        metric = fd_metric(paths, world.n_states).product
        subgoals.append(int(metric.argmax()) if metric.any() else -1)
    return subgoals


def test_survey_equals_single_tasks():
    start = ROOMS.start
    goals = [state for state in range(ROOMS.n_states) if state != start]
    got, steps = subgoals_from(
        Dynamics(ROOMS.successors), start, goals, np.random.SFC64(4), 8, 80,
        alpha=0.05, gamma=0.95, epsilon=0.1, max_steps=10**7,
    )  # fmt: skip
    assert got.tolist() == one_by_one(ROOMS, start, goals, np.random.SFC64(4), 8)
    assert steps > 0


def test_first_task_of_a_survey_equals_the_kernel(env3):
    goal = env3.goals["C"]
    got, steps = subgoals_from(
        Dynamics(env3.successors), env3.start, [goal], np.random.SFC64(9), 30, 300,
        alpha=0.05, gamma=0.95, epsilon=0.1, max_steps=10**7,
    )  # fmt: skip
    learner = Learner(Dynamics(env3.successors), goal, np.random.SFC64(9))
    paths, total = [], 0
    for _ in range(30):
        learner.begin_episode(env3.start)
        learner.explore()
        total += learner.steps
        paths.append(learner.erased_path())
    assert (got[0], steps) == (fd_metric(paths, env3.n_states).product.argmax(), total)


def test_counts_add_up_and_do_not_depend_on_batches():
    whole = subgoal_frequencies(ROOMS, range(ROOMS.n_states), 5, Learning(), 1, "rooms")
    parts = [
        subgoal_frequencies(ROOMS, range(ROOMS.n_states)[batch::3], 5, Learning(), 1, "rooms") for batch in range(3)
    ]
    for name, value in add_up(parts).items():
        np.testing.assert_array_equal(value, whole[name])
    n = ROOMS.n_states
    assert whole["pairs"] == n * (n - 1) and whole["counts"].sum() + whole["unresolved"] == whole["pairs"]
    adjacent = sum(len(set(row) - {state}) for state, row in enumerate(ROOMS.successors.tolist()))
    # Adjacent cells leave no state in between unless an early episode made a detour.
    assert 0 < whole["unresolved"] <= adjacent
    assert whole["counts"].argmax() in {ROOMS.state_at(2, column) for column in (3, 4, 5)}


def test_survey_refuses_what_does_not_succeed():
    with pytest.raises(UserError, match=r"learning\.max_steps"):
        subgoal_frequencies(ROOMS, [0], 5, Learning(max_steps=1), 1, "rooms")


def test_sampled_starts_are_stable_and_within_the_map(env2):
    starts = chosen_starts(env2, 6, 2019, "env2")
    assert len(set(starts.tolist())) == 6 and (np.diff(starts) > 0).all() and starts.max() < env2.n_states
    np.testing.assert_array_equal(starts, chosen_starts(env2, 6, 2019, "env2"))
    assert len(chosen_starts(env2, None, 2019, "env2")) == env2.n_states


def test_streams_of_different_names_differ():
    first = seeding.bit_generator(1, "env1", "ptl", 0).random_raw(4)
    assert (first == seeding.bit_generator(1, "env1", "ptl", 0).random_raw(4)).all()
    for other in [(1, "env1", "ptl", 1), (2, "env1", "ptl", 0), (1, "env1ptl", 0), (1, "env1", "ptl", "0")]:
        assert (first != seeding.bit_generator(*other).random_raw(4)).any()
