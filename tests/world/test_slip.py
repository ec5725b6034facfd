"""Worlds in which steps slip: the optimum, the law of the steps, what a learner notes, and what files say."""

from __future__ import annotations

import mazes
import numpy as np
import oracles
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from ptl.agent._episodes import run_episodes
from ptl.agent._kernel import Dynamics, Learner
from ptl.agent.plan import Guide, Plan
from ptl.agent.skills import SkillLibrary
from ptl.agent.subgoals import discover
from ptl.config import Learning, MapOptions, Parameters
from ptl.errors import UserError
from ptl.learning._survey import Survey, subgoals_from
from ptl.learning.life import learn_life
from ptl.learning.survey import subgoal_frequencies
from ptl.measures.exact import first_episode_without_transfer
from ptl.world.drawing import changed_world
from ptl.world.gridworld import GridWorld
from ptl.world.map_files import load_map, read_map
from ptl.world.optimum import optimal_steps, steps_of_policy
from ptl.world.transitions import TransitionGraph

NORTH, SOUTH, WEST, EAST = range(4)
ROOMS = GridWorld.from_text("I...#....\n....#....\n.........\n....#...A\n")
SLIPS = [0.0, 0.1, 0.3, 1.0]


def learner_in(world: GridWorld, goal: int, seed: int, **options) -> Learner:
    return Learner(Dynamics(world.successors, world.slip), goal, np.random.SFC64(seed), **options)


def transitions(world: GridWorld, policy: np.ndarray) -> np.ndarray:
    """Return the matrix of a policy's transitions, (n, n)."""
    n = world.n_states
    matrix = world.slip * oracles.transition_matrix(world.successors)
    np.add.at(matrix, (np.arange(n), world.successors[np.arange(n), policy]), 1 - world.slip)
    return matrix


def hitting_times(world: GridWorld, policy: np.ndarray, goal: int) -> np.ndarray:
    """Return the expected steps to the goal, by dense linear algebra."""
    others = np.delete(np.arange(world.n_states), goal)
    system = np.eye(len(others)) - transitions(world, policy)[np.ix_(others, others)]
    return np.insert(np.linalg.solve(system, np.ones(len(others))), goal, 0.0)


# -- the world ------------------------------------------------------------------------------------------------------


def test_a_world_carries_its_slip(tmp_path):
    path = tmp_path / "rooms.txt"
    path.write_text(ROOMS.text)
    assert (ROOMS.slip, load_map(path).slip, load_map(path, slip=0.2).slip) == (0.0, 0.0, 0.2)
    assert read_map(path, MapOptions(slip=0.2, start=[2, 2])).world.slip == 0.2
    slippery = ROOMS.with_slip(0.2)
    assert (slippery.slip, slippery.text, ROOMS.slip) == (0.2, ROOMS.text, 0.0)
    assert slippery.with_slip(0.2) is slippery and "slip 0.2" in repr(slippery)
    assert GridWorld.from_text(ROOMS.text, slip=1).slip == 1.0
    assert changed_world(slippery, {"start": (1, 2)}).slip == changed_world(slippery, {"chain": {}}).slip == 0.2
    assert changed_world(slippery, {"slip": 0.3}).slip == 0.3


@pytest.mark.parametrize("slip", [-0.1, 1.1, np.nan])
def test_a_slip_is_a_probability(slip):
    for make in (ROOMS.with_slip, lambda slip: GridWorld.from_text(ROOMS.text, slip=slip)):
        with pytest.raises(ValueError, match="slip"):
            make(slip)
    with pytest.raises(ValueError, match="slip"):
        Dynamics(ROOMS.successors, slip)
    with pytest.raises(UserError, match=r"slip: .* is not allowed"):
        MapOptions(slip=slip)


