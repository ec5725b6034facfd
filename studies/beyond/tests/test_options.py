"""Options by SMDP and by intra-option Q-learning, against numbers worked out by hand."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest

from ptl import methods
from ptl.agent._kernel import Dynamics, Learner
from ptl.agent.skills import Skill
from ptl.config import Parameters
from ptl.world.gridworld import GridWorld
from studies.beyond.methods import reference

CORRIDOR = GridWorld.from_text("I...A\n", "corridor")
NORTH, SOUTH, WEST, EAST = range(4)
OPTION = 4


def in_corridor(name: str) -> methods.BaseMethod:
    """Return a method with alpha = 1/2 and gamma = 0.9 that has one option: from 0 and 1 eastwards to 2."""
    parameters = Parameters().replace(learning__alpha=0.5, learning__gamma=0.9)
    method = methods.load(reference(name))(CORRIDOR, parameters, np.random.default_rng(1))
    policy = np.array([EAST, EAST, -1, WEST, -1], dtype=np.int8)
    method.library.skills.append(Skill(2, policy, 0, np.array([True, True, False, False, False])))
    method.begin_task(CORRIDOR.start, CORRIDOR.goal("A"))
    return method


def episode(method: methods.BaseMethod, learner: Learner, choices: Iterable[int]) -> list[int]:
    """Run an episode with these choices; return the options taken."""
    given = iter(choices)
    method.choose = lambda state, random_end=None: next(given)
    learner.begin_episode(CORRIDOR.start)
    taken = method.run_episode(learner)
    assert next(given, None) is None and learner.at_goal
    return taken


def learner_of(method: methods.BaseMethod) -> Learner:
    return Learner(Dynamics(CORRIDOR.successors), CORRIDOR.goal("A"), np.random.SFC64(1))


def test_smdp_q_learning_by_hand():
    """Three episodes of the option (two steps), east, east; nothing is learned inside of the option."""
    method = in_corridor("options_smdp")
    learner = learner_of(method)
    # (Q(0, option), Q(2, east), Q(3, east)) after each
    expected = [(0.0, 0.0, 0.5), (0.0, 0.225, 0.75), (0.5 * 0.81 * 0.225, 0.45, 0.875)]
    for number, (of_option, before, last) in enumerate(expected, 1):
        assert episode(method, learner, [OPTION, EAST, EAST]) == [1]
        assert learner.steps == 4 and learner.episodes == number
        values = method.values
        assert (values[0][OPTION], values[2][EAST], values[3][EAST]) == pytest.approx((of_option, before, last))
        assert values[0][:4] == values[1][:4] == [0] * 4 and values[1][OPTION] == 0
    method.end_task(learner)
    assert learner.q.tolist() == [row[:4] for row in method.values]


def test_intra_option_learning_by_hand():
    """Inside of the option east and the option are learned about in every state, the option also from east alone."""
    method = in_corridor("options_intra")
    learner = learner_of(method)
    for _ in range(3):
        assert episode(method, learner, [OPTION, EAST, EAST]) == [1]
    # as above in 2 and 3; in 1 both end in 2: 0.5 * 0.9 * 0.225 in the third episode; in 0 nothing was known ahead yet
    values = method.values
    assert (values[2][EAST], values[3][EAST]) == pytest.approx((0.45, 0.875))
    assert values[1][EAST] == values[1][OPTION] == pytest.approx(0.10125)
    assert values[0][EAST] == values[0][OPTION] == 0
    assert episode(method, learner, [EAST, EAST, EAST, EAST]) == []
    # east: 0.5 * 0.9 * 0.10125; the option goes on in 1, where it is worth 0.10125 too
    assert values[0][EAST] == values[0][OPTION] == pytest.approx(0.0455625)
    # in 1: 0.10125 + 0.5 * (0.9 * 0.45 - 0.10125)
    assert values[1][EAST] == values[1][OPTION] == pytest.approx(0.253125)


@pytest.mark.parametrize("name", ["options_smdp", "options_intra"])
def test_an_option_is_chosen_where_it_begins_and_ends_at_its_subgoal(name):
    method = in_corridor(name)
    assert [row[OPTION] for row in method.values] == [0, 0, -np.inf, -np.inf, -np.inf]
    assert {method.choose(2) for _ in range(200)} == {0, 1, 2, 3}
    counts = np.bincount([method.choose(0) for _ in range(1000)], minlength=5)
    assert abs(counts - 200).max() < 4 * np.sqrt(1000 * 0.2 * 0.8)
    assert {method.choose(0, 4) for _ in range(200)} == {0, 1, 2, 3}
    method.values[0][OPTION] = 0.1
    for random_end, probability in ((None, 0.92), (4, 0.9)):
        share = np.mean([method.choose(0, random_end) == OPTION for _ in range(1000)])
        assert abs(share - probability) < 4 * np.sqrt(probability * (1 - probability) / 1000)
    learner = learner_of(method)
    learner.begin_episode(1)
    assert method.take(learner, 1, OPTION) == 2 and learner.steps == 1


@pytest.mark.parametrize("name", ["options_smdp", "options_intra"])
def test_an_option_ends_at_a_door_that_has_closed(name):
    method = in_corridor(name)
    successors = np.array(CORRIDOR.successors)
    successors[1, EAST], successors[2, WEST] = 1, 2
    learner = Learner(Dynamics(successors), CORRIDOR.goal("A"), np.random.SFC64(1))
    learner.begin_episode(0)
    assert method.take(learner, 0, OPTION) == 1 and learner.steps == 2
