"""``import ptl`` as a library: the public names, the Gymnasium view, and the cost of an import."""

from __future__ import annotations

import ast
import doctest
import inspect
import subprocess
import sys
import warnings

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from matplotlib.figure import Figure
from matplotlib.quiver import Quiver
from projects import ROOT
from scipy import stats

import ptl
from ptl.config import Configuration, Environment
from ptl.errors import UserError
from ptl.world import gymnasium_env
from ptl.world.gridworld import GridWorld
from ptl.world.gymnasium_env import ID, GridWorldEnv


def test_every_public_name_is_there_and_documented():
    for name in ptl.__all__:
        thing = getattr(ptl, name)
        assert isinstance(thing, str) or thing.__doc__, name
    assert set(ptl.__all__) <= set(dir(ptl))
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = ptl.nothing


def test_the_example_of_the_package_runs(monkeypatch):
    monkeypatch.chdir(ROOT)
    assert doctest.testmod(ptl).attempted >= 3
    assert doctest.testmod(ptl).failed == 0


def test_a_learning_job_imports_nothing_that_it_does_not_need():
    code = "import sys, ptl.cli.run, ptl.jobs.kinds, ptl.files.store, ptl.methods.ptl; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert "numpy" in loaded and "h5py" in loaded
    for module in ("pandas", "scipy", "matplotlib", "snakemake", "yaml", "jinja2", "gymnasium"):
        assert module not in loaded, module


@pytest.mark.parametrize(("random_start", "slip"), [(False, 0.0), (True, 0.0), (False, 0.3)])
def test_gymnasium_view_passes_the_checker(env2, random_start, slip):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(GridWorldEnv(env2.with_slip(slip), "C", random_start=random_start), skip_render_check=True)


@pytest.mark.parametrize("slip", [0.0, 0.2, 1.0])
def test_gymnasium_view_slips_with_its_probability(slip):
    world = GridWorld.from_text("A..\n.I.\n...\n", slip=slip)
    env = GridWorldEnv(world, "A")
    env.reset(seed=4)
    counts = dict.fromkeys(world.successors[world.start].tolist(), 0)
    for _ in range(4000):
        env.reset()
        counts[int(env.step(np.int64(3))[0])] += 1
    expected = np.array([0, 0, 0, 1 - slip]) + slip / 4
    assert sum(counts.values()) == 4000 and len(counts) == 4
    if slip == 0:
        assert [*counts.values()] == [0, 0, 0, 4000]
    else:
        assert stats.chisquare([*counts.values()], 4000 * expected).pvalue > 1e-3


def test_gymnasium_view_walks_as_the_kernel_does(env2):
    env = GridWorldEnv(env2, "A", render_mode="ansi")
    learner = ptl.Learner(ptl.Dynamics(env2.successors), env2.goals["A"], np.random.SFC64(1))
    learner.begin_episode(env2.start)
    state, _ = env.reset(seed=0)
    terminated, steps = False, 0
    while not terminated:
        learner.explore(budget=1)
        action = next(a for a in range(4) if env2.successors[state, a] == learner.state)
        state, reward, terminated, truncated, _ = env.step(np.int64(action))
        steps += 1
        assert state == learner.state and not truncated and reward == float(terminated)
    assert learner.at_goal and steps == learner.steps
    assert env.render().count("@") == 1


def test_gymnasium_makes_the_environment_by_its_id():
    env = gymnasium.make(ID, world=ROOT / "config/environments/env2.txt", goal="B")
    assert env.reset(seed=1)[0] == env.unwrapped.world.start
    assert not [wrapper for wrapper in env.spec.additional_wrappers if "TimeLimit" in wrapper.name]
    with pytest.raises(UserError, match="goal"):
        gymnasium.make(ID, world=ROOT / "config/environments/env2.txt", goal="Z")


@pytest.mark.parametrize("action", [-1, 4, 1.5, True, None, "north", np.array([1, 2])], ids=repr)
def test_gymnasium_view_refuses_what_is_no_action(env2, action):
    env = GridWorldEnv(env2, "A")
    state, _ = env.reset(seed=0)
    with pytest.raises(ValueError, match="give one of 0 to 3"):
        env.step(action)
    assert env.step(np.int64(0))[0] == env2.successors[state, 0]


def test_gymnasium_view_takes_maps_of_other_programs(tmp_path):
    path = tmp_path / "lake.map"
    path.write_text("type octile\nheight 1\nwidth 4\nmap\n....\n")
    env = gymnasium.make(ID, world=path, goal="A", map_options={"start": [1, 1], "goals": [[1, 4]]})
    assert env.unwrapped.world.text == "I..A\n"


def test_the_example_of_the_gymnasium_view_runs(monkeypatch):
    monkeypatch.chdir(ROOT)
    assert doctest.testmod(gymnasium_env).attempted >= 3
    assert doctest.testmod(gymnasium_env).failed == 0


def test_without_gymnasium_one_line_names_it():
    code = "import sys; sys.modules['gymnasium'] = None; import ptl.world.gymnasium_env"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert "pip install gymnasium" in done.stderr.splitlines()[-1]