# -- the optimum ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("slip", [0.0, 0.1, 0.5, 1.0])
def test_optimum_of_a_corridor_of_two_states(slip):
    """In I A the step east succeeds with 1 - 3 p / 4: the other three directions stay."""
    world = GridWorld.from_text("IA\n", slip=slip)
    assert optimal_steps(world, world.goal("A")).tolist() == pytest.approx([1 / (1 - 0.75 * slip), 0.0])


@pytest.mark.parametrize("slip", [0.1, 0.4])
def test_optimum_of_a_corridor_of_three_states(slip):
    """m0 = 1 + (1 - e) m0 + e m1 and m1 = 1 + w m0 + (1 - w - e) m1, e the chance to go east and w to go west."""
    world = GridWorld.from_text("I.A\n", slip=slip)
    east, west = 1 - 0.75 * slip, slip / 4
    first = 1 / east + (east + west) / east**2  # m1 = (1 + w m0) / (w + e) put into m0 = 1 / e + m1
    second = first - 1 / east
    assert optimal_steps(world, world.goal("A")).tolist() == pytest.approx([first, second, 0.0])


@pytest.mark.parametrize("slip", SLIPS)
def test_steps_of_a_policy_solve_the_linear_system(slip):
    world = ROOMS.with_slip(slip)
    goal = world.goal("A")
    policy = np.maximum(world.transitions.shortest_path_policy(goal), 0)
    assert steps_of_policy(world, policy, goal) == pytest.approx(hitting_times(world, policy, goal))


@settings(max_examples=40, deadline=None, derandomize=True)
@given(text=mazes.maps(goals="A", largest=8), slip=st.sampled_from(SLIPS))
def test_optimum_is_the_fixed_point_of_bellmans_equation(text, slip):
    world = GridWorld.from_text(text, slip=slip)
    goal = world.goal("A")
    best = optimal_steps(world, goal)
    assert np.array_equal(np.isinf(best), world.distances_to(goal) < 0)
    reached = np.isfinite(best) & (np.arange(world.n_states) != goal)
    after = best[world.successors][reached]
    wanted = 1 + (1 - slip) * after.min(axis=1) + slip * after.mean(axis=1)
    assert best[reached] == pytest.approx(wanted, rel=1e-7)
    assert best[goal] == 0
    if slip == 0:
        assert np.array_equal(best[reached], world.distances_to(goal)[reached])


def test_with_slip_1_the_optimum_is_the_uniform_walk():
    world = ROOMS.with_slip(1.0)
    expected = first_episode_without_transfer(world, world.goal("A"))
    assert optimal_steps(world, world.goal("A"))[world.start] == pytest.approx(expected)


def test_a_policy_that_never_arrives_takes_for_ever():
    world = GridWorld.from_text("I.A\n")
    assert steps_of_policy(world, np.array([WEST, EAST, EAST]), 2).tolist() == [np.inf, 1.0, 0.0]
    assert np.isfinite(steps_of_policy(world.with_slip(0.1), np.array([WEST, EAST, EAST]), 2)).all()


@pytest.mark.parametrize("policy", [[0, 0], [0, 0, 4], [-1, 0, 0], [0.5, 0, 0]])
def test_steps_of_no_policy_are_refused(policy):
    with pytest.raises(ValueError, match=r"a policy needs|from 0 to 3"):
        steps_of_policy(GridWorld.from_text("I.A\n"), np.array(policy), 2)


