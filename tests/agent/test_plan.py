"""Plans: the compiled loop over episodes, the learner's own calls and the plain reference give the same bits."""

from __future__ import annotations

from typing import Any

import mazes
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test_kernel import policy_to, random_policy

from ptl.agent._episodes import run_episodes
from ptl.agent._kernel import Dynamics, Learner
from ptl.agent.plan import Guide, Mixing, Plan
from ptl.agent.reference import RandomBits, ReferenceLearner
from ptl.world.gridworld import GridWorld

CORRIDOR = GridWorld.from_text("I.......A\n")  # states 0..8
EAST = np.full(9, 3, dtype=np.int8)
EPISODES, TRAJECTORIES = 12, 5


class NotedPlan:
    """A plan with its own random stream for draws, and its notes."""

    def __init__(self, guides: list[Guide | None], seed: int, **options: Any) -> None:
        random = np.random.default_rng(seed)
        self.told: list[tuple[list[int], int, bool]] = []
        self.plan = Plan(
            draw=lambda: int(random.integers(len(guides))),
            guide=guides.__getitem__,
            note=lambda drawn, steps, at_goal: self.told.append((list(drawn), steps, at_goal)),
            **options,
        )


def run_by_calls(learner: Any, plan: Plan, start: int) -> tuple[list[int], list[bool], list[list[int]], list[Any]]:
    """Return the same as `run_episodes`, by `Plan.run`."""
    steps, truncated, drawn, paths = [], [], [], []
    for _ in range(EPISODES):
        learner.begin_episode(start)
        drawn.append(plan.run(learner))
        steps.append(learner.steps)
        truncated.append(learner.truncated)
        if learner.at_goal and len(paths) < TRAJECTORIES:
            paths.append(learner.erased_path().tolist())
    return steps, truncated, drawn, paths


def check_equal(
    world: GridWorld, goal: int, seed: int, guides: list[Guide | None], plan_options, slip: float = 0.0, **options
) -> None:
    compiled = Learner(Dynamics(world.successors, slip), goal, np.random.SFC64(seed), **options)
    called = Learner(Dynamics(world.successors, slip), goal, np.random.SFC64(seed), **options)
    reference = ReferenceLearner(world.successors, goal, RandomBits(np.random.SFC64(seed)), slip=slip, **options)
    notes = [NotedPlan(guides, seed, **plan_options) for _ in range(3)]
    steps, truncated, drawn, paths = run_episodes(compiled, notes[0].plan, world.start, EPISODES, TRAJECTORIES)
    expected = run_by_calls(reference, notes[2].plan, world.start)
    assert run_by_calls(called, notes[1].plan, world.start) == expected
    assert (steps.tolist(), truncated.tolist(), drawn, [path.tolist() for path in paths]) == expected
    assert (steps.dtype, truncated.dtype) == (np.int64, bool) and all(path.dtype == np.int32 for path in paths)
    assert notes[0].told == notes[1].told == notes[2].told
    assert [told for told, _, _ in notes[0].told] == drawn
    assert compiled.episodes == EPISODES
    for learner in (compiled, called):
        assert learner.q.tobytes() == reference.q.tobytes()
        assert np.array_equal(learner.seen, reference.seen)
        assert learner.state == reference.state


def guides_of(world: GridWorld, rng: np.random.Generator, number: int) -> list[Guide | None]:
    """The null skill and guides to random states, good and bad, some with an initiation set."""
    guides: list[Guide | None] = [None]
    for _ in range(number):
        subgoal = int(rng.integers(world.n_states))
        policy = policy_to(world.successors, subgoal) if rng.random() < 0.7 else random_policy(rng, world.n_states, 0.3)
        initiation = rng.random(world.n_states) < 0.5 if rng.random() < 0.5 else None
        guides.append(Guide(policy, subgoal if rng.random() < 0.8 else None, initiation))
    return guides


@pytest.mark.parametrize("mixing", [None, Mixing(1.0, 0.95)])
@pytest.mark.parametrize("patience", [None, 40.0])
def test_a_plan_is_what_its_calls_are(env2, mixing, patience):
    guides = guides_of(env2, np.random.default_rng(3), 3)
    plan = {"mixing": mixing, "patience": patience, "growth": 1.7}
    check_equal(env2, env2.goals["C"], 5, guides, plan, alpha=0.5, max_steps=4000)


@settings(max_examples=80, deadline=None, derandomize=True)
@given(
    text=mazes.maps(),
    mixing=st.sampled_from([None, Mixing(1.0, 0.95), Mixing(0.4, 0.5), Mixing(0.0, 0.0)]),
    patience=st.sampled_from([None, 0.3, 1.5, 2.5, 7.0, 100.0, 1e300]),
    growth=st.sampled_from([1.0, 1.5, 2.0, 1e300]),
    epsilon=st.sampled_from([None, 0.0, 0.3]),
    max_steps=st.sampled_from([1, 2, 40, 300]),
    options=st.sampled_from([{"shortcut": True}, {"shortcut": False}, {"ties": "first"}, {"slip": 0.2}]),
    seed=st.integers(0, 2**32 - 1),
)
def test_a_plan_is_what_its_calls_are_on_any_map(text, mixing, patience, growth, epsilon, max_steps, options, seed):
    world = GridWorld.from_text(text)
    rng = np.random.default_rng(seed)
    goal = list(world.goals.values())[seed % len(world.goals)]
    plan = {"mixing": mixing, "patience": patience, "growth": growth, "epsilon": epsilon}
    check_equal(
        world, goal, seed, guides_of(world, rng, int(rng.integers(4))), plan,
        alpha=0.5, max_steps=max_steps, **options,
    )  # fmt: skip


