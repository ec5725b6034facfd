"""The exhaustive survey of subgoals gives the same results as single tasks."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from scipy import stats

from ptl.agent import seeding
from ptl.agent._kernel import Dynamics, Learner
from ptl.agent.reference import RandomBits, ReferenceLearner
from ptl.agent.subgoals import fd_metric
from ptl.config import Learning
from ptl.errors import UserError
from ptl.learning._survey import NO_SUBGOAL, Survey, subgoals_from
from ptl.learning.starts import chosen_starts
from ptl.learning.survey import add_up, subgoal_frequencies
from ptl.world.gridworld import GridWorld

ROOMS = GridWorld.from_text("#########\n#I..#...#\n#.......#\n#...#..A#\n#########\n")


def one_by_one(world: GridWorld, start: int, goals, bit_generator, trajectories: int) -> list[int]:
    """The same tasks through the plain reference and the plain metric, on one stream of random numbers."""
    subgoals = []
    random = RandomBits(bit_generator)
    for goal in goals:
        learner = ReferenceLearner(world.successors, int(goal), random)
        paths = []
        while len(paths) < trajectories:
            learner.begin_episode(start)
            learner.explore()
            paths.append(learner.erased_path())
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


def test_ties_that_go_to_the_first_action_are_simulated_step_by_step():
    learning = Learning(ties="first", epsilon=0.6)
    goal, counts = ROOMS.goals["A"], Counter()
    random = seeding.bit_generator(1, "subgoal_frequencies", "rooms", goal)
    total = 0
    for start in range(ROOMS.n_states):
        if start == goal:
            continue
        learner, paths = Learner(Dynamics(ROOMS.successors), goal, random, epsilon=0.6, ties="first"), []
        for _ in range(5):
            learner.begin_episode(start)
            learner.explore()
            total += learner.steps
            paths.append(learner.erased_path())
        metric = fd_metric(paths, ROOMS.n_states).product
        counts[int(metric.argmax()) if metric.any() else "unresolved"] += 1
    got = subgoal_frequencies(ROOMS, np.arange(ROOMS.n_states), [goal], 5, learning, 1, "rooms")
    assert {state: count for state, count in enumerate(got["counts"].tolist()) if count} == {
        state: count for state, count in counts.items() if state != "unresolved"
    }
    assert (got["unresolved"], got["simulated_steps"]) == (counts["unresolved"], total)


def test_counts_add_up_and_do_not_depend_on_batches():
    n = ROOMS.n_states
    everywhere = np.arange(n)
    whole = subgoal_frequencies(ROOMS, everywhere, range(n), 5, Learning(), 1, "rooms")
    parts = [
        subgoal_frequencies(ROOMS, everywhere, range(n)[batch::3], 5, Learning(), 1, "rooms") for batch in range(3)
    ]
    for name, value in add_up(parts).items():
        np.testing.assert_array_equal(value, whole[name])
    assert whole["pairs"] == n * (n - 1) and whole["counts"].sum() + whole["unresolved"] == whole["pairs"]
    adjacent = sum(len(set(row) - {state}) for state, row in enumerate(ROOMS.successors.tolist()))
    # Adjacent cells leave no state in between unless an early episode made a detour.
    assert 0 < whole["unresolved"] <= adjacent
    assert whole["counts"].argmax() in {ROOMS.state_at(2, column) for column in (3, 4, 5)}


def test_survey_refuses_what_does_not_succeed():
    with pytest.raises(UserError, match=r"learning\.max_steps"):
        subgoal_frequencies(ROOMS, np.array([0]), range(1, 9), 5, Learning(max_steps=1), 1, "rooms")


# -- trees against the exact distribution --------------------------------------------------------------------

LEVEL = 0.001
"""Probability that a test of this file rejects a true distribution; seeds are fixed, so it does so always or never."""

TWO_ROOMS = GridWorld.from_text("########\n#I.#...#\n#......#\n#..#..A#\n########\n")
RING = GridWorld.from_text("I...\n.##.\n.##.\n...A\n")
DEAD_ENDS = GridWorld.from_text("....\nI...\n#.#.\n..#A\n.#..\n")


def surveyed(
    world: GridWorld, start: int, goal: int, samples: int, episodes: int, margin: int = 2, **learning
) -> list[int]:
    """Subgoals of independent tasks, each with its own trees."""
    random = np.random.SFC64(7)
    survey = Survey(Dynamics(world.successors), episodes, margin=margin, max_steps=10**7, **learning)
    return [int(survey.subgoals_to(goal, [start], random)[0]) for _ in range(samples)]


def path_distribution(world: GridWorld, policy: np.ndarray, start: int, goal: int) -> dict[tuple[int, ...], float]:
    """The probability of each loop-erased path of a walk under a fixed policy.

    A path is left for good at each of its states in turn; before that the walk may return to the state without the
    goal and the path so far: a Green function, from a linear system, times the probability of the move.
    """
    n = world.n_states
    connected = np.flatnonzero(world.distances_to(goal) >= 0).tolist()
    moves = np.zeros((n, n))
    np.add.at(moves, (np.arange(n)[:, None], world.successors), policy)
    distribution: dict[tuple[int, ...], float] = {}

    def go_on(path: list[int], probability: float) -> None:
        here = path[-1]
        if here == goal:
            distribution[tuple(path)] = probability
            return
        free = [state for state in connected if state != goal and state not in path[:-1]]
        visits = np.linalg.solve(np.eye(len(free)) - moves[np.ix_(free, free)], np.eye(len(free)))
        stay = visits[free.index(here), free.index(here)]
        for after in set(world.successors[here].tolist()) - set(path):
            go_on([*path, after], probability * stay * moves[here, after])

    go_on([start], 1.0)
    return distribution


def after_path(world: GridWorld, path: tuple[int, ...], policy: np.ndarray, epsilon: float) -> np.ndarray:
    """The policy after an episode with gamma = 0: only moves into the goal are known, the first one stays greedy."""
    policy = policy.copy()
    last, goal = path[-2], path[-1]
    (action,) = np.flatnonzero(world.successors[last] == goal)
    policy[last] = epsilon / 4
    policy[last, action] += 1 - epsilon
    return policy


def subgoal_distribution(world: GridWorld, start: int, goal: int, episodes: int, epsilon: float) -> dict[int, float]:
    """The exact distribution of the subgoal for gamma = 0, over all tuples of paths."""
    distribution: dict[int, float] = {}

    def go_on(paths: list[tuple[int, ...]], policy: np.ndarray, probability: float) -> None:
        if len(paths) == episodes:
            metric = fd_metric([np.array(path) for path in paths], world.n_states).product
            subgoal = int(metric.argmax()) if metric.any() else NO_SUBGOAL
            distribution[subgoal] = distribution.get(subgoal, 0.0) + probability
            return
        for path, chance in path_distribution(world, policy, start, goal).items():
            go_on([*paths, path], after_path(world, path, policy, epsilon), probability * chance)

    go_on([], np.full((world.n_states, 4), 0.25), 1.0)
    return distribution


def pooled(counts: np.ndarray, expected: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Both with all cells where fewer than 10 are expected in one."""
    few = expected < 10
    if not few.any():
        return counts, expected
    return np.append(counts[~few], counts[few].sum()), np.append(expected[~few], expected[few].sum())


