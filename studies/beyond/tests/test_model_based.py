"""Rivals that plan: R-max in all its forms, and the plan in the free space."""

from __future__ import annotations

import numpy as np
import pytest
from mazes import random_world

from ptl import methods
from ptl.agent._kernel import Dynamics
from ptl.config import Parameters
from ptl.learning.life import learn_life, learn_task, tasks_of
from ptl.world.gridworld import GridWorld
from ptl.world.optimum import optimal_steps
from ptl.world.transitions import TransitionGraph
from studies.beyond.methods import reference
from studies.beyond.methods._model import UNTRIED, Model

FEW = Parameters().replace(learning__episodes=30)
NORTH, SOUTH, WEST, EAST = range(4)
RING = GridWorld.from_text("I...\n.##.\n.##B\n...A\n", "ring")
FORGOTTEN = {1: "rmax", 2: "rmax_2", 5: "rmax_5", 10: "rmax_10"}
KEPT = {1: "rmax_memory", 2: "rmax_memory_2", 5: "rmax_memory_5", 10: "rmax_memory_10"}
GAMMA = 0.95


def steps_of(name: str, world: GridWorld, seed: int, tasks: str, parameters: Parameters = FEW) -> list[np.ndarray]:
    return [
        record.steps for record in learn_life(world, tasks_of(world, tasks), reference(name), parameters, seed).records
    ]


def make(name: str, world: GridWorld, seed: int = 0) -> methods.BaseMethod:
    return methods.load(reference(name))(world, Parameters(), np.random.default_rng(seed))


def taught(transitions: dict[tuple[int, int], dict[int, int]], n_states: int, visits: int = 1) -> Model:
    """Return a model that has seen these numbers of outcomes of each pair."""
    model = Model(n_states, visits)
    for (state, action), outcomes in transitions.items():
        for after, number in outcomes.items():
            for _ in range(number):
                model.note(state, action, after)
    return model


# -- the model


@pytest.mark.parametrize("visits", [1, 3])
@pytest.mark.parametrize("seed", range(4))
def test_every_exploration_is_a_shortest_way_to_an_unknown_pair(seed, visits):
    """Against a graph search over the known pairs, until all are known."""
    world = random_world(np.random.default_rng(seed))
    model, random, state = Model(world.n_states, visits), np.random.default_rng(seed), world.start
    tries = np.zeros((world.n_states, 4), dtype=int)
    reachable = world.distances_to(world.start) >= 0
    while (way := model.way_to_unknown(state, random)) is not None:
        known = tries >= visits
        np.testing.assert_array_equal(model.unknown, ~known)
        bits = np.packbits(known, axis=1, bitorder="little")[:, 0]
        steps = TransitionGraph(world.successors, bits).steps_from([state])
        assert model.steps_from(state).tolist() == steps.tolist()
        assert len(way) == steps[(steps >= 0) & ~known.all(axis=1)].min() + 1
        for action in way:
            origin, state = state, int(world.successors[state, action])
            model.note(origin, action, state)
            tries[origin, action] += 1
        assert not known[origin, way[-1]]
    assert (tries[reachable] >= visits).all() and not tries[~reachable].any()
    for goal in np.flatnonzero(reachable):
        assert len(model.way_to(world.start, goal)) == world.shortest_path_length(world.start, goal)


@pytest.mark.parametrize("seed", range(5))
def test_the_plan_is_the_best_policy_of_the_counted_world(seed):
    """Against policy iteration with exact values."""
    random = np.random.default_rng(seed)
    n_states, goal = 12, 11
    counts = random.integers(0, 5, (n_states, 4, n_states)) * (random.random((n_states, 4, n_states)) < 0.3)
    counts[:, :, 0] += counts.sum(axis=2) == 0
    counts[[3, goal]] = 0  # in state 3 nothing was tried
    model = taught(
        {
            (s, a): {after: int(n) for after, n in enumerate(counts[s, a]) if n}
            for s in range(goal)
            if s != 3
            for a in range(4)
        },
        n_states,
    )
    policy = model.policy_to(goal, GAMMA)
    share = counts / np.maximum(counts.sum(axis=2, keepdims=True), 1)
    best = share[:, :, goal].argmax(axis=1)
    for _ in range(n_states**4):
        values = exact_values(share, best, goal)
        of_actions = share @ np.where(np.arange(n_states) == goal, 1.0, GAMMA * values)
        better = np.where(of_actions.max(axis=1) > values + 1e-12, of_actions.argmax(axis=1), best)
        if (better == best).all():
            break
        best = better
    led = np.flatnonzero(policy >= 0)
    assert goal not in led and 3 not in led and len(led) > n_states / 2
    np.testing.assert_allclose(of_actions[led, policy[led]], values[led], rtol=5e-3)


