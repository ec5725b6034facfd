"""The readings of what a drawn skill does, and of what full transfer hands over."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import mazes
import numpy as np
import oracles
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from lives import QUICK, ROOMS, job, write_life

from ptl import methods
from ptl.agent import seeding
from ptl.agent._episodes import run_episodes
from ptl.agent._kernel import Dynamics, Learner
from ptl.agent.policies import values_of
from ptl.agent.reference import RandomBits, ReferenceLearner
from ptl.agent.skills import Skill, SkillLibrary
from ptl.agent.subgoals import discover
from ptl.config import Parameters, Skills
from ptl.errors import UserError
from ptl.files import store
from ptl.jobs.grow import Grow
from ptl.jobs.learn import skills_of
from ptl.learning.growth import grow_library
from ptl.learning.life import learn_life, tasks_of
from ptl.report.explorer.replay import replay
from ptl.world.gridworld import GridWorld, map_digest
from ptl.world.transitions import TransitionGraph

READINGS = ["reselect", "lead_in", "initiation_set", "mixing", "initial_values"]
VARIANTS = ["ptl", "ptl_supervised", "ptl_unknown_goal"]
CORRIDOR = GridWorld.from_text("I.......A\n")
BEHIND = GridWorld.from_text("A...I....\n")
TWO_ROOMS = GridWorld.from_text("#########\n#I..#...#\n#.......#\n#A..#..B#\n#########\n")
DOOR = TWO_ROOMS.state_at(2, 4)


def policy_to(successors: np.ndarray, subgoal: int) -> np.ndarray:
    """First action of a shortest path over all transitions."""
    return TransitionGraph(successors).shortest_path_policy(subgoal)


def with_skill(
    world: GridWorld, subgoal: int, initiation: np.ndarray | None, name: str = "ptl", **changes: Any
) -> methods.BaseMethod:
    """A method whose library holds one skill, which is always drawn unless the null skill is allowed."""
    changes = {"skills__null_skill": False, "skills__patience": 1e6, **changes}
    method = methods.load(name)(world, Parameters().replace(**changes), np.random.default_rng(3))
    assert method.library is not None
    method.library.skills.append(Skill(subgoal, policy_to(world.successors, subgoal), 0, initiation))
    return method


def first_episodes(method: methods.BaseMethod, goal: int, number: int) -> np.ndarray:
    """Steps of the first episode of a task in so many lives."""
    world, lengths = method.world, []
    for seed in range(number):
        learner = Learner(
            Dynamics(world.successors), goal, np.random.SFC64(seed), initial_q=method.begin_task(world.start, goal)
        )
        lengths.append(run_episodes(learner, method.plan(), world.start, 1, 0)[0][0])
    return np.array(lengths)


def check_mean(lengths: np.ndarray, expected: float) -> None:
    assert abs(lengths.mean() - expected) < 4 * lengths.std(ddof=1) / len(lengths) ** 0.5


def set_of(world: GridWorld, *cells: tuple[int, int]) -> np.ndarray:
    states = np.zeros(world.n_states, dtype=bool)
    states[[world.state_at(*cell) for cell in cells]] = True
    return states


# -- initiation sets


def test_an_initiation_set_holds_the_states_before_the_subgoal():
    paths = [np.array([0, 1, 2, 3, 4]), np.array([0, 5, 3, 6]), np.array([0, 7, 8]), np.array([3, 2])]
    found = discover(paths, CORRIDOR.transitions, [], 0)
    assert np.flatnonzero(found.states_before(3)).tolist() == [0, 1, 2, 5]
    assert not found.states_before(0).any()
    assert not discover([], CORRIDOR.transitions, [], 0).states_before(3).any()


@pytest.mark.parametrize("sets", [True, False])
def test_a_library_keeps_initiation_sets_if_it_is_told_to(sets):
    seen = np.full(9, 15, dtype=np.uint8)
    graph = TransitionGraph(CORRIDOR.successors, seen)
    library = SkillLibrary(novelty=0.0, threshold=0.0, initiation_sets=sets)
    assert library.update(discover([np.arange(9)] * 3, graph, [], 0), graph, 0).subgoal == 4
    initiation = library.skills[0].initiation
    assert np.flatnonzero(initiation).tolist() == [0, 1, 2, 3] if sets else initiation is None


@pytest.mark.parametrize(
    ("world", "subgoal", "initiation", "goal"),
    [
        (CORRIDOR, 4, set_of(CORRIDOR, (0, 0), (0, 2), (0, 3)), 8),
        (BEHIND, 7, set_of(BEHIND, (0, 1), (0, 2), (0, 3)), 0),  # the skill leads away from the goal
        (TWO_ROOMS, DOOR, set_of(TWO_ROOMS, (1, 1), (1, 2), (2, 2), (2, 3), (3, 3)), TWO_ROOMS.goals["B"]),
        (TWO_ROOMS, DOOR, set_of(TWO_ROOMS, (1, 1), (1, 3), (2, 1), (2, 2), (3, 1)), TWO_ROOMS.goals["A"]),
    ],
)  # fmt: skip
def test_first_episodes_under_initiation_sets_have_the_exact_mean(world, subgoal, initiation, goal):
    method = with_skill(world, subgoal, initiation, skills__skill_use="initiation_set")
    policy = policy_to(world.successors, subgoal)
    expected = oracles.led_hitting_time(world.successors, world.start, goal, policy, subgoal, initiation)
    check_mean(first_episodes(method, goal, 4000), expected)


class Watched:
    """A learner that notes where it is led from, and what is known there."""

    def __init__(self, learner: Learner) -> None:
        self.learner = learner
        self.events: list[Any] = []

    def __getattr__(self, name: str) -> Any:
        return getattr(self.learner, name)

    def follow(self, policy: np.ndarray, subgoal: int, budget: int) -> None:
        self.events.append((self.learner.state, len(set(self.learner.values_of(self.learner.state)))))
        self.learner.follow(policy, subgoal, budget)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(
    text=mazes.maps(), patience=st.sampled_from([0.02, 0.3, 2.0]), growth=st.sampled_from([1.5, 2.0]),
    name=st.sampled_from(VARIANTS), seed=st.integers(0, 2**32 - 1),
)  # fmt: skip
def test_no_state_leads_twice_and_every_episode_ends(text, patience, growth, name, seed):
    world = GridWorld.from_text(text)
    rng = np.random.default_rng(seed)
    subgoal = int(rng.integers(world.n_states))
    initiation = rng.random(world.n_states) < 0.8
    goal = list(world.goals.values())[seed % len(world.goals)]
    initiation[goal] = True  # the goal is where the skill leads away from
    changes = {"skills__patience": patience, "skills__patience_growth": growth, "skills__null_skill": seed % 2 == 0}
    method = with_skill(world, subgoal, initiation, name, skills__skill_use="initiation_set", **changes)
    method.begin_task(world.start, goal)
    learner = Watched(Learner(Dynamics(world.successors), goal, np.random.SFC64(seed), alpha=0.5))
    draw, plan = method.draw_skill, method.plan
    method.draw_skill = lambda: learner.events.append("draw") or draw()
    for _ in range(4):
        learner.events.clear()
        learner.begin_episode(world.start)
        plan().run(learner)
        assert learner.at_goal
        again = [event for before, event in zip(["", *learner.events], learner.events, strict=False)
                 if event != "draw" and before != "draw"]  # fmt: skip
        states = [state for state, _ in again]
        assert len(states) == len(set(states)) and initiation[states].all()
        assert all(values == 1 for _, values in again)


# -- the other readings


@pytest.mark.parametrize(("psi", "decay"), [(1.0, 0.95), (0.6, 0.8)])
@pytest.mark.parametrize("goal", ["A", "B"])
def test_first_episodes_with_a_mixed_skill_have_the_exact_mean(goal, psi, decay):
    changes = {"policy_reuse__psi": psi, "policy_reuse__psi_decay": decay}
    method = with_skill(TWO_ROOMS, DOOR, None, skills__skill_use="mixing", **changes)
    policy, target = policy_to(TWO_ROOMS.successors, DOOR), TWO_ROOMS.goals[goal]
    expected = oracles.mixed_hitting_time(TWO_ROOMS.successors, TWO_ROOMS.start, target, policy, DOOR, psi, decay)
    check_mean(first_episodes(method, target, 4000), expected)


def test_the_values_of_a_policy_by_hand():
    policy = np.array([3, 3, 3, -1, 2, 2, -1, 2, 3])
    q = values_of(policy, 3, CORRIDOR.successors, 0.5)
    expected = np.zeros((9, 4))
    expected[[0, 1, 2], 3] = [0.25, 0.5, 1.0]
    expected[[4, 5], 2] = [1.0, 0.5]  # 7 and 8 end where the policy is undefined
    np.testing.assert_array_equal(q, expected)
    assert not values_of(policy, None, CORRIDOR.successors, 0.5).any()
    towards = np.where(np.arange(9) == 3, 0, policy)  # a policy that is defined at its subgoal ends there too
    np.testing.assert_array_equal(values_of(towards, 3, CORRIDOR.successors, 0.5), expected)


@pytest.mark.parametrize("name", VARIANTS)
def test_initial_values_are_those_of_one_skill_for_the_whole_task(name):
    method = with_skill(CORRIDOR, 6, None, name, skills__skill_use="initial_values")
    q = method.begin_task(0, 8)
    np.testing.assert_array_equal(q, values_of(policy_to(CORRIDOR.successors, 6), 6, CORRIDOR.successors, 0.95))
    learner = Learner(Dynamics(CORRIDOR.successors), 8, np.random.SFC64(1), initial_q=q)
    plain = Learner(Dynamics(CORRIDOR.successors), 8, np.random.SFC64(1), initial_q=q)
    steps, _, drawn, _ = run_episodes(learner, method.plan(), 0, 5, 0)
    assert drawn == [[1]] * 5
    for expected in steps:
        plain.begin_episode(0)
        plain.explore()
        assert plain.steps == expected


def test_without_a_skill_initial_values_are_none():
    method = methods.load("ptl")(
        CORRIDOR, Parameters().replace(skills__skill_use="initial_values"), np.random.default_rng(0)
    )
    assert method.begin_task(0, 8) is None and method.plan().draw() == 0


# -- all readings


def parameters_of(reading: str) -> Parameters:
    return QUICK.replace(skills__skill_use=reading)


def test_every_reading_is_tested():
    assert Skills.__annotations__["skill_use"].__args__[0].__args__ == tuple(READINGS)


@pytest.mark.parametrize("reading", READINGS)
@pytest.mark.parametrize("name", VARIANTS)
def test_a_life_is_what_its_calls_are(name, reading):
    """The compiled loop of a life, `Plan.run` on the kernel and on the plain reference give the same bits."""
    parameters, tasks = parameters_of(reading), tasks_of(ROOMS, "".join(ROOMS.goals))
    life = learn_life(ROOMS, tasks, name, parameters, 1, "rooms", 0)
    learning, rates = parameters.learning, parameters.learning
    for reference in (False, True):
        method = methods.load(name)(ROOMS, parameters, seeding.generator(1, name, "rooms", 0, "choices"))
        for index, (task, record) in enumerate(zip(tasks, life.records, strict=True)):
            random = seeding.bit_generator(1, name, "rooms", 0, "steps", index)
            options = {"alpha": rates.alpha, "gamma": rates.gamma, "epsilon": rates.epsilon,
                       "initial_q": method.begin_task(task.start, task.goal)}  # fmt: skip
            learner: Any = (
                ReferenceLearner(ROOMS.successors, task.goal, RandomBits(random), **options)
                if reference
                else Learner(Dynamics(ROOMS.successors), task.goal, random, **options)
            )
            plan, steps, drawn, paths = method.plan(), [], [], []
            for _ in range(learning.episodes):
                learner.begin_episode(task.start)
                drawn.append(plan.run(learner))
                steps.append(learner.steps)
                if len(paths) < parameters.subgoals.trajectories:
                    paths.append(learner.erased_path())
            assert (steps, drawn) == (record.steps.tolist(), record.selected)
            assert learner.q.tobytes() == record.q.tobytes()
            assert np.array_equal(learner.seen, record.seen)
            graph = TransitionGraph(ROOMS.successors, learner.seen)
            known, search = method.library.subgoals, parameters.subgoals
            discovery = discover(paths, graph, known, search.cover_radius, search.distance_form)
            assert method.library.update(discovery, graph, index) == record.update
            method.end_task(learner)


@pytest.mark.parametrize("reading", READINGS)
def test_lives_of_a_reading_are_stored_and_learned_again(tmp_path, reading):
    for name in VARIANTS:
        result = store.read(write_life(tmp_path, name, parameters=parameters_of(reading)))
        assert ("initiation/sets" in result.arrays) == (reading == "initiation_set")
        skills, life = skills_of(result.arrays), learned(name, reading)
        assert skills and [skill.subgoal for skill in skills] == life.library.subgoals
        for skill, kept in zip(skills, life.library.skills, strict=True):
            assert np.array_equal(skill.initiation, kept.initiation) if reading == "initiation_set" else (
                skill.initiation is kept.initiation is None
            )  # fmt: skip
        for record, notes in zip(life.records, replay(result), strict=True):
            assert sum(steps for _, steps in notes.parts) == record.steps[0]
            guided = [candidate for candidate, _ in notes.parts]
            # exploring is one part with the initiation set and one without
            assert sum(a == b == 0 for a, b in pairwise(guided)) < 2 * len(record.selected[0])
            for chances, drawn in zip(notes.chances, record.selected, strict=True):
                assert all(chances[skill] > 0 for skill in drawn)
                assert reading != "initial_values" or chances[drawn[0]] == 1


def learned(name: str, reading: str) -> Any:
    return learn_life(ROOMS, tasks_of(ROOMS, "".join(ROOMS.goals)), name, parameters_of(reading), 1, "rooms", 0)


def test_initiation_sets_of_a_life_lead_to_their_subgoals():
    for skill in learned("ptl", "initiation_set").library.skills:
        assert skill.initiation.any() and not skill.initiation[skill.subgoal]
        assert (skill.policy[skill.initiation] >= 0).all()


def test_a_file_without_a_set_for_each_skill_is_refused(tmp_path):
    work = job("ptl", parameters=parameters_of("initiation_set"))
    arrays = work.run({"rooms": ROOMS})
    arrays["initiation/sets"] = arrays["initiation/sets"][:-1]
    with pytest.raises(UserError, match="has not one initiation set for each skill"):
        store.write(tmp_path / "x.h5", work, arrays, {"rooms": ROOMS})


@pytest.mark.parametrize("reading", READINGS)
def test_libraries_grow_under_every_reading(tmp_path, reading):
    parameters = parameters_of(reading).replace(policy_reuse__psi=0.5)
    groups = {name: values for name, values in parameters.to_dict().items() if name in Grow.READS}
    work = Grow(
        root_seed=1, parameters=groups, maps={"rooms": map_digest(ROOMS.text)}, code="0" * 16, environment="rooms",
        tasks=5, seed=0,
    )  # fmt: skip
    store.write(tmp_path / "x.h5", work, work.run({"rooms": ROOMS}), {"rooms": ROOMS})
    arrays = store.read(tmp_path / "x.h5").arrays
    life = grow_library(ROOMS, 5, parameters, 1, "rooms", 0)
    assert arrays["total_steps"].tolist() == [record.steps.sum() for record in life.records]
    assert [skill.subgoal for skill in skills_of(arrays)] == life.library.subgoals


# -- full transfer


def handed_over(hands_over: str, *learned: np.ndarray, gamma: float = 0.5) -> np.ndarray:
    parameters = Parameters().replace(full_transfer__hands_over=hands_over, learning__gamma=gamma)
    method = methods.load("full_transfer")(CORRIDOR, parameters, np.random.default_rng(0))
    for q in learned:
        method.begin_task(0, 8)
        method.end_task(Learner(Dynamics(CORRIDOR.successors), 8, np.random.SFC64(1), initial_q=q))
    return method.begin_task(0, 8)


def test_full_transfer_hands_over_by_hand():
    first, second, third = np.zeros((9, 4)), np.zeros((9, 4)), np.zeros((9, 4))
    first[0], second[0], third[0] = [0.4, 0, 0, 0.1], [0, 0, 0.2, 0.8], [0.2, 0, 0.1, 0]
    third[1], third[2] = [0.3, 0.3, 0, 0.3], [0.7, 0.7, 0.7, 0.7]
    np.testing.assert_array_equal(handed_over("latest", first, second, third), third)
    mean = handed_over("mean", first, second, third)
    np.testing.assert_allclose(mean[0], [0.2, 0, 0.1, 0.3])
    np.testing.assert_allclose(mean[1], [0.1, 0.1, 0, 0.1])
    np.testing.assert_array_equal(handed_over("mean", first), first)
    expected = np.zeros((9, 4))
    expected[0, 0] = expected[1, 0] = 0.5**9  # the first of equal actions; state 2 has none
    np.testing.assert_array_equal(handed_over("policy", first, second, third), expected)
    assert handed_over("policy", third, gamma=1e-20)[0, 0] == 1e-100


def test_nothing_is_handed_over_to_the_first_task():
    for hands_over in ("latest", "mean", "policy"):
        assert handed_over(hands_over) is None
