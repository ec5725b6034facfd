"""The compiled kernel: the same bits as the plain-Python reference, and the distributions given by theory."""

from __future__ import annotations

import doctest
import inspect
import re
from collections import Counter

import mazes
import numpy as np
import oracles
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from projects import MAPS
from scipy import stats

from ptl.agent import reference
from ptl.agent._kernel import Dynamics, Learner
from ptl.agent.reference import RandomBits, ReferenceLearner, erase_loops
from ptl.world.gridworld import GridWorld
from ptl.world.map_files import load_map

PUBLISHED = ["env1", "env2", "env3"]
HITTING_TIMES = {  # mean length of a first episode of tasks A..F, of the published and of the fitted maps
    "env1": [3473, 6682, 11437, 17736, 25580, 34969],
    "env2": [2575, 2864, 3564, 4630, 5206, 5312],
    "fitted/env1": [4544, 9130, 16000, 25156, 36597, 50322],
    "fitted/env2": [3476, 3841, 4701, 6006, 6189, 6313],
    "env3": [4738, 5604, 8115, 9920, 8550, 8250],
}

# The goal is three steps from the nearest cell where walking is cold, so both ways of stepping are in play.
SMALL_MAP = GridWorld.from_text("I....\n.#.#.\n....A\n")
CORNERED = GridWorld.from_text("I...\n.#..\n....\n#..A\n")


# -- both learners side by side ------------------------------------------------------------------------------


class Pair:
    """The kernel and the reference on one task, fed from equal streams; every call is checked at once."""

    def __init__(self, world: GridWorld, goal: int, seed: int, recorded: int = 0, slip: float = 0.0, **options) -> None:
        self.kernel = Learner(Dynamics(world.successors, slip), goal, np.random.SFC64(seed), **options)
        self.kernel.record(recorded)
        self.recorded = recorded
        random = RandomBits(np.random.SFC64(seed))
        self.reference = ReferenceLearner(world.successors, goal, random, slip=slip, **options)
        self.successors = world.successors

    def __call__(self, call: str, *arguments, **options) -> None:
        getattr(self.kernel, call)(*arguments, **options)
        getattr(self.reference, call)(*arguments, **options)
        self.check(f"{call} {arguments} {options}")

    def check(self, call: str) -> None:
        kernel, reference = self.kernel, self.reference
        for name in ("state", "steps", "at_goal", "truncated"):
            assert getattr(kernel, name) == getattr(reference, name), f"{name} after {call}"
        assert kernel.recorded.tolist() == reference.directions[: self.recorded], f"directions after {call}"
        path, expected = kernel.erased_path(), reference.erased_path()
        assert path.dtype == np.int32
        assert path.tolist() == expected.tolist(), f"erased path after {call}"
        check_path(path, self.successors, reference.trajectory[0], kernel.state)
        assert kernel.seen.dtype == np.uint8
        assert np.array_equal(kernel.seen, reference.seen), f"seen after {call}"
        assert kernel.transitions.dtype == np.int32
        assert np.array_equal(kernel.transitions, reference.transitions), f"transitions after {call}"
        q = kernel.q
        assert q.shape == self.successors.shape and q.dtype == np.float64
        assert q.tobytes() == reference.q.tobytes(), f"Q after {call}"
        assert q.min() >= 0.0 and q.max() <= 1.0


def check_path(path: np.ndarray, successors: np.ndarray, start: int, state: int) -> None:
    assert (path[0], path[-1]) == (start, state)
    assert len(set(path.tolist())) == len(path)
    assert (successors[path[:-1]] == path[1:, np.newaxis]).any(axis=1).all()


def random_policy(rng: np.random.Generator, n_states: int, undefined: float) -> np.ndarray:
    policy = rng.integers(0, 4, n_states, dtype=np.int8)
    policy[rng.random(n_states) < undefined] = -1
    return policy


def policy_to(successors: np.ndarray, goal: int) -> np.ndarray:
    """First action of a shortest path, -1 where there is none and at the goal."""
    distance = oracles.distances(successors)[:, goal]
    best = np.argmin(distance[successors], axis=1).astype(np.int8)
    best[np.isinf(distance) | (distance == 0)] = -1
    return best