def exact_values(share: np.ndarray, policy: np.ndarray, goal: int) -> np.ndarray:
    """Return the values of a policy, 1 for a step into the goal, from a linear system."""
    chosen = share[np.arange(len(share)), policy]
    return np.linalg.solve(np.eye(len(share)) - GAMMA * chosen * (np.arange(len(share)) != goal), chosen[:, goal])


def test_a_plan_prefers_the_sure_way_if_it_is_short_enough():
    """East reaches the goal in one step with probability q, else it stays: worth q / (1 - 0.95 (1 - q)).

    South and then east take two certain steps, worth 0.95, and q / (1 - 0.95 (1 - q)) = 0.95 at q = 0.4871.
    """
    for successes, best in ((487, SOUTH), (488, EAST)):
        model = taught({(0, EAST): {2: successes, 0: 1000 - successes}, (0, SOUTH): {1: 1}, (1, EAST): {2: 1}}, 3)
        plan = model.policy_to(2, GAMMA)
        assert plan.tolist() == [best, EAST, -1]


def test_a_rare_outcome_is_no_plan_but_counts_in_one():
    """From 0, east usually stays and led to the goal once: nobody knows whether it will again."""
    model = taught({(0, EAST): {0: 3, 2: 1}, (1, WEST): {0: 2, 2: 3}}, 3)
    assert model.policy_to(2, GAMMA).tolist() == [-1, WEST, -1]
    value = 0.25 / (1 - GAMMA * 0.75)
    np.testing.assert_allclose(model._values[:2], [value, 0.6 + 0.4 * GAMMA * value], rtol=5e-3)


def test_a_goal_out_of_reach_has_no_plan():
    model = taught({(0, EAST): {1: 1, 0: 1}, (1, WEST): {0: 1}}, 3)
    assert model.policy_to(2, GAMMA).tolist() == [-1, -1, -1]


def test_a_known_pair_forgets_what_has_become_false():
    """Seven tries led to 1; then m = 3 tries one after another have to lead to 0 before they replace them."""
    models = [Model(2, visits=3, forgets=forgets) for forgets in (True, False)]
    for model in models:
        for after in [1] * 7 + [0, 0, 1, 0, 0]:
            model.note(0, EAST, after)
        assert model.pairs[0][EAST].outcomes == {1: 8, 0: 4} and model.pairs[0][EAST].usual == 1
        model.note(0, EAST, 0)
    forgetful, stubborn = (model.pairs[0][EAST] for model in models)
    assert forgetful.outcomes == {0: 3} and forgetful.usual == 0
    assert stubborn.outcomes == {1: 8, 0: 5} and stubborn.usual == 1
    assert models[0].route_to(1).tolist() == [-1, -1] and models[1].route_to(1).tolist() == [EAST, -1]
    models[0].note(0, EAST, 0)
    assert forgetful.outcomes == {0: 4} and not models[0].unknown[0, EAST]


def test_with_one_visit_the_last_try_counts():
    model = Model(3, forgets=True)
    assert model.pairs[0][EAST].usual == UNTRIED
    for after in (1, 2, 2, 0):
        model.note(0, EAST, after)
        assert model.pairs[0][EAST].usual == after and list(model.pairs[0][EAST].outcomes) == [after]
    assert not model.unknown[0, EAST]


