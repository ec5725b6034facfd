"""Each method behaves as described, on a learner that only records its calls."""

from __future__ import annotations

import numpy as np
import pytest

from ptl import methods
from ptl.agent.skills import Skill
from ptl.config import Parameters
from ptl.errors import UserError
from ptl.world.gridworld import GridWorld

WORLD = GridWorld.from_text("I......A\n")


class NotingLearner:
    """Replaces the kernel: reaches the goal after a given number of exploring calls."""

    def __init__(self, explorations: int = 1, steps: int = 50, q: np.ndarray | None = None) -> None:
        self.q = q
        self.calls: list[tuple] = []
        self.remaining = explorations
        self.steps = steps
        self.truncated = False

    @property
    def at_goal(self) -> bool:
        return self.remaining <= 0

    def explore(self, budget=None, epsilon=None):
        self.calls.append(("explore", budget, epsilon))
        self.remaining -= 1

    def follow(self, policy, subgoal, budget):
        assert budget == len(policy)  # a lead ends after as many steps as there are states
        self.calls.append(("follow", subgoal))

    def reuse(self, policy, psi, decay):
        self.calls.append(("reuse", policy.tolist(), psi, decay))
        self.remaining -= 1


def make(name: str, **changes) -> methods.BaseMethod:
    return methods.load(name)(WORLD, Parameters().replace(**changes), np.random.default_rng(3))


def with_skills(name: str, subgoals: list[int], **changes) -> methods.BaseMethod:
    method = make(name, **changes)
    for subgoal in subgoals:
        method.library.skills.append(Skill(subgoal, np.full(8, 3, dtype=np.int8), 0))
    return method


def test_names_and_unknown_method():
    assert methods.names() == [
        "full_transfer", "no_transfer", "policy_reuse", "ptl", "ptl_supervised", "ptl_unknown_goal",
    ]  # fmt: skip
    with pytest.raises(UserError, match="unknown method 'q_lambda'; known are full_transfer"):
        methods.load("q_lambda")


def test_full_transfer_starts_from_the_previous_q():
    method = make("full_transfer")
    assert method.begin_task(0, 7) is None
    q = np.random.default_rng(0).random((8, 4))
    method.end_task(NotingLearner(q=q))
    np.testing.assert_array_equal(method.begin_task(0, 3), q)


def test_no_transfer_keeps_nothing():
    method = make("no_transfer")
    method.end_task(NotingLearner(q=np.ones((8, 4))))
    assert method.begin_task(0, 3) is None
    learner = NotingLearner()
    assert method.run_episode(learner) == []
    assert learner.calls == [("explore", None, None)]


def test_policy_reuse_probabilities_by_hand():
    method = make("policy_reuse")
    q = np.zeros((8, 4))
    q[:, 3] = 1
    method.end_task(NotingLearner(q=q))
    method.begin_task(0, 7)
    np.testing.assert_allclose(method.arm_probabilities(), [0.5, 0.5])  # tau = 0
    expected_gain, uses = np.zeros(2), np.zeros(2)
    for episode in range(40):
        learner = NotingLearner(steps=episode + 1)
        [arm] = method.run_episode(learner)
        kind = learner.calls[0]
        assert kind == (("explore", None, 0.0) if arm == 0 else ("reuse", [3] * 8, 1.0, 0.95))
        expected_gain[arm] = (expected_gain[arm] * uses[arm] + 0.95**episode) / (uses[arm] + 1)
        uses[arm] += 1
        weights = np.exp(0.05 * (episode + 1) * expected_gain)
        np.testing.assert_allclose(method.arm_probabilities(), weights / weights.sum(), rtol=1e-12)
    assert (uses > 0).all()


def test_policy_reuse_gains_nothing_from_a_truncated_episode():
    method = make("policy_reuse", policy_reuse__temperature=5.0)
    method.begin_task(0, 7)
    learner = NotingLearner(explorations=2)
    learner.truncated = True
    method.run_episode(learner)
    assert method.selection.gain.tolist() == [0] and method.selection.uses.tolist() == [1]