def test_gymnasium_random_starts_never_lie_on_the_goal(env2):
    env = GridWorldEnv(env2, "A", random_start=True)
    env.reset(seed=3)
    starts = {int(env.reset()[0]) for _ in range(3000)}
    assert env2.goals["A"] not in starts and len(starts) == env2.n_states - 1


def test_a_life_needs_a_map_and_letters_only(env2):
    few = ptl.Parameters(episodes=20)
    life = ptl.learn_life(env2, "BA", parameters=few)
    other = ptl.learn_life(env2, ptl.tasks_of(env2, "BA"), "ptl", few, 0)
    assert [record.steps.tolist() for record in life.records] == [record.steps.tolist() for record in other.records]
    assert len(ptl.learn_life(env2, "A").records[0].steps) == 200
    with pytest.raises(UserError, match="no goal 'Z' on the map"):
        ptl.learn_life(env2, "Z")


def test_a_library_is_a_sequence_of_skills(env2):
    library = ptl.learn_life(env2, "ABC").library
    assert [skill.subgoal for skill in library] == library.subgoals and len(library) > 0
    assert library[-1] is library.skills[-1]


def test_parameters_take_keys_of_their_groups():
    assert ptl.Parameters(alpha=0.1, prior_width=0.5) == ptl.Parameters(
        learning=ptl.Learning(alpha=0.1), skills=ptl.Skills(prior_width=0.5)
    )
    mixed = ptl.Parameters(learning=ptl.Learning(alpha=0.1), gamma=0.5)
    assert (mixed.learning.alpha, mixed.learning.gamma) == (0.1, 0.5)
    assert mixed.replace(epsilon=0.3).learning == ptl.Learning(alpha=0.1, gamma=0.5, epsilon=0.3)
    assert [field.__name__ for field in (ptl.Learning, ptl.Skills, ptl.Subgoals, ptl.PolicyReuse)]


@pytest.mark.parametrize(
    ("keys", "says"),
    [
        ({"alpha": 7}, "configuration key learning.alpha: 7 is not allowed; give a number > 0 and <= 1"),
        ({"alhpa": 0.1}, "configuration key alhpa: unknown; known are learning (episodes, alpha, gamma, epsilon"),
        ({"learning": None, "alpha": 0.1}, "configuration key learning: has no value; give Learning(...)"),
    ],
)
def test_parameters_name_the_group_of_a_wrong_key(keys, says):
    with pytest.raises(UserError) as caught:
        ptl.Parameters(**keys)
    assert str(caught.value).startswith(says)


def test_a_key_of_two_groups_is_refused():
    with pytest.raises(UserError, match="trajectories: is a key of subgoals and subgoal_frequencies; name one"):
        Configuration(run="a", methods=["ptl"], environments={"a": Environment(map="a.txt")}, trajectories=3)


def test_the_stub_of_the_learner_has_every_public_name_and_argument():
    stub = ast.parse((ROOT / "ptl/agent/_kernel.pyi").read_text(encoding="utf-8"))
    for kind in (ptl.Learner, ptl.Dynamics):
        [body] = [node.body for node in stub.body if isinstance(node, ast.ClassDef) and node.name == kind.__name__]
        written = {node.name: node for node in body if isinstance(node, ast.FunctionDef)}
        assert {*written} - {"__init__"} == {name for name in dir(kind) if not name.startswith("_")}
        for name, node in written.items():
            thing = getattr(kind, name)
            if callable(thing) and name != "__init__":
                given = [argument.arg for argument in (*node.args.args, *node.args.kwonlyargs)]
                assert given == [*inspect.signature(thing).parameters], name


def test_plots_show_map_values_and_curve(env2):
    [record] = ptl.learn_life(env2, "A", parameters=ptl.Parameters(episodes=30)).records
    axes = Figure().subplots(3)
    ptl.plot_map(axes[0], env2, [3, 5])
    assert {text.get_text() for text in axes[0].texts} == set("IABCDEF")
    ptl.plot_values(axes[1], env2, record.q)
    [arrows] = [part for part in axes[1].collections if isinstance(part, Quiver)]
    assert arrows.N == np.count_nonzero(ptl.greedy_policy(record.q) >= 0) > 5
    ptl.plot_values(axes[1], env2, np.zeros_like(record.q))  # nothing learned, nothing to colour
    ptl.plot_curve(axes[2], record)
    [line] = axes[2].lines
    assert line.get_ydata().tolist() == record.steps.tolist() and line.get_label() == "task A"


def test_results_are_shown_in_a_line(env2):
    """Without their arrays, which fill pages."""
    few = ptl.Parameters().replace(learning__episodes=30)
    life = ptl.learn_life(env2, ptl.tasks_of(env2, "AB"), "ptl", few, root_seed=1)
    assert repr(life.library) == f"<SkillLibrary: {len(life.library)} skills, subgoals {life.library.subgoals}>"
    assert repr(life) == f"<Life: tasks A, B; library {life.library!r}>"
    record = life.records[0]
    for thing in (*life.library.skills, record, record.discovery, record.discovery.original):
        assert "array(" not in repr(thing) and len(repr(thing)) < 200