INITIAL_Q = {
    "none": lambda rng, n: None,
    "zero": lambda rng, n: np.zeros((n, 4)),
    "random": lambda rng, n: rng.random((n, 4)),
    "ties": lambda rng, n: rng.integers(0, 3, (n, 4)) / 4,
    "ones": lambda rng, n: np.ones((n, 4)),
    "few": lambda rng, n: np.where(rng.random((n, 4)) < 0.02, rng.integers(1, 5, (n, 4)) / 4, 0.0),
    "tiny": lambda rng, n: np.where(rng.random((n, 4)) < 0.05, 5e-324 * rng.integers(1, 4, (n, 4)), 0.0),
}


def random_calls(
    pair: Pair, world: GridWorld, goal: int, rng: np.random.Generator, count: int, open_calls: bool = False
) -> None:
    """A random mixture of calls over several episodes, one beginning about every fourth call.

    With ``open_calls`` also those of methods with single steps, their own update or exploration.
    """
    n = world.n_states
    pair("begin_episode", world.start)
    for _ in range(count):
        match rng.integers(14 if open_calls else 8):
            case 0 | 1:
                pair("begin_episode", world.start if rng.random() < 0.5 else int(rng.integers(n)))
            case 2 | 3 | 4:
                budget = [None, 0, 1, 2, 3, 7, 32, 33, 101, 1000][rng.integers(10)]
                epsilon = [None, 0.0, 0.1, 0.37, 1.0][rng.integers(5)]
                pair("explore", budget=budget, epsilon=epsilon)
            case 5:
                pair("follow", random_policy(rng, n, rng.choice([0.0, 0.1, 1.0])), int(rng.integers(n)))
            case 6:
                target = int(rng.integers(n))
                pair("follow", policy_to(world.successors, target), target)
            case 7:
                undefined, psi = rng.choice([0.0, 0.3, 1.0]), rng.choice([0.0, 0.4, 1.0])
                pair("reuse", random_policy(rng, n, undefined), psi, rng.choice([0.0, 0.5, 0.95, 0.999]))
            case 8:
                pair("follow", random_policy(rng, n, 0.0), int(rng.integers(n)), budget=int(rng.integers(50)))
            case 9:
                pair("set_value", int(rng.integers(n)), int(rng.integers(4)), rng.choice([0.0, 0.25, rng.random()]))
            case 10:
                pair("update", int(rng.integers(n)), int(rng.integers(4)), rng.choice([0.0, 0.25, rng.random()]))
            case 11:
                pair("set_q", INITIAL_Q[rng.choice(list(INITIAL_Q)[1:])](rng, n))
            case 12:
                bonus = rng.choice([0.0, 0.5, -1.0], (n, 4)) if rng.random() < 0.7 else None
                mask = rng.random((n, 4)) < 0.6 if rng.random() < 0.7 else None
                if mask is not None:
                    mask[np.arange(n), rng.integers(0, 4, n)] = True
                budget = int(rng.integers(200))
                pair("explore", budget=budget, epsilon=rng.choice([0.0, 0.37, 1.0]), bonus=bonus, mask=mask)
            case 13:
                if not (pair.kernel.at_goal or pair.kernel.truncated):
                    assert pair.kernel.choose() == pair.reference.choose()
                    pair("act", int(rng.integers(4)), learn=bool(rng.integers(2)))


# -- bit for bit ---------------------------------------------------------------------------------------------


def test_the_example_of_the_reference_runs():
    assert doctest.testmod(reference).attempted >= 5
    assert doctest.testmod(reference).failed == 0


def test_the_reference_can_be_read_alone():
    imports = re.findall(r"^(?:import|from) ([\w.]+)", inspect.getsource(reference), re.MULTILINE)
    assert set(imports) == {"__future__", "collections.abc", "numpy"}


@pytest.mark.parametrize("options", [{"shortcut": True}, {"shortcut": False}, {"ties": "first"}], ids=str)
@pytest.mark.parametrize(("epsilon", "slip"), [(0.0, 0.0), (0.1, 0.0), (1.0, 0.0), (0.0, 0.1), (0.1, 0.3), (0.1, 1.0)])
def test_equals_reference_while_learning_a_task(env2, epsilon, slip, options):
    world = env2
    pair = Pair(world, world.goals["A"], 7, epsilon=epsilon, max_steps=20_000, slip=slip, **options)
    for _ in range(8):
        pair("begin_episode", world.start)
        pair("explore")
    assert pair.kernel.q.any() or options == {"ties": "first"}  # which can be too slow for a first success


