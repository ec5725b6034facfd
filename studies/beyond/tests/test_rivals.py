"""The methods of the second study behave as described."""

from __future__ import annotations

import numpy as np
import pytest
from mazes import chain_of_rooms

from ptl import methods
from ptl.agent._kernel import Dynamics, Learner
from ptl.agent.plan import Leader
from ptl.agent.skills import Skill
from ptl.config import Parameters
from ptl.files import store
from ptl.jobs import Learn
from ptl.learning.life import learn_life, tasks_of
from ptl.learning.trial import check_method
from ptl.report.explorer.data import collect
from ptl.world.gridworld import GridWorld, map_digest
from ptl.world.transitions import TransitionGraph
from studies.beyond.methods import names, reference

FEW = Parameters().replace(learning__episodes=30)
NORTH, SOUTH, WEST, EAST = range(4)
RING = GridWorld.from_text("I...\n.##.\n.##B\n...A\n", "ring")


def make(name: str, world: GridWorld, seed: int = 0, **changes) -> methods.BaseMethod:
    return methods.load(reference(name))(world, Parameters().replace(**changes), np.random.default_rng(seed))


def steps_of(name: str, world: GridWorld, seed: int, tasks: str, parameters: Parameters = FEW) -> list[np.ndarray]:
    life = learn_life(world, tasks_of(world, tasks), reference(name), parameters, seed)
    return [record.steps for record in life.records]


@pytest.mark.parametrize("name", names())
def test_a_life_of_each_is_a_sound_file_that_the_explorer_shows(name, tmp_path):
    """A method may draw candidates that are not skills of the library."""
    job = Learn(
        root_seed=15, parameters=FEW.to_dict(), maps={"ring": map_digest(RING.text)}, code="0" * 16, environment="ring",
        tasks="AB", method=name, reference=reference(name), seed=0,
    )  # fmt: skip
    store.write(tmp_path / "seed_000.h5", job, job.run({"ring": RING}), {"ring": RING})
    result = store.read(tmp_path / "seed_000.h5", job)
    [entry] = collect([result], window=5, kinds={name: methods.load(reference(name))})["environments"]
    drawn = [task["drawn"] for task in entry["runs"][f"{name}/0"]["tasks"]]
    life = learn_life(RING, tasks_of(RING, "AB"), reference(name), FEW, 15, "ring", 0)
    assert drawn == [[list(episode) for episode in task.selected] for task in life.records]


@pytest.mark.parametrize("name", names())
def test_each_method_is_sound_and_apart_from_the_comparison(name):
    assert name not in methods.names()
    assert methods.identifier(reference(name)) == name
    check_method(reference(name))


def test_looks_are_told_apart():
    made = [methods.load(reference(name)) for name in [*names(), *methods.names()]]
    assert len({method.colour for method in made}) == len({method.label for method in made}) == len(made)
    assert reference("ptl") == "ptl"


# -- optimism


def test_optimism_tries_everything_once_where_moves_are_certain():
    world = GridWorld.from_text("I.A\n")
    [steps] = steps_of("optimistic_fast", world, 1, "A", FEW.replace(learning__episodes=5))
    # at most: all four actions of both states, and the ways back from state 1
    assert steps[0] <= 10 and steps[-1] == 2
    slow, fast = (steps_of(name, RING, 1, "A")[0].sum() for name in ("optimistic", "optimistic_fast"))
    assert slow > 3 * fast


def test_maxqinit_by_hand():
    world = GridWorld.from_text("I.A\n")
    method = make("maxqinit", world)
    assert method.parameters.learning.alpha == 1
    np.testing.assert_array_equal(method.begin_task(0, 2), np.ones((3, 4)))
    for east in (0.25, 0.75, 0.5):
        learner = Learner(Dynamics(world.successors), 2, np.random.SFC64(1), alpha=1.0)
        learner.begin_episode(0)
        learner.act(EAST)
        learner.set_q(np.full((3, 4), east))
        method.end_task(learner)
    expected = np.ones((3, 4))
    expected[0, EAST] = 0.75
    np.testing.assert_array_equal(method.begin_task(0, 2), expected)


# -- the readings of what a skill does


@pytest.mark.parametrize("use", ["lead_in", "reselect", "mixing", "initial_values"])
def test_a_named_reading_is_ptl_with_that_reading(use):
    """Equal lives from equal random numbers, whatever the configuration says for the named one."""
    world = GridWorld.from_text(chain_of_rooms(5, 4, "ABC"), "chain")
    lives = [
        learn_life(world, "ABC", type("Same", (methods.load(reference(name)),), {"name": "same"}), parameters, 3)
        for name, parameters in (
            (f"ptl_{use}", FEW.replace(skills__skill_use="mixing" if use == "lead_in" else "lead_in")),
            ("ptl", FEW.replace(skills__skill_use=use)),
        )
    ]
    assert len(lives[0].library) > 0
    for named, configured in zip(lives[0].records, lives[1].records, strict=True):
        assert named.selected == configured.selected and named.steps.tolist() == configured.steps.tolist()


