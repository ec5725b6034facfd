"""Maps that change between tasks: what changes, what stays, and that methods are not told."""

from __future__ import annotations

import numpy as np
import pytest

from ptl import methods
from ptl.config import Parameters
from ptl.errors import UserError
from ptl.learning.life import Task, learn_life
from ptl.world.gridworld import GridWorld
from ptl.world.map_files import load_map
from ptl.world.mazes import FAMILIES
from studies.beyond.changes import RULES, SHARE, changed_map, changing_worlds
from studies.beyond.lives import tasks_in
from studies.beyond.maps import make_map
from studies.beyond.methods import reference

WORLDS = {family: make_map(family, 300, 5) for family in FAMILIES}
ROOMS = GridWorld.from_text("#########\n#I..#...#\n#......A#\n#...#...#\n#########\n")
WIDTHS = {f"config/environments/{name}.txt": 1 for name in ("env1", "env2", "env3")}
SHORT = Parameters(episodes=10)


@pytest.fixture(scope="module", params=["env1", "env2", "env3", *FAMILIES])
def world(request):
    name = request.param
    return WORLDS[name] if name in WORLDS else load_map(f"config/environments/{name}.txt")


def grid(text: str) -> np.ndarray:
    return np.array([list(row) for row in text.splitlines()])


# -- the rules ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("rule", RULES)
def test_what_a_change_keeps(world, rule):
    """Start and goals are where they were and can be reached; the border stays; another seed gives another map."""
    text = world.text
    for seed in range(5):
        changed = changed_map(text, rule, seed)
        assert changed == changed_map(text, rule, seed)
        after = GridWorld.from_text(changed)  # refuses goals that cannot be reached
        assert (after.start >= 0) and [*after.goals] == [*world.goals]
        places = [(letter, *world.cells[state].tolist()) for letter, state in world.goals.items()]
        assert [(letter, *after.cells[state].tolist()) for letter, state in after.goals.items()] == places
        assert after.cells[after.start].tolist() == world.cells[world.start].tolist()
        different = grid(changed) != grid(text)
        assert not (different[[0, -1]].any() or different[:, [0, -1]].any())
        if rule == "cells":
            assert different.sum() == round(SHARE * world.n_states)
            assert abs(after.n_states - world.n_states) <= 1
        else:
            closed = different & (grid(changed) == "#")
            assert closed.any(axis=0).sum() == 1 or closed.any(axis=1).sum() == 1
            assert different.sum() - closed.sum() in (0, 1)
            if world.name in WIDTHS:
                assert closed.sum() == WIDTHS[world.name]
    if rule == "cells" or world.name in WIDTHS:  # a cave may have one narrowest door
        assert len({changed_map(text, rule, seed) for seed in range(8)}) > 1


def test_a_door_that_is_the_only_way_moves_along_its_wall():
    changed = {changed_map(ROOMS.text, "door", seed) for seed in range(20)}
    moved = [ROOMS.text.replace("#......A#", "#...#..A#")] * 2
    assert changed == {
        moved[0].replace("#I..#...#", "#I......#"),
        moved[1].replace("#...#...#", "#.......#"),
    }


def test_a_door_that_is_not_needed_closes():
    text = "#########\n#I......#\n#...#...#\n#......A#\n#########\n"
    closed = {text.replace("I......", "I..#..."), text.replace("......A", "...#..A")}
    assert {changed_map(text, "door", seed) for seed in range(20)} == closed


@pytest.mark.parametrize(("rule", "text"), [("door", "I..\n..A\n"), ("cells", "I..\n..A\n")])
def test_a_map_that_cannot_change_is_refused(rule, text):
    with pytest.raises(UserError, match=f"cannot change by the rule '{rule}'"):
        changed_map(text, rule, 1)


