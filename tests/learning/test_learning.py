"""A learner's life: what passes from task to task, what is recorded, and that seeds are wired through."""

from __future__ import annotations

import numpy as np
import pytest

from ptl import methods
from ptl.config import Parameters
from ptl.errors import UserError
from ptl.learning import growth
from ptl.learning.life import Life, Task, learn_life, tasks_of
from ptl.world.drawing import ROOM_SIZE
from ptl.world.gridworld import GridWorld

ROOMS = GridWorld.from_text(
    "###############\n#I...#...#...A#\n#.............#\n#....#...#....#\n#..B.#.C.#....#\n###############\n", "rooms"
)
QUICK = Parameters().replace(learning__episodes=30, subgoals__trajectories=10)


def live(method: str, seed: int = 0, parameters: Parameters = QUICK) -> Life:
    return learn_life(ROOMS, tasks_of(ROOMS, "ABC"), method, parameters, 1, "rooms", seed)


def numbers(life: Life) -> bytes:
    return b"".join(record.q.tobytes() + record.steps.tobytes() for record in life.records)


@pytest.mark.parametrize("method", methods.names())
def test_equal_seeds_give_equal_numbers_and_other_seeds_others(method):
    assert numbers(live(method, 0)) == numbers(live(method, 0))
    assert numbers(live(method, 0)) != numbers(live(method, 1))


@pytest.mark.parametrize("method", methods.names())
def test_records_are_consistent(method):
    life = live(method)
    for record, letter in zip(life.records, "ABC", strict=True):
        assert record.task == Task(letter, ROOMS.start, ROOMS.goals[letter])
        shortest = ROOMS.shortest_path_length(ROOMS.start, record.task.goal)
        assert (record.steps >= shortest).all() and not record.truncated.any()
        assert len(record.selected) == len(record.steps) == 30
        assert record.q.min() >= 0 and record.q.max() <= 1
        visited = record.seen > 0
        assert visited[ROOMS.start] and not visited[record.task.goal]
        assert not record.q[~visited].any() or method == "full_transfer"
        if record.update.subgoal >= 0:
            assert visited[record.update.subgoal]


@pytest.mark.parametrize("method", methods.names())
def test_the_rule_for_ties_reaches_every_method(method):
    parameters = QUICK.replace(learning__epsilon=0.6, learning__max_steps=5000)
    first = parameters.replace(learning__ties="first")
    assert numbers(live(method, parameters=first)) != numbers(live(method, parameters=parameters))


def test_methods_are_independent_of_each_other():
    # The stream is named by the method, so running another one before changes nothing.
    alone = numbers(live("ptl"))
    live("no_transfer")
    assert numbers(live("ptl")) == alone


def test_full_transfer_carries_q_over():
    life = live("full_transfer")
    first, second = life.records[0].q, life.records[1].q
    untouched = life.records[1].seen == 0
    np.testing.assert_array_equal(second[untouched], first[untouched])


def test_library_grows_by_at_most_one_skill_a_task_and_only_for_ptl():
    for method in methods.names():
        life = live(method)
        assert (life.library is not None) == method.startswith("ptl")
        if life.library is not None:
            after = [skill.learned_after for skill in life.library.skills]
            assert after == sorted(set(after)) and len(after) >= 1
            added = [record.update.subgoal for record in life.records if record.update.subgoal >= 0]
            assert added == life.library.subgoals


def test_first_task_knows_no_skill():
    assert {skill for used in live("ptl").records[0].selected for skill in used} == {0}


def test_truncated_episodes_are_marked_and_not_taken_as_trajectories():
    parameters = QUICK.replace(learning__max_steps=20)
    record = live("no_transfer", parameters=parameters).records[0]
    assert record.truncated.any()
    np.testing.assert_array_equal(record.steps[record.truncated], 20)
    assert (record.steps[~record.truncated] <= 20).all()
    hopeless = live("ptl", parameters=QUICK.replace(learning__max_steps=2)).records[0]
    assert hopeless.truncated.all() and not hopeless.discovery.original.product.any()
    assert hopeless.update.subgoal == -1


def test_growth_draws_its_own_tasks():
    life = growth.grow_library(ROOMS, 12, QUICK, 1, "rooms", 0)
    starts = [record.task.start for record in life.records]
    goals = [record.task.goal for record in life.records]
    assert all(start != goal for start, goal in zip(starts, goals, strict=True))
    assert len(set(starts)) > 4 and len(set(goals)) > 4
    other = growth.grow_library(ROOMS, 12, QUICK, 1, "rooms", 1)
    assert [record.task for record in other.records] != [record.task for record in life.records]


def test_env1_subgoals_fall_on_the_doorways(env1):
    # The published setting on three seeds: the subgoal of each task is its newest doorway, or the cell next to it.
    for seed in range(3):
        life = learn_life(env1, tasks_of(env1, "ABCDEF"), "ptl", Parameters(), 5, "env1", seed)
        columns = [int(env1.cells[state][1]) for state in life.library.subgoals]
        assert len(columns) == 6
        width = ROOM_SIZE + 1
        assert all(abs(column - door * width) <= 1 for door, column in enumerate(columns, start=1))
        assert {int(env1.cells[state][0]) for state in life.library.subgoals} == {ROOM_SIZE // 2 + 1}


def test_method_that_gives_up_early_is_refused(monkeypatch):
    """An episode that ends short of the goal would otherwise count as a quick success."""

    class Impatient(methods.load("no_transfer")):
        label = "Impatient"

        def run_episode(self, learner):
            learner.explore(budget=3)
            return []

    monkeypatch.setattr(methods, "load", lambda name: Impatient)
    with pytest.raises(UserError, match=r"method 'Impatient': run_episode returned in episode 1 of task A before the"):
        live("impatient")


def test_a_task_that_starts_at_its_goal_is_refused(env3):
    with pytest.raises(UserError, match="task A: starts at its goal, state 3"):
        learn_life(env3, [Task("A", 3, 3)], "no_transfer", Parameters(), 1)