# -- libraries


def follow(learner: Learner, guide: Leader | None) -> None:
    learner.follow(guide.policy, guide.subgoal)


def test_a_skill_to_every_state_is_a_shortest_path():
    method = make("all_goals", RING)
    method.begin_task(RING.start, RING.goal("A"))
    assert method.candidates == [RING.start]
    learner = Learner(Dynamics(RING.successors), RING.goal("A"), np.random.SFC64(1))
    for _ in range(20):
        learner.begin_episode(RING.start)
        learner.explore(epsilon=1.0)
    graph = TransitionGraph(RING.successors, learner.seen)
    method.library.update(None, graph, 0)
    method.end_task(learner)
    method.begin_task(RING.start, RING.goal("B"))
    assert method.candidates == [RING.start, *range(RING.n_states)] and len(method.library) == RING.n_states
    for subgoal in (5, 8):
        learner.begin_episode(RING.start)
        follow(learner, method.guide(1 + subgoal))
        assert (learner.state, learner.steps) == (subgoal, graph.steps_to(subgoal)[RING.start])


# -- the frontier

LINE = GridWorld.from_text("B.I......A\n", "line")


def look(name: str, world: GridWorld, seen: dict[int, list[int]], goal: str, **changes) -> methods.BaseMethod:
    """Return the method at the beginning of a task, when some actions have been seen in some states."""
    method = make(name, world, **changes)
    for state, actions in seen.items():
        method.after_before[state, actions] = world.successors[state, actions]
    method.begin_task(world.start, world.goal(goal))
    return method


@pytest.mark.parametrize(
    ("seen", "frontier"),
    [
        ({}, 2),  # the start itself
        ({2: [EAST]}, 3),
        ({2: [EAST], 3: [0, 1, 2, 3], 4: [0, 1, 2, 3]}, 5),
        ({2: [EAST], 3: [EAST], 4: [0, 1, 2, 3], 5: [0, 1, 2, 3], 6: [WEST]}, 6),
        ({2: [EAST], 3: [EAST], 4: [0, 1, 2, 3], 5: [0, 1, 2], 6: [0, 1, 2, 3]}, 5),
        ({state: [EAST] for state in range(2, 9)}, 9),  # the goal, once seen
        ({7: [EAST]}, 2),  # seen, but no way leads there
    ],
)
def test_the_frontier_is_the_open_state_nearest_to_the_goal(seen, frontier):
    assert look("ptl_frontier", LINE, seen, "A").frontier == frontier


def test_ties_of_the_frontier_go_by_steps_then_by_number():
    world = GridWorld.from_text("...\nI#A\n...\n")
    ways = {world.start: [NORTH, SOUTH], 0: [EAST], 5: [EAST]}
    # states: 0 1 2 / 3 (start), 4 (goal) / 5 6 7; 1 and 6 are as near to the goal and to the start
    assert look("ptl_frontier", world, ways, "A").frontier == 1
    ways[1] = [0, 1, 2, 3]
    assert look("ptl_frontier", world, ways, "A").frontier == 2


def test_drawing_the_frontier_follows_what_was_seen():
    method = look("ptl_frontier", LINE, {2: [EAST], 3: [0, 1, 2, 3], 4: [0, 1, 2, 3]}, "A")
    learner = Learner(Dynamics(LINE.successors), LINE.goal("A"), np.random.SFC64(1))
    learner.begin_episode(LINE.start)
    method._learner = learner
    follow(learner, method.guide(1))
    assert (learner.state, learner.steps) == (5, 3)
    learner.act(EAST)
    method.draw_skill()
    assert method.frontier == 6
    assert len(method.selection.prior) == 2


def test_the_path_prior_by_hand():
    """Weights exp(-steps to f / (sigma L)); a subgoal from which no seen path leads to f has none."""
    method = make("ptl_frontier_path", LINE, skills__prior_width=0.1)
    method.library.skills = [Skill(subgoal, np.full(10, -1, dtype=np.int8), 0) for subgoal in (4, 1)]
    for state in range(2, 6):
        method.after_before[state] = LINE.successors[state]
    method.begin_task(LINE.start, LINE.goal("A"))
    assert method.frontier == 6
    weights = np.exp(-np.array([4, 2, np.inf, 0]) / (0.1 * LINE.diagonal))
    np.testing.assert_allclose(method.selection.prior, weights / weights.sum())
    alone = make("ptl_path_prior", LINE, skills__prior_width=0.1)
    alone.library, alone.after_before = method.library, method.after_before
    alone.begin_task(LINE.start, LINE.goal("A"))
    np.testing.assert_allclose(alone.selection.prior, weights[:3] / weights[:3].sum())


def test_without_a_library_only_the_frontier_guides():
    life = learn_life(LINE, tasks_of(LINE, "AB"), reference("frontier_only"), FEW, 1)
    assert len(life.library) == 0
    assert {number for record in life.records for drawn in record.selected for number in drawn} == {0, 1}