# -- the law of the steps -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("slip", SLIPS)
@pytest.mark.parametrize("call", ["act", "follow", "explore"])
def test_directions_of_an_action_have_their_frequencies(call, slip):
    """An action leads in its own direction with 1 - 3 p / 4, in each other with p / 4."""
    world = GridWorld.from_text(".....\n" * 4 + "I...A\n", slip=slip)
    n = 20_000
    learner = learner_in(world, world.goal("A"), 5, epsilon=0.0, max_steps=n, alpha=0.0, initial_q=None)
    learner.set_q(np.tile([0.0, 1.0, 0.0, 0.0], (world.n_states, 1)))
    learner.record(n)
    learner.begin_episode(2)
    counts = np.zeros(4)
    if call == "act":
        for _ in range(n):
            if learner.at_goal:
                counts += np.bincount(learner.recorded, minlength=4)
                learner.begin_episode(2)
            learner.act(SOUTH, learn=False)
    while call != "act" and counts.sum() < n:
        counts += np.bincount(learner.recorded, minlength=4)
        learner.begin_episode(2)
        if call == "follow":
            learner.follow(np.full(world.n_states, SOUTH, dtype=np.int8), budget=n)
        else:
            learner.explore(budget=n)
    counts += np.bincount(learner.recorded, minlength=4)
    expected = np.full(4, slip / 4)
    expected[SOUTH] += 1 - slip
    assert (counts[expected == 0] == 0).all()
    if slip > 0:
        assert stats.chisquare(counts, expected * counts.sum()).pvalue > 1e-3


@pytest.mark.parametrize("slip", [0.0, 0.1, 0.3])
def test_following_a_policy_takes_its_expected_steps(slip):
    world = ROOMS.with_slip(slip)
    goal = world.goal("A")
    policy = world.transitions.shortest_path_policy(goal)
    expected = hitting_times(world, np.maximum(policy, 0), goal)[world.start]
    learner = learner_in(world, goal, 3)
    steps = []
    for _ in range(3000):
        learner.begin_episode(world.start)
        learner.follow(policy, goal)
        steps.append(learner.steps)
    if slip == 0:
        assert set(steps) == {expected}
    else:
        assert abs(np.mean(steps) - expected) < 4 * np.std(steps) / np.sqrt(len(steps))


@pytest.mark.parametrize("slip", [0.1, 0.5])
@pytest.mark.parametrize("shortcut", [True, False])
def test_a_first_episode_does_not_feel_slip(slip, shortcut):
    world = ROOMS.with_slip(slip)
    goal = world.goal("A")
    expected, deviation = oracles.hitting_time(world.successors, world.start, goal)
    assert first_episode_without_transfer(world, goal) == pytest.approx(expected)
    steps = []
    for seed in range(2000):
        learner = learner_in(world, goal, seed, shortcut=shortcut)
        learner.begin_episode(world.start)
        learner.explore()
        steps.append(learner.steps)
    assert abs(np.mean(steps) - expected) < 4 * deviation / np.sqrt(len(steps))


def test_values_are_those_of_the_actions_chosen():
    """The update is that of the action; with slip 1 it says nothing, so all actions get the value of a random step."""
    world = GridWorld.from_text("IA\n", slip=1.0)
    learner = learner_in(world, 1, 7, alpha=0.01, gamma=0.5)
    for _ in range(20_000):
        learner.begin_episode(0)
        while not learner.at_goal:
            learner.act(NORTH)
    # q = 1/4 + 3/4 gamma q
    assert learner.values_of(0)[NORTH] == pytest.approx(0.25 / (1 - 0.75 * 0.5), abs=0.05)
    assert learner.values_of(0)[1:] == (0.0, 0.0, 0.0)
    assert learner.seen.tolist() == [0b1111, 0]


def test_short_and_single_steps_have_one_law():
    """Second episodes of lives with and without the shortcut, at the same slip."""
    world, goal = ROOMS.with_slip(0.3), ROOMS.goal("A")
    lengths = {}
    for shortcut in (True, False):
        seconds = []
        for seed in range(1500):
            learner = learner_in(world, goal, seed + 10_000 * shortcut, alpha=0.5, shortcut=shortcut)
            for _ in range(2):
                learner.begin_episode(world.start)
                learner.explore()
            seconds.append(learner.steps)
        lengths[shortcut] = seconds
    assert stats.ks_2samp(lengths[True], lengths[False]).pvalue > 1e-3


