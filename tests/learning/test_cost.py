"""Costs of the package, counted rather than timed: no number here depends on the machine or on its load."""

from __future__ import annotations

import gc
import re
import shutil
import subprocess
import sys
import tracemalloc
from collections import Counter
from collections.abc import Callable

import numpy as np
import pytest

from ptl import methods
from ptl.agent import seeding
from ptl.agent._kernel import Dynamics, Learner
from ptl.agent._selection import SkillSelection
from ptl.config import Parameters
from ptl.learning import life as learning
from ptl.world import mazes
from ptl.world._graph import searches
from ptl.world.gridworld import GridWorld
from ptl.world.transitions import TransitionGraph

READ_AHEAD = 256  # random words that the kernel takes at a time


def words_drawn(generator: np.random.SFC64) -> int:
    """64-bit words taken since the generator was made: the fourth number of SFC64's state counts them."""
    fresh = np.random.SFC64(0).state["state"]["state"][3]
    return int(generator.state["state"]["state"][3] - fresh)


def test_the_generator_counts_its_words():
    generator = np.random.SFC64(5)
    generator.random_raw(1000)
    assert words_drawn(generator) == 1000


# -- random numbers ------------------------------------------------------------------------------------------


def test_a_simulated_step_takes_half_a_random_word(env1: GridWorld):
    generator = np.random.SFC64(1)
    learner = Learner(Dynamics(env1.successors), env1.goals["F"], generator, shortcut=False)
    steps = 0
    for _ in range(20):
        learner.begin_episode(env1.start)
        learner.explore()
        steps += learner.steps
    assert steps > 100_000
    assert words_drawn(generator) <= steps / 2 + READ_AHEAD + 1


def test_a_cold_step_takes_a_thirty_second_of_a_random_word():
    world = GridWorld.from_text("I.....\n.....A\n######\n......\n")
    beyond = world.n_states - 1  # behind the wall, so that walking stays cold for ever
    generator = np.random.SFC64(1)
    learner = Learner(Dynamics(world.successors), beyond, generator)
    learner.begin_episode(world.start)
    steps = 32 * READ_AHEAD * 10
    learner.explore(budget=steps)
    assert learner.steps == steps
    assert words_drawn(generator) == steps / 32


def test_the_shortcut_saves_most_of_the_random_numbers_of_a_first_episode(env1: GridWorld):
    words = {}
    for shortcut in (True, False):
        generator = np.random.SFC64(3)
        learner = Learner(
            Dynamics(env1.successors), env1.goals["F"], generator, alpha=0.0, shortcut=shortcut, max_steps=10**12
        )
        steps = 0
        for _ in range(20):
            learner.begin_episode(env1.start)
            learner.explore()
            steps += learner.steps
        words[shortcut] = words_drawn(generator) / steps
    assert words[True] < words[False] / 10


def test_a_selection_draws_one_random_number():
    generator = np.random.SFC64(2)
    selection = SkillSelection(np.full(1000, 1e-3))
    random = np.random.Generator(generator)
    for _ in range(50):
        selection.draw(random)
    assert words_drawn(generator) == 50


# -- calls ---------------------------------------------------------------------------------------------------


def calls_of(work: Callable[[], object]) -> Counter[str]:
    """Calls of Python and C functions that the work makes, by name."""
    calls: Counter[str] = Counter()

    def note(frame, event: str, argument) -> None:
        if event == "call":
            calls[frame.f_code.co_qualname] += 1
        elif event == "c_call":
            calls[getattr(argument, "__qualname__", str(argument))] += 1

    gc.disable()  # a collection calls what others have asked it to
    sys.setprofile(note)
    try:
        work()
    finally:
        sys.setprofile(None)
        gc.enable()
    return calls


def one_task(world: GridWorld, method: str, episodes: int) -> Callable[[], learning.TaskRecord]:
    parameters = Parameters().replace(learning__episodes=episodes)
    learner = methods.load(method)(world, parameters, seeding.generator(0, "choices"))
    task = learning.Task("A", world.start, next(iter(world.goals.values())))
    stream = seeding.bit_generator(0, "steps")
    return lambda: learning.learn_task(world, Dynamics(world.successors), task, learner, parameters, stream)


def calls_and_draws_of_late_episodes(world: GridWorld, method: str) -> tuple[int, int]:
    """Calls and draws of 100 episodes that come after the subgoals' trajectories are complete."""
    totals, draws = [], []
    for episodes in (40, 140):
        work, records = one_task(world, method, episodes), []
        totals.append(calls_of(lambda work=work, records=records: records.append(work())).total())
        draws.append(sum(len(drawn) for drawn in records[0].selected))
    return totals[1] - totals[0], draws[1] - draws[0]


@pytest.mark.parametrize("name", ["no_transfer", "full_transfer"])
def test_an_episode_makes_no_calls_however_long_it_is(name: str, published_maps: dict[str, GridWorld]):
    for world in published_maps.values():
        calls, _ = calls_and_draws_of_late_episodes(world, name)
        assert calls == 0


