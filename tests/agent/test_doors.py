"""Arguments from Python to compiled code are checked or copied, and long loops can be stopped."""

from __future__ import annotations

import signal
import threading
import time

import numpy as np
import pytest

from ptl.agent._kernel import Dynamics, Learner
from ptl.agent.selection import prior
from ptl.agent.subgoals import discover
from ptl.world._graph import breadth_first
from ptl.world.gridworld import GridWorld
from ptl.world.transitions import TransitionGraph

WORLD = GridWorld.from_text("I....\n.#.#.\n....A\n")
GOAL = WORLD.goals["A"]
WILD = [-1, WORLD.n_states, 10**9, 10**12, 10**30, 1.5, "3"]


def learner(**options) -> Learner:
    return Learner(Dynamics(WORLD.successors), GOAL, np.random.SFC64(1), **options)


class Interfering:
    """A whole number that does something when it is asked for its value."""

    def __init__(self, value: int, act) -> None:
        self.value, self.act = value, act

    def __index__(self) -> int:
        self.act()
        return self.value


@pytest.mark.parametrize("state", WILD)
def test_what_is_not_a_state_is_refused(state):
    graph = WORLD.transitions
    calls = [
        lambda: WORLD.distances_to(state),
        lambda: WORLD.shortest_path_length(state, GOAL),
        lambda: graph.steps_from([state]),
        lambda: graph.shortest_path_policy(state),
        lambda: discover([np.array([0, 1])], graph, [state], 2),
        lambda: discover([[0, state]], graph, [], 2),
        lambda: prior(WORLD.cells, [0], state, 5.0),
    ]
    for call in calls:
        with pytest.raises((ValueError, OverflowError)):
            call()


def test_states_may_lie_apart_in_memory():
    apart = np.arange(8, dtype=np.int32)[::2]
    np.testing.assert_array_equal(WORLD.transitions.steps_from(apart), WORLD.transitions.steps_from(apart.tolist()))
    columns = np.repeat(WORLD.successors, 2, axis=1)[:, ::2]
    assert TransitionGraph(columns).diameter() == WORLD.transitions.diameter()


def test_an_empty_path_is_refused():
    with pytest.raises(ValueError, match="path"):
        discover([np.array([], dtype=int)], WORLD.transitions, [], 2)


@pytest.mark.parametrize(
    ("first", "neighbours", "sources"),
    [
        ([0, 1, 2], [1, 0], [-1]),
        ([0, 1, 2], [1, 0], [2]),
        ([0, 1, 2], [1, 10**9], [0]),
        ([0, 1, 2], [-1, 0], [0]),
        ([0, 1, 10**9], [1, 0], [0]),
        ([-5, 1, 2], [1, 0], [0]),
        ([0, 10**9, 2], [1, 0], [0]),
        ([], [], []),
    ],
)
def test_rows_that_are_no_graph_are_refused(first, neighbours, sources):
    with pytest.raises(ValueError):
        breadth_first(*(np.array(values, dtype=np.int32) for values in (first, neighbours, sources)))


def test_successors_of_a_graph_must_be_states():
    for wrong in ([[0, 0, 0, 7]], [[0, 0, 0, -1]], [[0, 0, 0]], [[0.5, 0, 0, 0]]):
        with pytest.raises(ValueError):
            TransitionGraph(np.array(wrong))


def test_a_policy_changed_during_the_call_is_not_followed():
    """The policy is read before the budget is asked for; a change after the check must not reach the loop."""
    policy = np.full(WORLD.n_states, 3, dtype=np.int8)
    agent = learner()
    agent.begin_episode(WORLD.start)
    agent.follow(policy, GOAL, Interfering(4, lambda: policy.fill(100)))
    assert agent.steps == 4 and agent.state == WORLD.state_at(0, 4)


def test_successors_changed_afterwards_do_not_reach_the_kernel():
    successors = WORLD.successors.copy()
    agent = Learner(Dynamics(successors), GOAL, np.random.SFC64(1))
    successors[:] = 10**9
    agent.begin_episode(WORLD.start)
    agent.explore()
    assert agent.at_goal


def test_recording_cannot_begin_within_another_call():
    agent = learner()
    agent.begin_episode(WORLD.start)
    with pytest.raises(ValueError, match="recording"):
        agent.record(Interfering(10**6, lambda: agent.act(1)))
    assert len(agent.recorded) == 0