# -- what is learned ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("slip", [0.1, 0.5])
def test_skills_take_the_directions_of_the_steps_seen(slip):
    """The path and the skill come from where steps led, not from the actions chosen."""
    world, goal = ROOMS.with_slip(slip), ROOMS.goal("A")
    learner = learner_in(world, goal, 11, epsilon=1.0)
    _, _, _, paths = run_episodes(learner, Plan(), world.start, 20, 10)
    for path in paths:
        assert (world.successors[path[:-1]] == path[1:, None]).any(axis=1).all()
    graph = TransitionGraph(world.successors, learner.seen)
    library = SkillLibrary(novelty=0.0, threshold=0.0)
    library.update(discover(paths, graph, [], 2), graph, 0)
    [skill] = library.skills
    steps = graph.steps_to(skill.subgoal)
    defined = skill.policy >= 0
    assert defined.any() and np.array_equal(defined, steps > 0)
    after = world.successors[np.arange(world.n_states), skill.policy]
    assert (steps[after[defined]] == steps[defined] - 1).all()


def test_seen_steps_are_those_that_were_executed():
    """Under slip the learner notes the step that it made: always north is chosen, all four directions are seen."""
    world = GridWorld.from_text("...\n.I.\n..A\n", slip=0.9)
    learner = learner_in(world, world.goal("A"), 1, max_steps=10**6)
    learner.record(10**5)
    moved = np.zeros((world.n_states, 4), dtype=bool)
    for _ in range(50):
        learner.begin_episode(world.start)
        here = learner.state
        while not learner.at_goal:
            after = learner.act(NORTH)
            assert world.successors[here, learner.recorded[-1]] == after
            moved[here, learner.recorded[-1]] = True
            here = after
    assert np.array_equal(learner.seen, np.packbits(moved, axis=1, bitorder="little")[:, 0])


def test_a_lead_whose_way_is_closed_ends():
    world = GridWorld.from_text("I.A\n")
    into_the_wall = Guide(np.array([WEST, WEST, -1], dtype=np.int8), 2)
    learner = learner_in(world, 2, 1, max_steps=10**9)
    steps, truncated, _, _ = run_episodes(
        learner, Plan(draw=lambda: 0, guide=lambda _: into_the_wall, patience=5.0), world.start, 3, 1
    )
    assert not truncated.any() and (steps >= world.n_states).all()


def test_a_life_in_a_world_that_slips_differs_and_repeats():
    def steps(slip: float) -> list[int]:
        life = learn_life(ROOMS.with_slip(slip), "A", parameters=Parameters(episodes=50), root_seed=4)
        return life.records[0].steps.tolist()

    assert steps(0.1) == steps(0.1) != steps(0.0)


# -- the survey -----------------------------------------------------------------------------------------------------


def test_survey_has_the_law_of_single_steps_where_steps_slip():
    world = GridWorld.from_text("I....\n.#.#.\n....A\n", slip=0.4)
    goal, learning = world.goal("A"), {"alpha": 0.5, "gamma": 0.9, "epsilon": 0.2}
    dynamics, samples = Dynamics(world.successors, world.slip), 4000
    random = np.random.SFC64(7)
    survey = Survey(dynamics, 4, max_steps=10**7, **learning)
    drawn = [int(survey.subgoals_to(goal, [world.start], random)[0]) for _ in range(samples)]
    random = np.random.SFC64(8)
    single = [
        int(subgoals_from(dynamics, world.start, [goal], random, 4, 4, max_steps=10**7, **learning)[0][0])
        for _ in range(samples)
    ]
    counts = np.array([np.bincount(values, minlength=world.n_states) for values in (drawn, single)])
    counts = counts[:, counts.sum(axis=0) > 20]
    assert stats.chi2_contingency(counts).pvalue > 1e-3


def test_survey_takes_the_slip_of_its_world():
    def counts(slip: float) -> list[int]:
        world = ROOMS.with_slip(slip)
        found = subgoal_frequencies(world, np.array([0, 9]), range(20, 30), 5, Learning(), 1, "rooms")
        return found["counts"].tolist()

    assert counts(0.0) != counts(0.5)