@pytest.mark.parametrize("world", [TWO_ROOMS, RING, DEAD_ENDS], ids=["rooms", "ring", "dead ends"])
@pytest.mark.parametrize("episodes", [1, 2])
def test_subgoals_with_trees_have_the_exact_distribution(world: GridWorld, episodes: int):
    start, goal, samples = world.start, world.goals["A"], 4000
    distribution = subgoal_distribution(world, start, goal, episodes, 0.3)
    assert sum(distribution.values()) == pytest.approx(1.0)
    found = Counter(surveyed(world, start, goal, samples, episodes, margin=1, alpha=0.5, gamma=0.0, epsilon=0.3))
    assert set(found) <= set(distribution)
    counts = np.array([found[subgoal] for subgoal in distribution])
    counts, expected = pooled(counts, samples * np.array(list(distribution.values())))
    assert len(expected) >= 2
    assert stats.chisquare(counts, expected).pvalue > LEVEL


@pytest.mark.parametrize("world", [TWO_ROOMS, DEAD_ENDS], ids=["rooms", "dead ends"])
def test_trees_are_used_where_the_exact_distribution_is_tested(world: GridWorld):
    survey = Survey(Dynamics(world.successors), 2, margin=1, alpha=0.5, gamma=0.0, epsilon=0.3, max_steps=10**7)
    survey.subgoals_to(world.goals["A"], [world.start], np.random.SFC64(1))
    first = Survey(Dynamics(world.successors), 1, margin=1, alpha=0.5, gamma=0.0, epsilon=0.3, max_steps=10**7)
    first.subgoals_to(world.goals["A"], [world.start], np.random.SFC64(1))
    assert survey.steps_of_trees > first.steps_of_trees > 0