# -- numbers of states ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("rule", RULES)
def test_states_keep_their_numbers(world, rule):
    """Every map of a sequence has the same states; its moves are those of its text."""
    slippery = world.with_slip(0.1)
    sequence = changing_worlds(slippery, rule, 4, "test", 7)
    first, text = sequence[0], world.text
    for number, there in enumerate(sequence):
        if number:
            text = changed_map(text, rule, "test", 7, number)
        plain = GridWorld.from_text(text)
        assert np.array_equal(there.cells, first.cells) and there.slip == 0.1
        assert (there.start, there.goals) == (first.start, first.goals)
        state = {tuple(cell): place for place, cell in enumerate(there.cells.tolist())}
        numbers = np.array([state[tuple(cell)] for cell in plain.cells.tolist()])
        assert np.array_equal(there.successors[numbers], numbers[plain.successors])
        closed = np.setdiff1d(np.arange(there.n_states), numbers)
        assert (there.successors[closed] == closed[:, None]).all()
        assert not np.isin(there.successors[numbers], closed).any()
        distance = there.distances_to(there.start)
        assert np.array_equal(distance[numbers], plain.distances_to(plain.start)) and (distance[closed] < 0).all()


def test_start_and_goals_cannot_be_closed():
    for state in (ROOMS.start, ROOMS.goal("A")):
        with pytest.raises(UserError, match="cannot be closed"):
            ROOMS.with_closed(np.arange(ROOMS.n_states) == state)
    door = ROOMS.state_at(2, 4)
    assert ROOMS.transitions.steps_to(door)[ROOMS.start] > 0
    with pytest.raises(UserError, match="cannot be reached"):
        ROOMS.with_closed(np.arange(ROOMS.n_states) == door)


# -- lives ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "name", ["no_transfer", "ptl", "policy_reuse", "full_transfer", "all_goals", "ptl_frontier", "optimistic"]
)
@pytest.mark.parametrize("rule", RULES)
def test_methods_live_on_maps_that_change(name, rule):
    world = WORLDS["rooms"]
    tasks = tasks_in(world, "ABC", rule, 1)
    life = learn_life(world if not rule else tasks[0].world, tasks, methods.load(reference(name)), SHORT, 1, name)
    for record in life.records:
        shortest = record.task.world.shortest_path_length(record.task.start, record.task.goal)
        assert (record.steps >= shortest).all() and not record.truncated.any()


def test_a_method_is_not_told_of_a_change():
    """Until the second task begins nothing differs, and the method's map stays the first one."""
    told = []

    class Curious(methods.load("no_transfer")):
        name = "curious"

        def begin_task(self, start, goal):
            told.append(self.world)

    first, second = changing_worlds(ROOMS, "door", 2, 3)
    tasks = [Task("A", first.start, first.goal("A"), there) for there in (first, second)]
    learn_life(first, tasks, Curious, SHORT)
    assert told == [first, first]


def test_a_task_on_a_map_with_other_states_is_refused():
    other = GridWorld.from_text("I.A\n")
    with pytest.raises(UserError, match=r"task A: its map has 3 states, that of the life 19"):
        learn_life(ROOMS, [Task("A", ROOMS.start, ROOMS.goal("A"), other)], "no_transfer", SHORT)


def test_a_memory_holds_the_newest_transitions():
    """all_goals plans over what it saw last: a door found closed is closed, one that opened unseen is not open."""
    first, second = changing_worlds(ROOMS, "door", 2, 3)
    method = methods.load(reference("all_goals"))
    made = []

    def make(*arguments):
        made.append(method(*arguments))
        return made[0]

    make.name, make.__module__ = "all_goals_kept", __name__
    tasks = [Task("A", first.start, first.goal("A"), there) for there in (first, second)]
    learn_life(first, tasks, make, Parameters(episodes=40))
    [agent] = made
    door = first.state_at(2, 4)
    west = first.state_at(2, 3)
    assert agent.after[west, 3] == west and (agent.graph.successors[west, 3] == door)
    goal = first.goal("A")
    from_start = second.distances_to(goal)[first.start]
    agent.begin_task(first.start, goal)
    assert agent.graph.steps_to(goal)[first.start] == from_start