@pytest.mark.parametrize(("name", "slip"), [("env1", 0.1), ("env2", 0.0), ("env3", 0.0)])
def test_equals_reference_with_patience_that_doubles(published_maps, name, slip):
    """As a task is learnt with skills: guided legs, then exploration for 1, 2, 4, ... steps."""
    world = published_maps[name]
    goal = world.goals["F"]
    pair = Pair(world, goal, 11, alpha=0.5, max_steps=15_001, slip=slip)
    guides = [(policy_to(world.successors, world.goals[letter]), world.goals[letter]) for letter in "ABCDE"]
    for episode in range(5):
        pair("begin_episode", world.start)
        budget = 1 + episode
        while not (pair.kernel.at_goal or pair.kernel.truncated):
            pair("follow", *guides[budget % 5])
            pair("explore", budget=budget)
            budget *= 2


@pytest.mark.parametrize("slip", [0.0, 0.3])
def test_equals_reference_when_reusing_a_policy(env2, slip):
    world = env2
    past = policy_to(world.successors, world.goals["B"])
    past[::7] = -1
    pair = Pair(world, world.goals["C"], 13, epsilon=0.0, max_steps=6_000, slip=slip)
    for psi in (1.0, 1.0, 0.3, 0.0, 1.0, 2**-33, 2**-32):
        pair("begin_episode", world.start)
        pair("reuse", past, psi, 0.95)


@pytest.mark.parametrize("kind", INITIAL_Q)
def test_equals_reference_from_any_initial_q(env2, kind):
    world = env2
    rng = np.random.default_rng([5, list(INITIAL_Q).index(kind)])
    goal = world.goals["B"]
    initial_q = INITIAL_Q[kind](rng, world.n_states)
    pair = Pair(world, goal, 17, max_steps=2_001, initial_q=initial_q)
    random_calls(pair, world, goal, rng, 25)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(
    text=mazes.maps(),
    kind=st.sampled_from(list(INITIAL_Q)),
    alpha=st.sampled_from([0.05, 0.5, 0.6, 1.0]),
    gamma=st.sampled_from([0.95, 1.0, 0.5]),
    max_steps=st.sampled_from([1, 2, 3, 57, 2_000, 6_000]),
    shortcut=st.booleans(),
    ties=st.sampled_from(["random", "first"]),
    recorded=st.sampled_from([0, 40, 6_000]),
    open_calls=st.booleans(),
    slip=st.sampled_from([0.0, 0.1, 0.3]),
    seed=st.integers(0, 2**32 - 1),
)
def test_equals_reference_on_any_map(
    text, kind, alpha, gamma, max_steps, shortcut, ties, recorded, open_calls, slip, seed
):
    world = GridWorld.from_text(text)
    rng = np.random.default_rng(seed)
    goal = list(world.goals.values())[seed % len(world.goals)]
    pair = Pair(
        world,
        goal,
        seed,
        recorded,
        slip,
        alpha=alpha,
        gamma=gamma,
        max_steps=max_steps,
        initial_q=INITIAL_Q[kind](rng, world.n_states),
        shortcut=shortcut,
        ties=ties,
    )
    random_calls(pair, world, goal, rng, 60 if open_calls else 25, open_calls)


def test_a_recorded_episode_changes_no_later_one(env2):
    """The first episode is recorded through another loop; the learner goes on as if it had not been."""
    world = env2
    pair = Pair(world, world.goals["A"], 19, recorded=2_500, max_steps=20_000)
    pair("begin_episode", world.start)
    pair("explore", budget=33)
    pair("explore")
    assert len(pair.kernel.recorded) == min(2_500, pair.kernel.steps) > 33
    pair.kernel.begin_episode(world.start)
    pair.kernel.record(0)
    pair.recorded = 0
    for _ in range(5):
        pair("begin_episode", world.start)
        pair("explore")