def test_ptl_draws_again_with_doubled_patience():
    method = with_skills("ptl", [])
    method.begin_task(0, 7)
    learner = NotingLearner(explorations=3)
    assert method.run_episode(learner) == [0, 0, 0]
    assert learner.calls == [("explore", 8, None), ("explore", 16, None), ("explore", 32, None)]


def test_ptl_lead_in_draws_once():
    method = with_skills("ptl", [6], skills__skill_use="lead_in")
    method.begin_task(0, 7)
    learner = NotingLearner()
    assert len(method.run_episode(learner)) == 1
    assert learner.calls[-1] == ("explore", None, None)


def test_ptl_follows_the_drawn_skill_then_explores():
    method = with_skills("ptl", [6], skills__null_skill=False)
    method.begin_task(0, 7)
    learner = NotingLearner()
    assert method.run_episode(learner) == [1]
    assert learner.calls == [("follow", 6), ("explore", 8, None)]


def test_ptl_prior_counts_the_start_as_the_null_skill():
    method = with_skills("ptl", [6], skills__prior_width=0.1)
    method.begin_task(0, 7)
    scale = 0.1 * np.hypot(1, 8)
    weights = np.exp(-np.array([7, 1]) / scale)
    np.testing.assert_allclose(method.selection.probabilities(), weights / weights.sum(), rtol=1e-12)


def test_ptl_without_null_skill_still_starts_with_it():
    method = with_skills("ptl", [], skills__null_skill=False)
    method.begin_task(0, 7)
    np.testing.assert_array_equal(method.selection.probabilities(), [1.0])


def test_ptl_records_the_length_for_all_skills_used():
    method = with_skills("ptl", [6])
    method.begin_task(0, 7)
    used = method.run_episode(NotingLearner(explorations=6, steps=25))
    np.testing.assert_allclose(method.selection.performance[sorted(set(used))], 1 / 25)


def test_unknown_goal_has_a_uniform_prior():
    method = with_skills("ptl_unknown_goal", [6, 2, 5])
    method.begin_task(0, 7)
    np.testing.assert_allclose(method.selection.probabilities(), [0.25] * 4)


@pytest.mark.parametrize(("subgoals", "goal", "expected"), [([2, 5], 6, 2), ([2, 5], 1, 0), ([6], 3, 0), ([], 7, 0)])
def test_supervisor_names_the_nearest_candidate(subgoals, goal, expected):
    # A tie (state 3 is 3 steps from both 0 and 6) goes to the start, that is to no guidance.
    method = with_skills("ptl_supervised", subgoals)
    method.begin_task(0, goal)
    assert method.run_episode(NotingLearner(explorations=2)) == [expected] * 2


def test_supervisor_measures_by_paths_not_as_the_crow_flies():
    world = GridWorld.from_text("I....\n####.\nA....\n")
    method = methods.load("ptl_supervised")(world, Parameters(), np.random.default_rng(0))
    method.library.skills.append(Skill(world.state_at(2, 3), np.full(world.n_states, -1, dtype=np.int8), 0))
    method.begin_task(world.start, world.goal("A"))
    assert method.draw_skill() == 1


def test_labels_and_colours_are_told_apart():
    kinds = [methods.load(name) for name in methods.names()]
    assert len({kind.label for kind in kinds}) == len({kind.colour for kind in kinds}) == len(kinds)


@pytest.mark.parametrize("name", ["ptl", "ptl_unknown_goal"])
def test_a_narrow_prior_never_draws_the_excluded_null_skill(name):
    settings = {"skills__null_skill": False, "skills__prior_form": "gaussian", "skills__prior_width": 0.005}
    method = with_skills(name, [6, 2], **settings)
    method.begin_task(0, 0)  # the start, the null skill's subgoal, is nearest to this goal
    chances = method.selection.probabilities()
    assert chances[0] == 0 and chances.sum() == pytest.approx(1)
    assert 0 not in method.run_episode(NotingLearner(explorations=5))