def test_a_plan_without_draws_explores():
    for patience in (None, 3.0):
        learner = Learner(Dynamics(CORRIDOR.successors), 8, np.random.SFC64(1))
        other = Learner(Dynamics(CORRIDOR.successors), 8, np.random.SFC64(1), shortcut=patience is None)
        steps, truncated, drawn, paths = run_episodes(learner, Plan(patience=patience), 0, 20, 30)
        assert drawn == [[]] * 20 and not truncated.any()
        assert [path.tolist() for path in paths] == [list(range(9))] * 20
        if patience is None:
            for expected in steps:
                other.begin_episode(0)
                other.explore()
                assert other.steps == expected
            assert learner.q.tobytes() == other.q.tobytes()


def test_an_initiation_set_leads_once_a_state_where_nothing_is_known():
    initiation = np.zeros(9, dtype=bool)
    initiation[3] = True
    policy = np.where(np.isin(np.arange(9), [3, 4, 5]), EAST, -1).astype(np.int8)
    plan = Plan(draw=lambda: 1, guide=[None, Guide(policy, 6, initiation)].__getitem__, patience=500.0)
    later = set()
    for seed in range(10):
        learner = Learner(Dynamics(CORRIDOR.successors), 8, np.random.SFC64(seed), epsilon=1.0, shortcut=False)
        learner.record(500)
        run_episodes(learner, plan, 0, 1, 0)
        state, steps = 0, []
        for action in learner.recorded.tolist():
            steps.append((state, action))
            state = int(CORRIDOR.successors[state, action])
        first = steps.index((3, 3))
        assert all(state < 3 for state, _ in steps[:first])
        assert steps[first : first + 3] == [(3, 3), (4, 3), (5, 3)]
        later |= {action for state, action in steps[first + 3 :] if state == 3}
    assert later == {0, 1, 2, 3}  # nothing is known in state 3 at later visits either


def test_a_guide_is_asked_for_at_every_draw_and_may_be_another_one():
    handed = iter([Guide(EAST, 4), Guide(EAST, 7)])
    asked = []
    learner = Learner(Dynamics(CORRIDOR.successors), 8, np.random.SFC64(1), max_steps=7)
    learner.record(7)
    plan = Plan(draw=lambda: 3, guide=lambda candidate: asked.append(candidate) or next(handed), patience=100.0)
    steps, truncated, drawn, _ = run_episodes(learner, plan, 0, 2, 1)
    assert asked == [3, 3] and drawn == [[3], [3]]
    assert truncated.all() and steps.tolist() == [7, 7]
    assert learner.recorded.tolist() == [3] * 7


@pytest.mark.parametrize(
    ("plan", "says"),
    [
        (Plan(draw=lambda: -1), "a candidate drawn must be a whole number from 0 to 2147483647, not -1"),
        (Plan(draw=lambda: 2**31), "a candidate drawn must be a whole number"),
        (Plan(draw=lambda: "a"), "a candidate drawn must be a whole number"),
        (Plan(draw=lambda: 1, guide=lambda _: Guide(EAST[:4], 4)), "a policy needs one action from -1 to 3 for each"),
        (Plan(draw=lambda: 1, guide=lambda _: Guide(EAST, 9)), "subgoal must be a whole number from 0 to 8, not 9"),
        (Plan(draw=lambda: 1, guide=lambda _: Guide(EAST, 4, EAST)), "an initiation set must be a bool array"),
        (Plan(epsilon=1.5), r"epsilon must lie in \[0, 1\], not 1.5"),
        (Plan(mixing=Mixing(1.5, 0.5)), r"psi must lie in \[0, 1\], not 1.5"),
        (Plan(mixing=Mixing(0.5, 1.0)), r"decay must lie in \[0, 1\), not 1.0"),
    ],
)
def test_a_wrong_plan_is_refused(plan, says):
    learner = Learner(Dynamics(CORRIDOR.successors), 8, np.random.SFC64(1))
    with pytest.raises(ValueError, match=says):
        run_episodes(learner, plan, 0, 3, 1)
    with pytest.raises(ValueError, match="start must be a whole number from 0 to 8, not 9"):
        run_episodes(learner, Plan(), 9, 3, 1)


@pytest.mark.parametrize("wrong", [{"patience": 0.0}, {"patience": float("nan")}, {"growth": 0.5}])
def test_a_patience_that_never_ends_the_wait_is_refused(wrong):
    with pytest.raises(ValueError, match="of a plan must be"):
        Plan(**wrong)


def test_an_error_in_a_plan_comes_through():
    def fail() -> int:
        raise ZeroDivisionError("drawn")

    learner = Learner(Dynamics(CORRIDOR.successors), 8, np.random.SFC64(1))
    with pytest.raises(ZeroDivisionError, match="drawn"):
        run_episodes(learner, Plan(draw=fail), 0, 3, 1)