# -- what each call promises ---------------------------------------------------------------------------------


@pytest.mark.parametrize("budget", [0, 1, 2, 3, 31, 32, 33, 34, 999])
def test_budget_is_kept_to_the_step(env1, budget):
    learner = Learner(Dynamics(env1.successors), env1.goals["F"], np.random.SFC64(1))
    learner.begin_episode(env1.start)
    for calls in (1, 2, 3):
        learner.explore(budget=budget)
        assert learner.steps == calls * budget
    assert not learner.truncated


@pytest.mark.parametrize("max_steps", [1, 2, 3, 32, 33, 500])
def test_max_steps_truncates_an_episode(env1, max_steps):
    learner = Learner(Dynamics(env1.successors), env1.goals["F"], np.random.SFC64(1), max_steps=max_steps)
    wander = np.zeros(env1.n_states, dtype=np.int8)
    learner.begin_episode(env1.start)
    for call, *arguments in (("explore",), ("explore", 5), ("reuse", wander, 1.0, 0.95)):
        getattr(learner, call)(*arguments)
        assert (learner.steps, learner.truncated, learner.at_goal) == (max_steps, True, False)
    learner.begin_episode(env1.start)
    assert (learner.steps, learner.truncated, learner.state) == (0, False, env1.start)
    learner.follow(wander, env1.goals["F"])
    assert (learner.steps, learner.truncated) == (max_steps, True)


def test_reaching_the_goal_at_the_last_allowed_step_is_no_truncation():
    world = GridWorld.from_text("I..A\n")
    east = np.full(world.n_states, 3, dtype=np.int8)
    learner = Learner(Dynamics(world.successors), world.goals["A"], np.random.SFC64(1), max_steps=3)
    learner.begin_episode(world.start)
    learner.follow(east, world.goals["A"])
    assert (learner.steps, learner.at_goal, learner.truncated) == (3, True, False)


def test_nothing_happens_at_the_goal():
    world = GridWorld.from_text("I..A\n")
    goal = world.goals["A"]
    stream = np.random.SFC64(1)
    learner = Learner(Dynamics(world.successors), goal, stream)
    learner.begin_episode(goal)
    west = np.full(world.n_states, 2, dtype=np.int8)
    learner.explore()
    learner.follow(west, world.start)
    learner.reuse(west, 1.0, 0.95)
    assert (learner.state, learner.steps, learner.at_goal) == (goal, 0, True)
    assert learner.erased_path().tolist() == [goal]
    assert not learner.q.any() and not learner.seen.any()
    assert stream.random_raw() == np.random.SFC64(1).random_raw()


def test_following_updates_q_by_the_rule_and_stops_where_told():
    world = GridWorld.from_text("I...A\n")
    east = np.array([3, 3, 3, 3, -1], dtype=np.int8)
    learner = Learner(Dynamics(world.successors), world.goals["A"], np.random.SFC64(1), alpha=0.5, gamma=0.8)
    for _ in range(2):
        learner.begin_episode(world.start)
        learner.follow(east, 4)
    expected = np.zeros((5, 4))
    expected[3, 3], expected[2, 3] = 0.75, 0.5 * 0.8 * 0.5
    assert learner.q.tolist() == expected.tolist()
    assert learner.seen.tolist() == [8, 8, 8, 8, 0]
    learner.begin_episode(world.start)
    learner.follow(east, 2)
    assert (learner.state, learner.steps) == (2, 2)
    east[3] = -1
    learner.follow(east, 4)
    assert (learner.state, learner.steps) == (3, 3)


def test_results_are_copies_and_the_initial_q_is_left_alone(env3):
    initial_q = np.full((env3.n_states, 4), 0.25)
    learner = Learner(Dynamics(env3.successors), env3.goals["A"], np.random.SFC64(1), initial_q=initial_q)
    learner.begin_episode(env3.start)
    learner.explore(100)
    assert (initial_q == 0.25).all()
    before = learner.q
    with pytest.raises(ValueError, match="read-only"):
        learner.q[:] = 9.0
    learner.seen[:] = 9
    assert learner.q.tobytes() == before.tobytes()
    assert learner.seen.max() < 16 and learner.seen.any()
    learner.explore(100)
    assert learner.q.tobytes() != before.tobytes()


