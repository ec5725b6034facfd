"""Random hostile arguments for every public call of the compiled modules: refused, or harmless.

`make test-sanitizers` runs this file with longer series (``PTL_CALLS``) on extensions built with the address and
undefined-behaviour sanitizers, which end the process at the first read outside an array.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from ptl.agent._episodes import run_episodes
from ptl.agent._kernel import Dynamics, Learner
from ptl.agent._paths import frequency_and_distance, last_covered
from ptl.agent.plan import Guide, Mixing, Plan
from ptl.agent.selection import prior
from ptl.agent.subgoals import discover
from ptl.learning._survey import subgoals_from
from ptl.world import _graph
from ptl.world._graph import breadth_first
from ptl.world.gridworld import GridWorld
from ptl.world.transitions import TransitionGraph

CALLS = int(os.environ.get("PTL_CALLS", "1500"))
"""Calls of each test."""

REFUSALS = (ValueError, TypeError, OverflowError, RuntimeError, MemoryError)
WORLD = GridWorld.from_text("I....\n.#.#.\n....A\n")
N = WORLD.n_states
DTYPES = ("i1", "u1", "i4", ">i4", "u4", "i8", ">i8", "u8", "f4", "f8", "c16", "?", "O", "U3", "M8[s]", "V4")


class Ticking:
    """A whole number that is another one each time it is asked for its value."""

    def __init__(self, *values: int) -> None:
        self.values = list(values)

    def __index__(self) -> int:
        self.values.append(self.values.pop(0))
        return self.values[-1]


class Hostile:
    """Draws arguments: good ones, nearly good ones and absurd ones.

    Parameters
    ----------
    seed : int
    """

    def __init__(self, seed: int) -> None:
        self.random = np.random.default_rng(seed)

    def one_of(self, *options: Any) -> Any:
        return options[self.random.integers(len(options))]

    def number(self, end: int = N) -> Any:
        """Draw a number; one in two is a whole number below ``end``."""
        if self.random.random() < 0.5:
            return int(self.random.integers(end))
        return self.one_of(
            -1, end, end + 1, -end, 255, 256, 259, 2**31 - 1, 2**31, -(2**31), 2**32, 2**32 + 1, 2**63 - 1, 2**64,
            10**30, 1.5, -0.0, 1e308, float("nan"), float("inf"), None, "3", b"3", True, [], (1,), object(), 1j,
            np.int8(-1), np.uint64(2**64 - 1), np.float64(2.0), np.array(1), np.array([1]), Ticking(0, 10**9),
            Ticking(-1, 1),
        )  # fmt: skip

    def share(self) -> Any:
        """Draw a probability; one in two is within [0, 1]."""
        return self.random.random() if self.random.random() < 0.5 else self.number(2)

    def array(self, *shape: int, low: int = 0, high: int = N, dtype: Any = np.int64) -> Any:
        """Draw an array; half of them have the shape, the type and the range asked for."""
        random = self.random
        good = random.integers(low, high, size=shape).astype(dtype)
        if random.random() < 0.5:
            return good
        spoilt = int(random.integers(9))
        if spoilt == 0:  # one entry out of range
            wrong = good.astype(np.int64)
            if wrong.size:
                wrong.reshape(-1)[random.integers(wrong.size)] = self.one_of(-1, -2, high, 2**31 - 1, 2**32, -(2**63))
            return wrong
        if spoilt == 1:
            wrong = good.astype(np.float64)
            if wrong.size:
                wrong.reshape(-1)[random.integers(wrong.size)] = self.one_of(
                    np.nan, np.inf, -np.inf, 0.5, 1e301, 1e-320
                )
            return wrong
        if spoilt == 2:  # another shape
            return random.integers(low, high, size=[int(random.integers(4)) for _ in range(random.integers(4))])
        if spoilt == 3:
            return np.zeros(shape, dtype=self.one_of(*DTYPES))
        if spoilt == 4:  # the same numbers, laid out in another way
            return self.one_of(good[::-1], np.asfortranarray(good), np.repeat(good, 2, axis=0)[::2], good.byteswap())
        if spoilt == 5:
            good.flags.writeable = False
            return good
        if spoilt == 6:  # does not own its memory
            return np.broadcast_to(good.reshape(-1)[:1] if good.size else good, self.one_of(shape, (10**4, *shape[1:])))
        if spoilt == 7:
            return good.tolist()
        return self.number()


def learner_of(hostile: Hostile) -> Learner:
    """Return a learner of short episodes, so that no call can take long."""
    goal = int(hostile.random.integers(N))
    return Learner(
        Dynamics(WORLD.successors), goal, np.random.SFC64(1), max_steps=300, shortcut=hostile.one_of(True, False)
    )


def learner_calls(hostile: Hostile) -> dict[str, Callable[[Learner], Any]]:
    """Return the public calls of a learner, each with arguments drawn when it is called."""
    values = lambda *shape: hostile.array(*shape, high=2, dtype=np.float64)  # noqa: E731
    mask = lambda *shape: hostile.one_of(None, hostile.array(*shape, low=1, high=2, dtype=bool))  # noqa: E731
    policy = lambda: hostile.array(N, low=-1, high=4, dtype=np.int8)  # noqa: E731
    return {
        "begin_episode": lambda agent: agent.begin_episode(hostile.number()),
        "explore": lambda agent: agent.explore(
            hostile.number(100),
            hostile.one_of(None, hostile.share()),
            bonus=hostile.one_of(None, values(N, 4)),
            mask=mask(N, 4),
        ),
        "choose": lambda agent: agent.choose(
            hostile.one_of(None, hostile.share()), bonus=hostile.one_of(None, values(4)), mask=mask(4)
        ),
        "act": lambda agent: agent.act(hostile.number(4), learn=hostile.one_of(True, False)),
        "follow": lambda agent: agent.follow(policy(), hostile.number(), hostile.number(100)),
        "reuse": lambda agent: agent.reuse(policy(), hostile.share(), hostile.share()),
        "record": lambda agent: agent.record(hostile.number(1000)),
        "update": lambda agent: agent.update(hostile.number(), hostile.number(4), hostile.share()),
        "set_value": lambda agent: agent.set_value(hostile.number(), hostile.number(4), hostile.share()),
        "set_q": lambda agent: agent.set_q(values(N, 4)),
        "value": lambda agent: agent.value(hostile.number(), hostile.number(4)),
        "values_of": lambda agent: agent.values_of(hostile.number()),
        "__init__": lambda agent: agent.__init__(hostile.number(), hostile.number(), hostile.number()),
        "erased_path": Learner.erased_path,
    }


def test_the_list_of_calls_is_complete():
    public = {name for name in vars(Learner) if not name.startswith("_")}
    asked = {name for name in public if type(vars(Learner)[name]).__name__ == "getset_descriptor"}
    assert public - asked - {"dynamics"} == set(learner_calls(Hostile(0))) - {"__init__"}


@pytest.mark.parametrize("seed", range(3))
def test_a_learner_stays_sound_whatever_it_is_handed(seed, record_property):
    hostile = Hostile(seed)
    agent = learner_of(hostile)
    calls = list(learner_calls(hostile).values())
    refused = 0
    for number in range(CALLS):
        if number % 100 == 0:
            agent = learner_of(hostile)
        try:
            hostile.one_of(*calls)(agent)
        except REFUSALS:
            refused += 1
        assert 0 <= agent.state < N and 0 <= agent.steps <= 300
        assert np.isfinite(agent.q).all()
        assert ((agent.recorded >= 0) & (agent.recorded < 4)).all()
        path = agent.erased_path()
        assert len(set(path.tolist())) == len(path) and path[-1] == agent.state
        assert (agent.seen < 16).all()
    assert CALLS / 10 < refused < CALLS, "the arguments must be neither all good nor all bad"
    record_property("hostile calls of compiled code", CALLS)


def test_objects_are_made_whole_or_not_at_all(record_property):
    hostile = Hostile(10)
    made = 0
    for _ in range(CALLS):
        try:
            dynamics = Dynamics(hostile.array(N, 4))
            agent = Learner(
                hostile.one_of(dynamics, dynamics, hostile.number()), hostile.number(),
                hostile.one_of(np.random.SFC64(1), np.random.MT19937(1), hostile.number()),
                alpha=hostile.share(), gamma=hostile.share(), epsilon=hostile.share(),
                max_steps=hostile.one_of(100, hostile.number()),
                initial_q=hostile.one_of(None, hostile.array(N, 4, high=2, dtype=np.float64)),
                shortcut=hostile.one_of(True, False),
            )  # fmt: skip
        except REFUSALS:
            continue
        made += 1
        agent.begin_episode(0)
        agent.explore(50)
        assert 0 <= agent.state < dynamics.n_states and np.isfinite(agent.q).all()
    assert made
    record_property("hostile calls of compiled code", CALLS)


def test_a_plan_hands_nothing_unchecked_to_the_loop(record_property):
    hostile = Hostile(15)
    refused = 0
    calls = CALLS // 3
    for _ in range(calls):
        agent = learner_of(hostile)
        others = list(learner_calls(hostile).values())

        def draw(agent=agent, others=others) -> Any:
            if hostile.random.random() < 0.2:  # a method may move the agent wherever it is asked
                hostile.one_of(*others)(agent)
            return hostile.one_of(0, 1, 1, hostile.number(2))

        def guide(_: int) -> Any:
            policy = hostile.array(N, low=-1, high=4, dtype=np.int8)
            states = hostile.one_of(None, None, hostile.array(N, high=2, dtype=bool))
            return hostile.one_of(None, Guide(policy, hostile.one_of(None, hostile.number()), states), hostile.number())

        try:
            mixing = hostile.one_of(None, None, Mixing(hostile.share(), hostile.share()))
            plan = Plan(
                draw, guide, mixing=mixing, epsilon=hostile.one_of(None, hostile.share()),
                patience=hostile.one_of(None, 7.0, hostile.share()), growth=hostile.one_of(1.0, 2.0, hostile.number()),
            )  # fmt: skip
            steps, _, drawn, _ = run_episodes(
                agent, plan, hostile.number(), hostile.one_of(5, 5, 5, 0, -1, "3"), hostile.number(5)
            )
            assert len(steps) == len(drawn)
        except (*REFUSALS, AttributeError):
            refused += 1
        assert 0 <= agent.state < N and np.isfinite(agent.q).all() and (agent.seen < 16).all()
    assert calls / 10 < refused < calls
    record_property("hostile calls of compiled code", calls)


def graph_calls(hostile: Hostile) -> list[Callable[[], Any]]:
    """Return calls of the graph search and of the functions that pass states to it."""
    rows = lambda: hostile.array(N + 1, high=N, dtype=np.int32)  # noqa: E731
    ends = lambda: hostile.array(4 * N, dtype=np.int32)  # noqa: E731
    graph = lambda: TransitionGraph(  # noqa: E731
        hostile.array(N, 4), hostile.one_of(None, hostile.array(N, high=16, dtype=np.uint8))
    )
    places = lambda: hostile.array(2, high=6, dtype=np.int64)  # noqa: E731
    known = lambda: hostile.array(N, 4, high=2, dtype=np.uint8)  # noqa: E731
    moves = lambda: hostile.array(N, 4, dtype=np.int32)  # noqa: E731
    flags = lambda: hostile.array(N, high=2, dtype=np.uint8)  # noqa: E731
    paths = lambda: [hostile.array(5) for _ in range(hostile.random.integers(3))]  # noqa: E731
    return [
        lambda: breadth_first(np.sort(rows()), ends(), hostile.array(2, dtype=np.int32)),
        lambda: breadth_first(rows(), ends(), hostile.array(2, dtype=np.int32)),
        lambda: _graph.compressed_rows(moves(), known(), hostile.one_of(True, False), hostile.one_of(True, False)),
        lambda: _graph.first_steps(moves(), known(), hostile.array(N, low=-1, dtype=np.int32)),
        lambda: _graph.diameter(moves(), known()),
        lambda: last_covered(hostile.array(6, dtype=np.int32), np.sort(places()), places(), flags()),
        lambda: frequency_and_distance(
            hostile.array(6, dtype=np.int32),
            np.sort(places()),
            places(),
            hostile.one_of(N, N, -1),
            hostile.one_of("tent", 3),
        ),
        lambda: graph().steps_from(hostile.one_of(hostile.array(2), [hostile.number()])),
        lambda: graph().steps_to(hostile.number()),
        lambda: graph().shortest_path_policy(hostile.number()),
        lambda: graph().diameter(),
        lambda: WORLD.distances_to(hostile.number()),
        lambda: WORLD.shortest_path_length(hostile.number(), hostile.number()),
        lambda: discover(paths(), WORLD.transitions, [hostile.number()], hostile.number(4)),
        lambda: prior(WORLD.cells, hostile.array(2), hostile.number(), hostile.share()),
    ]


@pytest.mark.filterwarnings("ignore::numpy.exceptions.ComplexWarning")
def test_searches_refuse_what_is_no_graph(record_property):
    hostile = Hostile(20)
    refused = 0
    for _ in range(CALLS):
        try:
            hostile.one_of(*graph_calls(hostile))()
        except REFUSALS:
            refused += 1
    assert CALLS / 10 < refused < CALLS
    record_property("hostile calls of compiled code", CALLS)


def test_the_survey_refuses_what_are_no_tasks(record_property):
    hostile = Hostile(30)
    dynamics = Dynamics(WORLD.successors)
    calls = CALLS // 3
    answered = 0
    for _ in range(calls):
        try:
            subgoals, steps = subgoals_from(
                hostile.one_of(dynamics, dynamics, dynamics, hostile.number()), hostile.number(), hostile.array(3),
                np.random.SFC64(1), hostile.number(4), hostile.number(5),
                alpha=hostile.one_of(0.05, hostile.share()), gamma=hostile.one_of(0.95, hostile.share()),
                epsilon=hostile.one_of(0.1, hostile.share()), max_steps=200,
            )  # fmt: skip
        except REFUSALS:
            continue
        answered += 1
        assert ((subgoals >= -2) & (subgoals < N)).all() and steps >= 0
    assert answered
    record_property("hostile calls of compiled code", calls)