def test_doubt_tries_bumps_once_more_and_then_everything():
    """In a corridor of two cells with m = 2: six of the eight pairs are bumps."""
    model = taught({(0, a): {1 if a == EAST else 0: 2} for a in range(4)}, 2, visits=2)
    for action in range(4):
        for _ in range(2):
            model.note(1, action, 0 if action == WEST else 1)
    assert model.way_to_unknown(0, np.random.default_rng(1)) is None
    model.doubt()
    assert np.argwhere(~model.unknown).tolist() == [[0, EAST], [1, WEST]]
    model.note(0, NORTH, 1)
    assert not model.unknown[0, NORTH] and model.pairs[0][NORTH].usual == 1 and model.visits == 2
    model.doubt()
    assert model.unknown.all() and model.visits == 4
    for _ in range(2):
        model.note(0, EAST, 1)
    assert np.argwhere(~model.unknown).tolist() == [[0, EAST]] and model.pairs[0][EAST].outcomes == {1: 4}


# -- R-max


def test_rmax_costs_what_it_must_beside_the_goal():
    """From the cell before the goal the four actions are tried in random order: 1 to 4 steps, equally often."""
    world = GridWorld.from_text("IA\n")
    firsts = [steps_of("rmax", world, seed, "A", FEW.replace(learning__episodes=2))[0] for seed in range(400)]
    assert {second for _, second in firsts} == {1}
    counts = np.bincount([first for first, _ in firsts], minlength=5)
    assert abs(counts[1:] - 100).max() < 4 * np.sqrt(400 * 1 / 4 * 3 / 4) and counts.sum() == counts[1:].sum()


@pytest.mark.parametrize("visits", FORGOTTEN)
def test_beside_the_goal_an_action_is_believed_after_m_tries(visits):
    """In a corridor of one cell, 4 m tries at most are spent before the goal's action is known."""
    world = GridWorld.from_text("IA\n")
    for seed in range(20):
        [steps] = steps_of(FORGOTTEN[visits], world, seed, "A")
        assert steps[visits:].tolist() == [1] * (30 - visits)
        assert visits <= steps[:visits].sum() <= 4 * visits


@pytest.mark.parametrize("visits", FORGOTTEN)
def test_rmax_forgets_and_its_other_form_does_not(visits):
    forgotten, kept = (
        np.array([[steps[0] for steps in steps_of(names[visits], RING, seed, "ABA")] for seed in range(20)])
        for names in (FORGOTTEN, KEPT)
    )
    shortest = RING.shortest_path_length(RING.start, RING.goal("A"))
    assert (forgotten[:, 2] > shortest).mean() > 0.9
    # the path first found may be the longer way round the ring, not more
    assert kept[:, 2].max() <= shortest + 4
    assert len(set(steps_of(KEPT[visits], RING, 3, "ABA")[2])) == 1


@pytest.mark.parametrize("name", ["rmax_memory_2", "rmax_memory_5", "rmax_10", "free_space"])
def test_a_planner_is_near_the_best_policy_where_steps_slip(name):
    world = random_world(np.random.default_rng(3)).with_slip(0.2)
    goal = world.goal("F")
    [steps] = steps_of(name, world, 5, "F", FEW.replace(learning__episodes=400))
    best, late = optimal_steps(world, goal)[world.start], steps[100:]
    assert late.mean() < 1.15 * best + 4 * late.std() / np.sqrt(len(late))


def closed(world: GridWorld, state: int, action: int) -> Dynamics:
    """Return the dynamics of a map with a door closed between a state and the one that an action leads to."""
    successors = np.array(world.successors)
    other = successors[state, action]
    successors[state, action], successors[other, action ^ 1] = state, other
    return Dynamics(successors)


@pytest.mark.parametrize("visits", KEPT)
def test_a_kept_model_survives_a_door_that_closes(visits):
    """The short way round the ring is closed after 30 episodes: m tries at the door, then the other way."""
    task, state = tasks_of(RING, "A")[0], RING.start
    # B lies on the eastern way, which has the same length as the western one; close the one that the method takes
    for seed in range(5):
        method = make(KEPT[visits], RING, seed)
        stream = np.random.SFC64(seed)
        before = learn_task(RING, Dynamics(RING.successors), task, method, FEW, stream)
        assert before.steps[-1] == 6
        action = method.model.policy_to(task.goal, GAMMA)[state]
        after = learn_task(RING, closed(RING, state, int(action)), task, method, FEW, stream)
        # m tries at the door; if the other way is not known yet, its actions are tried m times each
        assert 6 + visits <= after.steps[0] <= 6 + visits + 4 * 12 * visits
        assert after.steps[visits:].tolist() == [6] * (30 - visits)