def test_learners_on_one_map_do_not_disturb_each_other(env3):
    dynamics = Dynamics(env3.successors)

    def learners():
        tasks = enumerate("AB")
        return [Learner(dynamics, env3.goals[task], np.random.SFC64(seed)) for seed, task in tasks]

    apart, together = learners(), learners()
    for learner in apart:
        learner.begin_episode(env3.start)
        learner.explore(200)
        learner.explore(201)
    for learner in together:
        learner.begin_episode(env3.start)
    for budget in (200, 201):
        for learner in together:
            learner.explore(budget)
    for one, other in zip(apart, together, strict=True):
        assert (one.state, one.steps) == (other.state, other.steps)
        assert one.q.tobytes() == other.q.tobytes()


def test_equal_seeds_give_equal_bytes_and_other_seeds_others(env2):
    dynamics = Dynamics(env2.successors)

    def learn(seed: int) -> tuple[bytes, list[int]]:
        learner = Learner(dynamics, env2.goals["C"], np.random.SFC64(seed))
        lengths = []
        for _ in range(30):
            learner.begin_episode(env2.start)
            learner.explore()
            lengths.append(learner.steps)
        return learner.q.tobytes(), lengths

    first, again, other = learn(1), learn(1), learn(2)
    assert first == again
    assert first[0] != other[0] and first[1] != other[1]


def test_learning_finds_a_shortest_path(env2):
    learner = Learner(Dynamics(env2.successors), env2.goals["B"], np.random.SFC64(3), alpha=0.5)
    for _ in range(1500):
        learner.begin_episode(env2.start)
        learner.explore()
    learner.begin_episode(env2.start)
    learner.explore(epsilon=0.0)
    assert learner.steps == len(learner.erased_path()) - 1 == env2.distances_to(env2.goals["B"])[env2.start]


def test_loops_are_erased_by_their_definition():
    assert erase_loops([0]) == [0]
    assert erase_loops([0, 1, 1, 2, 1, 3]) == [0, 1, 3]
    assert erase_loops([0, 1, 2, 3, 1, 4, 2, 5]) == [0, 1, 4, 2, 5]
    assert erase_loops([0, 1, 2, 0]) == [0]


def test_arguments_out_of_range_are_refused(env3):
    dynamics, goal, n = Dynamics(env3.successors), env3.goals["A"], env3.n_states
    for wrong in ({"goal": n}, {"goal": -1}, {"epsilon": 1.5}, {"epsilon": -0.1}):
        with pytest.raises(ValueError, match=r"must|not a state"):
            Learner(dynamics, **{"goal": goal, "bit_generator": np.random.SFC64(1)} | wrong)
    for shape in ((n, 3), (n + 1, 4), (n,)):
        with pytest.raises(ValueError):
            Learner(dynamics, goal, np.random.SFC64(1), initial_q=np.zeros(shape))
    learner = Learner(dynamics, goal, np.random.SFC64(1))
    policy = np.zeros(n, dtype=np.int8)
    for call in (
        lambda: learner.begin_episode(n),
        lambda: learner.begin_episode(-1),
        lambda: learner.explore(5, epsilon=2.0),
        lambda: learner.explore(5, epsilon=float("nan")),
        lambda: learner.follow(policy[1:], 0),
        lambda: learner.follow(policy + 4, 0),
        lambda: learner.reuse(policy - 2, 1.0, 0.95),
        lambda: learner.reuse(policy, 1.1, 0.95),
        lambda: learner.reuse(policy, 1.0, 1.0),
        lambda: learner.record(-1),
    ):
        with pytest.raises(ValueError):
            call()
    learner.begin_episode(0)
    learner.explore(budget=3)
    with pytest.raises(ValueError, match="before the first step of an episode, not after 3"):
        learner.record(10)
    with pytest.raises(ValueError):
        Dynamics(np.full((3, 4), 3))
    with pytest.raises(ValueError):
        Dynamics(np.full((3, 4), -1))
    with pytest.raises(ValueError):
        Dynamics(np.zeros((3, 3), dtype=int))


# -- distributions -------------------------------------------------------------------------------------------


