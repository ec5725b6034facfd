"""The article's finder of subgoals against results worked out by hand."""

from __future__ import annotations

import numpy as np

from ptl.agent.finders import incremental
from ptl.agent.skills import SkillLibrary
from ptl.agent.subgoals import discover
from ptl.world.gridworld import GridWorld
from ptl.world.transitions import TransitionGraph

CORRIDOR = GridWorld.from_text("I.......A\n")
ALL_SEEN = TransitionGraph(CORRIDOR.successors)
WHOLE_PATH = [np.arange(9)] * 3


def test_the_incremental_metric_by_hand():
    discovery = discover(WHOLE_PATH, ALL_SEEN, [4], 2)
    # beyond the states within 2 of state 4 the rest is 6, 7, 8, with 7 half-way
    assert incremental(discovery, ALL_SEEN, [4]).argmax() == 7


def test_the_best_state_becomes_a_skill():
    """The incremental metric determines whether a skill is added, the finder where."""
    library = SkillLibrary(finder=incremental)
    assert library.update(discover([np.arange(2)], ALL_SEEN, [], 2), ALL_SEEN, 0).subgoal == -1
    discovery = discover(WHOLE_PATH, ALL_SEEN, [], 2)
    place = int(incremental(discovery, ALL_SEEN, []).argmax())
    assert library.update(discovery, ALL_SEEN, 0).subgoal == place
    assert library.skills[0].policy.tolist() == ALL_SEEN.shortest_path_policy(place).tolist()