@pytest.mark.parametrize("visits", KEPT)
def test_a_kept_model_finds_a_door_that_opens_where_a_wall_was(visits):
    """The only way is closed and another one opens: m tries at the old door, and one try of each wall at most."""
    world = GridWorld.from_text("I..#\n##.#\nA..#\n", "bend")
    task, stream = tasks_of(world, "A")[0], np.random.SFC64(1)
    method = make(KEPT[visits], world)
    learn_task(world, Dynamics(world.successors), task, method, FEW, stream)
    # states: 0 1 2 / 3 / 4 (A) 5 6; from 3 to 6 is closed, from 1 to 5 opens
    successors = np.array(world.successors)
    successors[3, SOUTH], successors[6, NORTH], successors[1, SOUTH], successors[5, NORTH] = 3, 6, 5, 1
    steps = learn_task(world, Dynamics(successors), task, method, FEW, stream).steps
    assert steps[0] <= 3 + visits + 4 * 4 * 4
    assert steps[visits:].tolist() == [3] * (30 - visits)


def test_a_model_that_never_forgets_stays_at_the_door():
    """What was counted 30 times must be outnumbered before the plan changes."""
    task, stream = tasks_of(RING, "A")[0], np.random.SFC64(1)
    method = make("rmax_memory_5_stubborn", RING)
    learn_task(RING, Dynamics(RING.successors), task, method, FEW, stream)
    action = int(method.model.policy_to(task.goal, GAMMA)[RING.start])
    tries = method.model.pairs[RING.start][action].tries
    after = learn_task(RING, closed(RING, RING.start, action), task, method, FEW, stream)
    assert tries > 15 and after.steps.sum() > 30 * 6 + tries


def test_the_directed_form_tries_first_what_leads_nearest_to_the_goal():
    """From I the goal lies in the east; then, in the order of straight lines, around the wall."""
    world = GridWorld.from_text("...\nI#A\n...\n")
    method = make("rmax_directed", world)
    method.begin_task(world.start, world.goal("A"))
    # states: 0 1 2 / 3 (start), 4 (goal) / 5 6 7
    assert method.way(3) == [EAST]
    method.model.note(3, EAST, 3)
    assert {tuple(method.way(3)) for _ in range(40)} == {(NORTH,), (SOUTH,)}
    method.model.note(3, NORTH, 0)
    # east of 0 is one column nearer than south of 3
    assert method.way(0) == [EAST]
    method.model.note(0, EAST, 1)
    # north-east of the goal and the wall south of 1 are equally near to it
    assert {tuple(method.way(1)) for _ in range(40)} == {(EAST,), (SOUTH,)}
    method.model.note(1, SOUTH, 1)
    assert method.way(3) == [NORTH, EAST, EAST]


# -- the free space


def test_a_plan_in_free_space_by_hand():
    """One step into the wall, then around it; the second time without it, and in the next task if walls are kept."""
    world = GridWorld.from_text("I#A\n...\nB..\n")
    few = FEW.replace(learning__episodes=3)
    [first, _, third] = steps_of("free_space", world, 1, "ABA", few)
    assert first.tolist() == third.tolist() == [5, 4, 4]
    [first, _, third] = steps_of("free_space_memory", world, 1, "ABA", few)
    assert (first.tolist(), third.tolist()) == ([5, 4, 4], [4, 4, 4])


@pytest.mark.parametrize("seed", range(8))
def test_a_plan_without_a_surprise_is_a_shortest_path(seed):
    world = random_world(np.random.default_rng(seed))
    for name in ("free_space", "free_space_memory"):
        for letter, steps in zip("ABCDEF", steps_of(name, world, seed, "ABCDEF"), strict=True):
            assert steps[-1] == world.shortest_path_length(world.start, world.goal(letter))


def test_a_step_that_slips_leaves_no_wall_for_ever():
    """In a corridor a plan that believed every failure would end; all walls are then forgotten."""
    world = GridWorld.from_text("I......A\n", slip=0.4)
    for seed in range(20):
        [steps] = steps_of("free_space", world, seed, "A")
        assert steps.max() < 200