def moves_and_stream(kind: type, world: GridWorld, seed: int) -> tuple:
    """Arguments of a learner of this kind for the map and the random numbers."""
    if kind is Learner:
        return Dynamics(world.successors), np.random.SFC64(seed)
    return world.successors, RandomBits(np.random.SFC64(seed))


def first_episodes(world: GridWorld, goal: int, episodes: int, seed: int, kind=Learner, **options):
    """Lengths and loop-erased paths of first episodes (Q = 0, so uniform random walks)."""
    moves, stream = moves_and_stream(kind, world, seed)
    lengths, paths = np.empty(episodes, dtype=np.int64), []
    for episode in range(episodes):
        learner = kind(moves, goal, stream, **options)
        learner.begin_episode(world.start)
        learner.explore()
        lengths[episode] = learner.steps
        paths.append(tuple(learner.erased_path().tolist()))
    return lengths, paths


def same_distribution(first: Counter, second: Counter) -> float:
    """p value of the chi-square test that two samples have the same distribution; rare values are pooled."""
    table = np.array([[sample[value] for value in set(first) | set(second)] for sample in (first, second)])
    common = table.sum(axis=0) >= 20
    rest = table[:, ~common].sum(axis=1, keepdims=True)
    table = np.hstack([table[:, common], rest]) if rest.any() else table
    assert table.shape[1] > 1, "nothing to compare"
    return float(stats.chi2_contingency(table).pvalue)


def goodness_of_fit(observed: np.ndarray, probabilities: np.ndarray) -> float:
    """p value of the chi-square test of counts against a distribution; values expected under 8 times are pooled."""
    expected = observed.sum() * np.append(probabilities, max(0.0, 1.0 - probabilities.sum()))
    observed = np.append(observed, 0)
    assert not observed[expected < 1e-9].any(), "an impossible value occurred"
    common = expected >= 8
    observed = np.append(observed[common], observed[~common].sum())
    expected = np.append(expected[common], expected[~common].sum())
    kept = expected > 1e-6
    return float(stats.chisquare(observed[kept], expected[kept], sum_check=False).pvalue)


@pytest.mark.parametrize("name", HITTING_TIMES)
def test_oracle_gives_the_expected_values(name):
    world = load_map(MAPS / f"{name}.txt")
    means = [oracles.hitting_time(world.successors, world.start, goal)[0] for goal in world.goals.values()]
    assert [round(mean) for mean in means] == HITTING_TIMES[name]


@pytest.mark.parametrize("name", PUBLISHED)
def test_first_episode_on_the_published_maps_has_the_expected_length(published_maps, name):
    world = published_maps[name]
    for letter, goal in world.goals.items():
        mean, deviation = oracles.hitting_time(world.successors, world.start, goal)
        lengths, _ = first_episodes(world, goal, 300, ord(letter))
        assert abs(lengths.mean() - mean) < 4.5 * deviation / np.sqrt(300), letter


@pytest.mark.parametrize("seed", range(6))
def test_first_episode_on_random_maps_has_the_expected_length(seed):
    rng = np.random.default_rng(seed)
    text = mazes.open_grid(rng, 9, 11, 0.2) if seed % 2 else mazes.random_rooms(rng, 12, 13)
    world = GridWorld.from_text(text)
    for epsilon, goal in zip((0.0, 0.1, 1.0), world.goals.values(), strict=False):
        mean, deviation = oracles.hitting_time(world.successors, world.start, goal)
        lengths, _ = first_episodes(world, goal, 3000, seed, epsilon=epsilon)
        assert abs(lengths.mean() - mean) < 4.5 * deviation / np.sqrt(len(lengths))


@pytest.mark.parametrize("shortcut", [True, False])
@pytest.mark.parametrize("world", [SMALL_MAP, CORNERED], ids=["small", "cornered"])
def test_first_episodes_have_the_exact_distribution_of_the_random_walk(world, shortcut):
    goal = world.goals["A"]
    lengths, paths = first_episodes(world, goal, 20_000, 23, shortcut=shortcut)
    longest = int(lengths.max())
    distribution = oracles.length_distribution(world.successors, world.start, goal, longest)
    assert goodness_of_fit(np.bincount(lengths, minlength=longest + 1), distribution) > 1e-3
    counts = Counter(paths)
    of_paths = np.array([oracles.erased_path_probability(world.successors, path) for path in counts])
    assert of_paths.sum() > 0.99
    assert goodness_of_fit(np.array(list(counts.values())), of_paths) > 1e-3