# -- trees against every step simulated ----------------------------------------------------------------------

PUBLISHED = {"alpha": 0.05, "gamma": 0.95, "epsilon": 0.1}
FAST = {"alpha": 1.0, "gamma": 0.95, "epsilon": 0.1}
"""With this rate one episode may spread what is known over the whole map, so that trees are dropped midway."""


@pytest.mark.parametrize(
    ("place", "letter", "episodes", "samples", "learning"),
    [
        ("env1", "A", 5, 600, PUBLISHED),
        ("env2", "D", 8, 800, PUBLISHED),
        ("env3", "A", 12, 600, PUBLISHED),
        ("env2", "F", 4, 3000, FAST),
        ("rooms", "A", 3, 5000, FAST),
    ],
)
def test_subgoals_with_trees_and_step_by_step_agree(published_maps, place, letter, episodes, samples, learning):
    world = {**published_maps, "rooms": TWO_ROOMS}[place]
    start, goal = world.start, world.goals[letter]
    margin = 1 if learning is FAST else 2
    trees = Counter(surveyed(world, start, goal, samples, episodes, margin=margin, **learning))
    every_step, _ = subgoals_from(
        Dynamics(world.successors),
        start,
        [goal] * samples,
        np.random.SFC64(8),
        episodes,
        episodes,
        max_steps=10**7,
        **learning,
    )
    steps = Counter(every_step.tolist())
    cells = sorted(set(trees) | set(steps))
    table = np.array([[trees[cell] for cell in cells], [steps[cell] for cell in cells]])
    few = table.sum(axis=0) < 20
    table = np.column_stack([table[:, ~few], table[:, few].sum(axis=1)])
    table = table[:, table.sum(axis=0) > 0]
    assert table.shape[1] >= 2
    assert stats.chi2_contingency(table).pvalue > LEVEL


def test_most_steps_are_not_simulated(env1: GridWorld):
    goal, starts = env1.goals["F"], np.arange(0, env1.goals["F"], 20)
    survey = Survey(Dynamics(env1.successors), 30, max_steps=10**7, **PUBLISHED)
    survey.subgoals_to(goal, starts, np.random.SFC64(0))
    simulated = sum(
        subgoals_from(Dynamics(env1.successors), start, [goal], np.random.SFC64(1), 30, 300, max_steps=10**7,
                      **PUBLISHED)[1]
        for start in starts
    )  # fmt: skip
    assert survey.steps < simulated / 10


def test_the_memory_of_trees_is_bounded(env2: GridWorld):
    """Trees beyond the limit are felled and drawn again."""
    goal, starts = env2.goals["F"], np.arange(40)
    plenty = Survey(Dynamics(env2.successors), 30, max_steps=10**7, **PUBLISHED)
    little = Survey(Dynamics(env2.successors), 30, max_steps=10**7, memory=10**4, **PUBLISHED)
    for survey in (plenty, little):
        survey.subgoals_to(goal, starts, np.random.SFC64(0))
    assert little.held <= 10**4 + 10 * env2.n_states < plenty.held
    assert little.steps_of_trees > plenty.steps_of_trees


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ({"trajectories": 0}, "trajectories must be a whole number from 1"),
        ({"trajectories": 2.5}, "trajectories must be a whole number from 1"),
        ({"margin": 0}, "margin must be a whole number from 1"),
        ({"goal": 99}, "goal must be a whole number from 0"),
        ({"starts": [[1]]}, "starts must be a sequence of states"),
        ({"starts": [-1]}, "starts must be whole numbers from 0"),
        ({"starts": [0], "goal": 0}, "start and goals must be different states"),
        ({"successors": [[0, 0, 0, 0], [0, 1, 1, 1]]}, "the move from state 1 by action 0 cannot be taken back"),
        ({"successors": [[0, 0, 0, 0], [1, 1, 1, 1]]}, "there is no way from start 1 to goal 0"),
    ],
)
def test_a_survey_checks_its_arguments(arguments, says):
    given = {"successors": ROOMS.successors, "trajectories": 3, "margin": 2, "goal": 0, "starts": [1], **arguments}
    with pytest.raises(ValueError, match=says):
        Survey(
            Dynamics(np.array(given["successors"])), given["trajectories"], margin=given["margin"], max_steps=100,
            **PUBLISHED,
        ).subgoals_to(given["goal"], given["starts"], np.random.SFC64(0))  # fmt: skip


# -- streams -------------------------------------------------------------------------------------------------


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