def test_an_episode_of_ptl_makes_few_calls_for_each_skill_drawn(published_maps: dict[str, GridWorld]):
    for world in published_maps.values():
        calls, draws = calls_and_draws_of_late_episodes(world, "ptl")
        assert 100 <= draws <= 300
        assert draws <= calls <= 8 * draws


# -- searches ------------------------------------------------------------------------------------------------


def searches_of(work: Callable[[], object]) -> int:
    """Number of breadth-first searches that the work makes."""
    before = searches()
    work()
    return searches() - before


def world_of(kind: str, states: int) -> GridWorld:
    """Return a chain of rooms or random rooms with about so many states and goal A."""
    if kind == "chain":
        return GridWorld.from_text(mazes.chain_of_rooms(max(2, states // 101), 10, "A"))
    random = np.random.default_rng(states)
    return GridWorld.from_text(mazes.to_text(mazes.with_letters(random, mazes.rooms(random, states), "A")))


def test_searches_are_counted(env2: GridWorld):
    assert searches_of(lambda: env2.transitions.steps_to(0)) == 1


@pytest.mark.parametrize("kind", ["chain", "rooms"])
@pytest.mark.parametrize("states", [300, 3000, 30_000])
def test_the_diameter_needs_few_searches(kind: str, states: int):
    graph = TransitionGraph(world_of(kind, states).successors)
    assert searches_of(graph.diameter) <= 60


def test_the_diameter_of_open_ground_needs_few_searches():
    for side in (10, 30, 100):
        grid = mazes.with_letters(np.random.default_rng(side), mazes.framed(side, side), "A")
        assert searches_of(TransitionGraph(GridWorld.from_text(mazes.to_text(grid)).successors).diameter) <= 10


def test_the_diameter_of_a_ring_is_the_known_worst_case():
    grid = np.full((51, 51), mazes.FREE)
    grid[1:-1, 1:-1] = mazes.WALL
    graph = TransitionGraph(
        GridWorld.from_text(mazes.to_text(mazes.with_letters(np.random.default_rng(0), grid, "A"))).successors
    )
    assert graph.diameter() == 100
    assert searches_of(graph.diameter) <= 201


def test_a_task_is_searched_a_few_times_beside_its_diameter(env1: GridWorld):
    work = one_task(env1, "ptl", 40)
    assert searches_of(work) <= searches_of(env1.transitions.diameter) + 12


def test_a_method_without_a_library_searches_nothing(env1: GridWorld):
    assert searches_of(one_task(env1, "no_transfer", 40)) == 0


# -- memory --------------------------------------------------------------------------------------------------


def bytes_of(work: Callable[[], object]) -> int:
    """Bytes allocated at the end of the work, while its result is referenced."""
    tracemalloc.start()
    try:
        kept = work()
        held = tracemalloc.get_traced_memory()[0]
    finally:
        tracemalloc.stop()
    del kept
    return held


def test_the_tables_of_a_learner_grow_with_the_states():
    per_state = []
    for states in (3000, 30_000):
        successors = world_of("rooms", states).successors
        held = bytes_of(lambda table=successors: Learner(Dynamics(table), 0, np.random.SFC64(0)))
        per_state.append(held / len(successors))
    assert per_state[1] <= 1.05 * per_state[0]
    assert per_state[1] <= 400


def test_a_life_keeps_no_more_of_a_late_task_than_of_an_early_one(env2: GridWorld):
    parameters = Parameters().replace(learning__episodes=40)

    def life(tasks: int) -> learning.Life:
        task = learning.tasks_of(env2, "F") * tasks
        return learning.learn_life(env2, task, "ptl", parameters, 0, "env2", 0)

    life(1)
    few, many = bytes_of(lambda: life(10)), bytes_of(lambda: life(30))
    assert many <= 3.3 * few
    assert many / 30 <= 150 * env2.n_states


# -- instructions --------------------------------------------------------------------------------------------

WALK = """
import numpy as np
from ptl.agent._kernel import Dynamics, Learner
from ptl.world.map_files import load_map
world = load_map({path!r})
learner = Learner(Dynamics(world.successors), world.goals["F"], np.random.SFC64(1), shortcut={shortcut})
steps = 0
while steps < 300_000:
    learner.begin_episode(world.start)
    learner.explore()
    steps += learner.steps
print(steps)
"""


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("valgrind") is None, reason="needs valgrind (apt-get install valgrind)")
@pytest.mark.parametrize(("shortcut", "most"), [(False, 100), (True, 25)])
def test_a_step_takes_few_instructions(shortcut: bool, most: float, env1: GridWorld, tmp_path):
    """Instructions of the loop and all that it calls; on x86-64 with gcc 12 they are about 68 and 14."""
    counts = tmp_path / "callgrind"
    program = WALK.format(path=env1.name, shortcut=shortcut)
    done = subprocess.run(
        ["valgrind", "--tool=callgrind", "--toggle-collect=*run_greedily*", f"--callgrind-out-file={counts}",
         sys.executable, "-c", program],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    steps = int(done.stdout)
    instructions = int(re.search(r"^(?:summary|totals): (\d+)$", counts.read_text(), re.M)[1])
    assert 2 <= instructions / steps <= most