@pytest.mark.parametrize("epsilon", [0.5, 0.9])
def test_first_episodes_whose_ties_go_to_the_first_action_have_the_exact_mean(epsilon):
    """The agent walks north but for its random actions, which a linear system solves."""
    goal = SMALL_MAP.goals["A"]
    others = np.flatnonzero(np.arange(SMALL_MAP.n_states) != goal)
    matrix = epsilon * oracles.transition_matrix(SMALL_MAP.successors)
    matrix[np.arange(len(matrix)), SMALL_MAP.successors[:, 0]] += 1 - epsilon
    times = np.linalg.solve(np.eye(len(others)) - matrix[np.ix_(others, others)], np.ones(len(others)))
    expected = times[others == SMALL_MAP.start][0]
    lengths, _ = first_episodes(SMALL_MAP, goal, 4000, 43, epsilon=epsilon, ties="first")
    assert abs(lengths.mean() - expected) < 4 * lengths.std(ddof=1) / np.sqrt(len(lengths))


def test_ties_are_random_or_go_to_the_first_action():
    q = np.zeros((SMALL_MAP.n_states, 4))
    q[SMALL_MAP.start] = [0.1, 0.5, 0.2, 0.5]
    for ties, expected in (("random", {1, 3}), ("first", {1})):
        learner = Learner(
            Dynamics(SMALL_MAP.successors), SMALL_MAP.goals["A"], np.random.SFC64(1), initial_q=q, ties=ties
        )
        learner.begin_episode(SMALL_MAP.start)
        assert {learner.choose(0.0) for _ in range(50)} == expected
        assert {learner.choose(1.0) for _ in range(100)} == {0, 1, 2, 3}
        assert {learner.choose(1.0, mask=[True, False, True, True]) for _ in range(100)} == {0, 2, 3}
    with pytest.raises(ValueError, match="ties must be 'random' or 'first', not 'last'"):
        Learner(Dynamics(SMALL_MAP.successors), SMALL_MAP.goals["A"], np.random.SFC64(1), ties="last")


@pytest.mark.parametrize("world", [SMALL_MAP, CORNERED], ids=["small", "cornered"])
def test_shortcut_keeps_the_law_of_step_by_step_walking(world):
    goal = world.goals["A"]
    lengths, paths = first_episodes(world, goal, 6000, 29)
    plain_lengths, plain_paths = first_episodes(world, goal, 6000, 31, shortcut=False)
    assert stats.ks_2samp(lengths, plain_lengths).pvalue > 1e-3
    assert same_distribution(Counter(lengths % 2), Counter(plain_lengths % 2)) > 1e-3
    assert same_distribution(Counter(paths), Counter(plain_paths)) > 1e-3
    entrances = Counter(path[-2] for path in paths)
    assert len(entrances) > 1
    assert same_distribution(entrances, Counter(path[-2] for path in plain_paths)) > 1e-3


def test_shortcut_keeps_the_law_while_learning():
    """Third episodes: Q is known near the goal and still zero near the start."""
    world = GridWorld.from_text("I.....\n.#..#.\n......\n.#.#.A\n")
    goal = world.goals["A"]

    def third_episodes(kind, seed, **options):
        moves, stream = moves_and_stream(kind, world, seed)
        lengths, paths = [], Counter()
        for _ in range(2500):
            learner = kind(moves, goal, stream, alpha=0.5, **options)
            for _ in range(3):
                learner.begin_episode(world.start)
                learner.explore()
            lengths.append(learner.steps)
            paths[tuple(learner.erased_path().tolist())] += 1
        return np.array(lengths), paths

    lengths, paths = third_episodes(Learner, 37)
    plain_lengths, plain_paths = third_episodes(Learner, 41, shortcut=False)
    assert stats.ks_2samp(lengths, plain_lengths).pvalue > 1e-3
    assert same_distribution(paths, plain_paths) > 1e-3