def test_another_thread_is_refused():
    agent = learner()
    refused = []

    def use() -> None:
        calls = (
            lambda: agent.begin_episode(0), agent.explore, lambda: agent.act(1), agent.choose, agent.erased_path,
            lambda: agent.follow(np.zeros(WORLD.n_states, dtype=np.int8), 0),
            lambda: agent.reuse(np.zeros(WORLD.n_states, dtype=np.int8)), lambda: agent.record(3),
            lambda: agent.update(0, 0, 0.5), lambda: agent.set_value(0, 0, 0.5), lambda: agent.set_q(agent.q),
        )  # fmt: skip
        for call in calls:
            try:
                call()
            except RuntimeError as error:
                refused.append(str(error))

    thread = threading.Thread(target=use)
    thread.start()
    thread.join()
    assert len(refused) == 11 and all("thread" in text for text in refused)


@pytest.mark.parametrize("wrong", [None, object(), type("Fake", (), {"capsule": None})()])
def test_what_is_no_bit_generator_is_refused(wrong):
    with pytest.raises(ValueError, match="bit_generator"):
        Learner(Dynamics(WORLD.successors), GOAL, wrong)


def test_a_bit_generator_without_functions_is_refused():
    class Empty(np.random.BitGenerator):
        pass

    with pytest.raises(ValueError, match="bit_generator"):
        Learner(Dynamics(WORLD.successors), GOAL, Empty(1))


# -- long loops -----------------------------------------------------------------------------------------------

# The goal is walled in by the policy or by epsilon = 0 with a Q that leads in a circle: no call below would ever end.
CIRCLE = np.zeros((WORLD.n_states, 4))
CIRCLE[:, 0] = 1.0  # north, into the wall for ever

ENDLESS = {
    "explore": lambda agent: agent.explore(epsilon=0.0),
    "recorded": lambda agent: agent.explore(epsilon=0.0),
    "mask": lambda agent: agent.explore(mask=np.tile([True, False, False, False], (WORLD.n_states, 1))),
    "follow": lambda agent: agent.follow(np.zeros(WORLD.n_states, dtype=np.int8), GOAL),
    "reuse": lambda agent: agent.reuse(np.zeros(WORLD.n_states, dtype=np.int8), 1.0, 0.0),
}


@pytest.mark.parametrize("call", ENDLESS)
def test_a_signal_ends_a_long_call_soon(call):
    agent = learner(initial_q=CIRCLE, max_steps=10**12, alpha=0.0)
    if call == "recorded":
        agent.record(10)
    agent.begin_episode(WORLD.start)
    nested = []

    def stop(*_) -> None:
        try:
            agent.begin_episode(0)
        except RuntimeError as error:
            nested.append(str(error))
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGALRM, stop)
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.1)
        started = time.monotonic()
        with pytest.raises(KeyboardInterrupt):
            ENDLESS[call](agent)
        assert time.monotonic() - started < 10  # less than a second on an idle machine
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
    assert nested and "middle of another call" in nested[0]
    assert agent.steps > 0 and agent.state == WORLD.start
    agent.begin_episode(WORLD.start)  # usable again


def test_looks_at_signals_change_no_step():
    """With a recording every step is taken singly, with looks at other moments; the walks must be the same."""
    world = GridWorld.from_text("I" + "." * 29 + "\n" + ("." * 30 + "\n") * 14 + "." * 29 + "A\n")
    alone = world.n_states  # a goal that no move reaches
    successors = np.vstack([world.successors, np.full((1, 4), alone)])
    values = np.zeros((alone + 1, 4))
    values[world.state_at(7, 15)] = 0.5, 0.25, 0.25, 0.5  # so that walking is cold in parts only
    agents = []
    for recorded in (0, 1):
        agent = Learner(Dynamics(successors), alone, np.random.SFC64(7), initial_q=values, max_steps=10**12)
        agent.record(recorded)
        agent.begin_episode(world.start)
        agent.explore(3 * 2**24 + 5)
        agents.append(agent)
    plain, single = agents
    assert plain.steps == single.steps == 3 * 2**24 + 5
    assert plain.state == single.state and plain.q.tobytes() == single.q.tobytes()
    assert plain.erased_path().tolist() == single.erased_path().tolist()