@pytest.mark.parametrize("budget", [1, 2, 3, 6, 7])
def test_where_a_budget_ends_has_the_exact_distribution(budget):
    world, goal = SMALL_MAP, SMALL_MAP.goals["A"]
    walk = oracles.transition_matrix(world.successors)
    walk[goal] = np.eye(world.n_states)[goal]
    distribution = np.linalg.matrix_power(walk, budget)[world.start]
    learner = Learner(Dynamics(world.successors), goal, np.random.SFC64(43), gamma=0.0)
    counts = np.zeros(world.n_states, dtype=int)
    # gamma = 0 keeps Q at 0 except beside the goal: near the start the shortcut stays in use in all episodes.
    for _ in range(20_000):
        learner.begin_episode(world.start)
        learner.explore(budget, epsilon=1.0)
        counts[learner.state] += 1
    assert goodness_of_fit(counts, distribution) > 1e-3


@pytest.mark.parametrize("epsilon", [0.0, 0.1, 0.5, 1.0])
@pytest.mark.parametrize("greedy", [(2,), (0, 3), (1, 2, 3), (0, 1, 2, 3)])
def test_greedy_ties_and_random_actions_are_uniform(greedy, epsilon):
    """Q solves the update rule exactly, so it stays as it is and every step is a draw from one distribution."""
    world = GridWorld.from_text("......\n......\n..I...\n......\n.....A\n")
    initial_q = np.zeros((world.n_states, 4))
    for action, neighbour in enumerate(world.successors[world.start]):
        initial_q[neighbour] = 0.8 if action in greedy else 0.4
        initial_q[world.start, action] = 0.95 * initial_q[neighbour, 0]
    learner = Learner(Dynamics(world.successors), world.goals["A"], np.random.SFC64(47), initial_q=initial_q)
    counts = Counter()
    for _ in range(20_000):
        learner.begin_episode(world.start)
        learner.explore(1, epsilon=epsilon)
        counts[learner.state] += 1
    assert learner.q.tobytes() == initial_q.tobytes()
    distribution = np.full(4, epsilon / 4)
    distribution[list(greedy)] += (1 - epsilon) / len(greedy)
    observed = np.array([counts[state] for state in world.successors[world.start]])
    assert observed.sum() == 20_000
    if (distribution == 1.0).any():
        assert observed[distribution == 1.0] == 20_000
    else:
        assert goodness_of_fit(observed, distribution) > 1e-3


def test_reuse_takes_the_past_action_with_the_stated_probability():
    """First step with psi: past policy with psi, otherwise epsilon-greedy with epsilon = psi."""
    world = GridWorld.from_text("......\n......\n..I...\n......\n.....A\n")
    initial_q = np.zeros((world.n_states, 4))
    for action, neighbour in enumerate(world.successors[world.start]):
        initial_q[neighbour] = 0.8 if action == 1 else 0.4
        initial_q[world.start, action] = 0.95 * initial_q[neighbour, 0]
    past = np.full(world.n_states, 2, dtype=np.int8)
    psi, episodes = 0.6, 20_000
    # One step an episode: max_steps ends it.
    learner = Learner(
        Dynamics(world.successors), world.goals["A"], np.random.SFC64(53), initial_q=initial_q, max_steps=1
    )
    for policy, taken in ((past, psi), (np.full_like(past, -1), 0.0)):
        counts = Counter()
        for _ in range(episodes):
            learner.begin_episode(world.start)
            learner.reuse(policy, psi, 0.95)
            counts[learner.state] += 1
        distribution = (1 - taken) * (np.full(4, psi / 4) + (1 - psi) * np.eye(4)[1]) + taken * np.eye(4)[2]
        observed = np.array([counts[state] for state in world.successors[world.start]])
        assert goodness_of_fit(observed, distribution) > 1e-3


def test_q_stays_between_0_and_1(env3):
    learner = Learner(Dynamics(env3.successors), env3.goals["F"], np.random.SFC64(59), alpha=0.9, gamma=1.0)
    for _ in range(300):
        learner.begin_episode(env3.start)
        learner.explore()
        assert learner.q.min() >= 0.0 and learner.q.max() <= 1.0
    assert learner.q.max() > 0.99
