"""Methods that take their own steps, with their own updates, from anywhere."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from projects import ROOT

from ptl import methods
from ptl.agent._kernel import Dynamics, Learner
from ptl.agent.reference import RandomBits, ReferenceLearner
from ptl.config import Parameters
from ptl.errors import UserError
from ptl.learning import trial
from ptl.learning.life import learn_life, tasks_of
from ptl.learning.trial import check_method
from ptl.methods import BaseMethod
from ptl.world.gridworld import GridWorld

EXAMPLES = sorted((ROOT / "examples/methods").glob("*.py"))
CORRIDOR = GridWorld.from_text("I.A\n")
NORTH, EAST = 0, 3
ROOMS = GridWorld.from_text("#########\n#I..#...#\n#.......#\n#...#..A#\n#..B#...#\n#########\n", "rooms")


def learner_on(world: GridWorld, **options) -> Learner:
    learner = Learner(Dynamics(world.successors), world.goal("A"), np.random.SFC64(1), **options)
    learner.begin_episode(world.start)
    return learner


# -- single steps --------------------------------------------------------------------------------------------


def test_a_step_moves_learns_and_is_seen():
    learner = learner_on(CORRIDOR, alpha=0.5)
    assert [learner.act(action) for action in (NORTH, EAST, EAST)] == [0, 1, 2]
    assert (learner.state, learner.steps, learner.at_goal) == (2, 3, True)
    assert learner.q.tolist() == [[0, 0, 0, 0], [0, 0, 0, 0.5], [0, 0, 0, 0]]
    assert learner.seen.tolist() == [1 << NORTH | 1 << EAST, 1 << EAST, 0]
    assert learner.erased_path().tolist() == [0, 1, 2]


def test_a_step_without_learning_leaves_q():
    learner = learner_on(CORRIDOR, alpha=0.5)
    learner.act(EAST, learn=False)
    learner.act(EAST, learn=False)
    assert learner.at_goal and not learner.q.any()
    assert learner.seen.tolist() == [1 << EAST, 1 << EAST, 0]


def test_no_step_after_the_end_of_an_episode():
    learner = learner_on(CORRIDOR, max_steps=2)
    learner.act(NORTH)
    learner.act(NORTH)
    with pytest.raises(ValueError, match="limit of 2 steps"):
        learner.act(EAST)
    learner.begin_episode(CORRIDOR.goal("A"))
    with pytest.raises(ValueError, match="ended at the goal"):
        learner.act(EAST)
    assert learner.steps == 0


@pytest.mark.parametrize("wrong", [259, 4, -1, 1.5, 1.0, "1", None, 2**70, float("nan")], ids=repr)
def test_what_is_no_action_is_refused_everywhere(wrong):
    learner = learner_on(CORRIDOR)
    calls = (
        lambda: learner.act(wrong),
        lambda: learner.set_value(0, wrong, 0.5),
        lambda: learner.update(0, wrong, 0.5),
        lambda: learner.value(0, wrong),
        lambda: learner.follow([wrong, 3, 3] if wrong != -1 else [-2, 3, 3], 2),
    )
    for call in calls:
        with pytest.raises(ValueError, match=r"from 0 to 3|from -1 to 3"):
            call()
    assert learner.steps == 0 and not learner.q.any()


@pytest.mark.parametrize("wrong", [3, -1, 1.5, 2**40, None], ids=repr)
def test_what_is_no_state_is_refused_everywhere(wrong):
    learner = learner_on(CORRIDOR)
    for call in (
        lambda: learner.begin_episode(wrong),
        lambda: learner.set_value(wrong, 0, 0.5),
        lambda: learner.update(wrong, 0, 0.5),
        lambda: learner.value(wrong, 0),
        lambda: learner.values_of(wrong),
        lambda: learner.follow([3, 3, 3], -1 if wrong is None else wrong),  # None is no subgoal
        lambda: learner.reuse([3, 3, 3], subgoal=-1 if wrong is None else wrong),
        lambda: Learner(learner.dynamics, wrong, np.random.SFC64(1)),
    ):
        with pytest.raises(ValueError, match="must be a whole number from 0 to 2"):
            call()


@pytest.mark.parametrize("wrong", [float("nan"), float("inf"), -float("inf"), 1e301])
def test_values_that_are_not_finite_are_refused_everywhere(wrong):
    learner = learner_on(CORRIDOR)
    table = np.zeros((3, 4))
    table[2, 1] = wrong
    for call in (
        lambda: learner.set_value(0, 0, wrong),
        lambda: learner.update(0, 0, wrong),
        lambda: learner.set_q(table),
        lambda: learner.explore(bonus=table),
        lambda: learner.choose(bonus=table[2]),
        lambda: learner_on(CORRIDOR, initial_q=table),
    ):
        with pytest.raises(ValueError, match="must be finite"):
            call()
    assert learner.steps == 0 and not learner.q.any()


def test_the_largest_values_never_overflow():
    learner = learner_on(CORRIDOR, alpha=1.0, gamma=1.0, initial_q=np.full((3, 4), -1e300))
    learner.update(0, 0, 1e300)
    learner.explore(budget=50, bonus=np.full((3, 4), -1e300))
    assert np.isfinite(learner.q).all()


@pytest.mark.parametrize("budget", [-1, 1.5, "7"])
def test_budgets_are_whole_numbers(budget):
    learner = learner_on(CORRIDOR)
    for call in (lambda: learner.explore(budget), lambda: learner.follow([3, 3, 3], 2, budget)):
        with pytest.raises(ValueError, match="budget must be a whole number"):
            call()


def test_bonus_and_mask_must_fit():
    learner = learner_on(CORRIDOR)
    nowhere = np.ones((3, 4), dtype=bool)
    nowhere[1] = False
    for options in ({"bonus": np.zeros((4, 3))}, {"mask": np.ones((3, 4))}, {"mask": nowhere}):
        with pytest.raises(ValueError):
            learner.explore(**options)
    for options in ({"bonus": np.zeros(3)}, {"mask": np.zeros(4, dtype=bool)}, {"mask": [1, 1, 1, 1]}):
        with pytest.raises(ValueError):
            learner.choose(**options)


def test_transitions_are_copied_and_no_learner_is_set_up_twice():
    successors = CORRIDOR.successors.astype(np.uint32)
    dynamics = Dynamics(successors)
    successors[:] = 10**6
    learner = Learner(dynamics, 2, np.random.SFC64(1))
    learner.begin_episode(0)
    learner.explore()
    assert learner.at_goal
    for wrong in (np.array([[2**32] * 4]), np.zeros((1, 4)), [[0.5] * 4]):
        with pytest.raises(ValueError, match="not a state"):
            Dynamics(wrong)
    with pytest.raises(TypeError):
        Learner.__new__(Learner)


# -- Q -------------------------------------------------------------------------------------------------------


def test_reads_of_q_agree_and_cannot_be_written():
    learner = learner_on(CORRIDOR, initial_q=np.arange(12.0).reshape(3, 4))
    assert learner.value(1, 2) == 6.0
    assert learner.values_of(1) == (4.0, 5.0, 6.0, 7.0)
    with pytest.raises(ValueError, match="read-only"):
        learner.q[0, 0] = 1.0
    before = learner.q
    learner.set_value(0, 0, -2.0)
    assert before[0, 0] == 0.0 and learner.q[0, 0] == -2.0


def test_an_update_moves_a_value_towards_its_target():
    learner = learner_on(CORRIDOR, alpha=0.25)
    learner.update(1, NORTH, 2.0)
    learner.update(1, NORTH, -1.0)
    assert learner.value(1, NORTH) == 0.5 + 0.25 * (-1.0 - 0.5)


def test_set_values_guide_the_next_greedy_steps_and_updates():
    learner = learner_on(CORRIDOR, alpha=1.0, gamma=0.5)
    learner.set_value(0, EAST, 0.1)
    learner.set_value(1, EAST, -0.8)  # the other three tie at 0
    learner.act(EAST)
    assert learner.value(0, EAST) == 0.0
    q = np.full((3, 4), -1.0)
    q[:2, EAST] = -0.5
    learner.set_q(q)
    learner.begin_episode(0)
    learner.explore(epsilon=0.0)
    assert learner.steps == 2
    assert learner.value(0, EAST) == 0.5 * -0.5 and learner.value(1, EAST) == 1.0
    q[:] = 7.0
    assert learner.value(0, NORTH) == -1.0


# -- guidance and exploration --------------------------------------------------------------------------------


def test_a_policy_into_a_wall_ends_with_its_budget():
    learner = learner_on(CORRIDOR)
    wall = np.zeros(3, dtype=np.int8)
    learner.follow(wall, 2, budget=5)
    assert (learner.state, learner.steps) == (0, 5)
    learner.follow(wall, 2, budget=0)
    assert learner.steps == 5
    learner.follow(np.full(3, EAST), 2, 10)
    assert (learner.steps, learner.at_goal) == (7, True)


def test_a_mask_keeps_the_agent_to_the_allowed_actions():
    mask = np.zeros((3, 4), dtype=bool)
    mask[:, EAST] = True
    learner = learner_on(CORRIDOR)
    learner.explore(epsilon=1.0, mask=mask)
    assert learner.steps == 2
    assert {learner.choose(epsilon=1.0, mask=[True, False, True, False]) for _ in range(100)} == {0, 2}


def test_a_bonus_leads_but_is_not_learned():
    bonus = np.zeros((3, 4))
    bonus[:, EAST] = 100.0
    learner = learner_on(CORRIDOR, alpha=0.5)
    learner.explore(epsilon=0.0, bonus=bonus)
    assert learner.steps == 2
    assert learner.q.max() == 0.5


@pytest.mark.parametrize("how", ["python", "choose", "mask"])
def test_epsilon_greedy_act_by_act_agrees_with_the_reference(env3, how):
    goal, rounds, epsilon = env3.goal("A"), 4, 0.1
    reference = ReferenceLearner(env3.successors, goal, RandomBits(np.random.SFC64(5)), epsilon=epsilon, shortcut=False)
    learner = Learner(Dynamics(env3.successors), goal, np.random.SFC64(5), epsilon=epsilon)
    halves = (half for word in iter(np.random.SFC64(5).random_raw, None) for half in (word & 2**32 - 1, word >> 32))

    def own_choice() -> int:
        slot, fraction = divmod(next(halves) * 12, 2**32)
        if fraction < int(epsilon * 2**32):
            return slot & 3
        values = learner.values_of(learner.state)
        greedy = [action for action in range(4) if values[action] == max(values)]
        return greedy[slot * len(greedy) // 12]

    for _ in range(rounds):
        reference.begin_episode(env3.start)
        reference.explore()
        learner.begin_episode(env3.start)
        if how == "mask":
            learner.explore(mask=np.ones((env3.n_states, 4), dtype=bool))
        while not learner.at_goal:
            learner.act(own_choice() if how == "python" else learner.choose())
        assert learner.steps == reference.steps
        assert learner.erased_path().tolist() == reference.erased_path().tolist()
    assert learner.q.tobytes() == reference.q.tobytes()
    assert learner.seen.tolist() == reference.seen.tolist()


# -- the examples --------------------------------------------------------------------------------------------


def test_there_are_five_short_examples():
    assert [path.stem for path in EXAMPLES] == ["count_bonus", "dyna_q", "optimistic", "sarsa", "sarsa_lambda"]
    assert max(len(path.read_text().splitlines()) for path in EXAMPLES) < 40


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_each_example_learns_the_rooms(path):
    check_method(str(path))
    parameters = Parameters().replace(learning__episodes=400, learning__alpha=0.3)
    life = learn_life(ROOMS, tasks_of(ROOMS, "AB"), str(path), parameters, 3)
    for record in life.records:
        shortest = ROOMS.shortest_path_length(ROOMS.start, record.task.goal)
        assert record.steps[0] > 1.5 * shortest
        assert shortest <= record.steps[-100:].mean() < 1.3 * shortest + 1


def test_the_tutorial_runs_an_example(monkeypatch, capsys):
    root = ROOT
    monkeypatch.chdir(root)
    page = (root / "docs/tutorial-your-own-method.md").read_text(encoding="utf-8")
    code = page.partition("## 5. Take your own steps")[2].partition("```python\n")[2].partition("```")[0]
    exec(code, {})
    assert capsys.readouterr().out.count("np.float64") == 2


class Scripted:
    """A learner whose actions are given, on a kernel."""

    def __init__(self, learner: Learner, actions: list[int]) -> None:
        self.learner = learner
        self.actions = iter(actions)

    def __getattr__(self, name):
        return getattr(self.learner, name)

    def choose(self) -> int:
        return next(self.actions)


def test_sarsa_by_hand():
    """Two episodes in a corridor of three states: east, east; then north, east, east."""
    parameters = Parameters().replace(learning__alpha=0.5, learning__gamma=0.8)
    method = methods.load(str(EXAMPLES[3]))(CORRIDOR, parameters, np.random.default_rng(0))
    learner = learner_on(CORRIDOR, alpha=0.5, gamma=0.8)
    method.run_episode(Scripted(learner, [EAST, EAST, NORTH]))
    assert learner.q[1, EAST] == 0.5 and learner.q.sum() == 0.5
    learner.begin_episode(0)
    method.run_episode(Scripted(learner, [EAST, NORTH, EAST, NORTH]))
    # Q(0, east) takes its target from Q(1, north) = 0; Q(1, north) from Q(1, east) = 0.5
    expected = np.zeros((3, 4))
    expected[1, NORTH], expected[1, EAST] = 0.5 * 0.8 * 0.5, 0.75
    assert learner.q.tolist() == expected.tolist()


def test_traces_by_hand():
    """The first arrival at the goal informs every step on the way, by (gamma lambda)^k."""
    parameters = Parameters().replace(learning__alpha=0.5, learning__gamma=0.8)
    method = methods.load(str(EXAMPLES[4]))(CORRIDOR, parameters, np.random.default_rng(0))
    learner = learner_on(CORRIDOR)
    method.run_episode(Scripted(learner, [EAST, EAST, NORTH]))
    assert learner.value(1, EAST) == 0.5
    assert learner.value(0, EAST) == pytest.approx(0.5 * 0.8 * 0.9)


# -- where methods come from ---------------------------------------------------------------------------------

GOOD = """
from ptl.methods import BaseMethod

class Method(BaseMethod):
    label = "Mine"
    colour = "#123456"

    def run_episode(self, learner):
        learner.explore()
        return []
"""


class Imported(BaseMethod):
    """Keeps what was seen at the end of each task."""

    label, colour, name = "Imported", "#abcdef", "imported"

    def __init__(self, world, parameters, random):
        super().__init__(world, parameters, random)
        self.seen_states = []

    def run_episode(self, learner):
        learner.explore()
        return []

    def end_task(self, learner):
        self.seen_states.append(np.flatnonzero(learner.seen))


def test_files_import_paths_classes_and_functions_are_methods(tmp_path):
    file = tmp_path / "mine.py"
    file.write_text(GOOD)
    made = []

    def make(world, parameters, random):
        made.append(Imported(world, parameters, random))
        return made[-1]

    make.label, make.colour, make.name = "Made", "#000000", "made"
    references = {str(file): "mine", f"{__name__}:Imported": "imported", "ptl": "ptl"}
    assert methods.by_identifier(references) == {name: reference for reference, name in references.items()}
    assert methods.source_file(str(file)) == file
    assert methods.source_file(f"{__name__}:Imported") == Path(__file__)
    assert methods.identifier(methods.load("ptl")) == "ptl"
    assert methods.identifier(methods.load(str(file))) == "mine"
    parameters = Parameters().replace(learning__episodes=5)
    for method in (*references, Imported, make, methods.load("ptl")):
        check_method(method)
        assert len(learn_life(ROOMS, tasks_of(ROOMS, "AB"), method, parameters, 1).records) == 2
    assert [len(states) > 2 for states in made[-1].seen_states] == [True, True]


def test_a_reference_and_its_class_give_the_same_life():
    parameters = Parameters().replace(learning__episodes=20)
    lives = [learn_life(ROOMS, tasks_of(ROOMS, "AB"), method, parameters, 1) for method in ("ptl", methods.load("ptl"))]
    assert lives[0].records[1].q.tobytes() == lives[1].records[1].q.tobytes()


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("class Method(:\n", "SyntaxError: invalid syntax .*own.py, line 1"),
        ("import nothing_of_this_name\n", "cannot be imported .*nothing_of_this_name"),
        ("1 / 0\n", "ZeroDivisionError: division by zero .*own.py, line 1"),
        (GOOD.replace("Method(", "Agent("), "defines no class Method derived from ptl.methods.BaseMethod"),
        (GOOD.replace("(BaseMethod)", ""), "defines no class Method derived from"),
        (GOOD.replace('label = "Mine"', ""), "has no label; give text without braces, <"),
        (GOOD.replace('"Mine"', '"a{b}"'), "label = 'a{b}' is not allowed"),
        (GOOD.replace('colour = "#123456"', ""), "has no colour; give #rrggbb"),
        (GOOD.replace("#123456", "red"), "colour = 'red' is not allowed; give #rrggbb"),
        (GOOD.replace("#123456", r"#123456\n"), "colour = .* is not allowed; give #rrggbb"),
        (
            GOOD.replace("run_episode", "run_episodes"),
            "defines neither run_episode nor plan, .*run_episodes is probably meant to be run_episode",
        ),
        (
            GOOD + "\n    def __init__(self, world, parameters, random):\n        self.world = world\n",
            r"have no attribute parameters; let its __init__ call super\(\).__init__\(world, parameters, random\)",
        ),
        (GOOD.replace("return []", "return 0"), "run_episode must return the list of the skills drawn, .* not 0"),
        (GOOD.replace("return []", "return ['a']"), r"run_episode must return the list .* not \['a'\]"),
        (GOOD.replace("explore()", "explore(1)"), "returned in episode 1 of task A before the goal"),
        (GOOD.replace("explore()", "walk()"), "AttributeError: .*'walk' .*own.py, line 9"),
        (GOOD.replace("explore()", "act(7)"), "ValueError: action must be a whole number from 0 to 3.*own.py, line 9"),
        (
            "from itertools import count\nCALLS = count(1)\n"
            + GOOD.replace("explore()", "explore(epsilon=1 / next(CALLS))"),
            "two lives with equal seeds differ",
        ),
    ],
)
def test_a_faulty_method_is_refused_in_one_line(tmp_path, text, says):
    file = tmp_path / "own.py"
    file.write_text(text)
    with pytest.raises(UserError, match=f"method .*{says}") as refusal:
        check_method(str(file))
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    ("reference", "says"),
    [
        ("q_lambda", "unknown method 'q_lambda'; known are full_transfer"),
        ("nowhere/own.py", "method nowhere/own.py: no such file"),
        ("nowhere.agents:Own", "method nowhere.agents:Own: cannot be imported"),
        ("ptl.errors:UserError", "defines no class UserError derived from"),
        ("ptl.errors:Nothing", "defines no class Nothing derived from"),
        (":Own", "method :Own: "),
        (f"{__name__}:Unnamed", "has no identifier; give lower-case letters"),
        ("Own-Agent.py", "the identifier 'Own-Agent' is not allowed; give lower-case letters"),
        ("elsewhere/ptl.py", "ptl is a built-in method; give the file or the class another name"),
    ],
)
def test_a_wrong_reference_is_refused_in_one_line(reference, says):
    with pytest.raises(UserError, match=says):
        check_method(reference)


class Unnamed(BaseMethod):
    """A class used under its own name must have an identifier."""

    label, colour = "Unnamed", "#abcdef"


def test_two_methods_cannot_share_an_identifier():
    with pytest.raises(UserError, match=r"methods a/own\.py and b/own\.py are both called own"):
        methods.by_identifier(["a/own.py", "b/own.py"])


@pytest.mark.parametrize(
    "text",
    [
        "raise SystemExit(0)",
        "import sys\nsys.exit(3)",
        "class Odd(Exception):\n    def __str__(self):\n        return 5\nraise Odd",
    ],
)
def test_a_file_that_ends_python_or_fails_without_a_text_is_refused(tmp_path, text):
    (tmp_path / "mine.py").write_text(text)
    with pytest.raises(UserError, match=r"mine\.py: (SystemExit|Odd): .*mine\.py, line"):
        check_method(str(tmp_path / "mine.py"))


@pytest.mark.parametrize("body", ["while True: pass", "raise SystemExit(0)"])
def test_an_episode_that_never_ends_or_ends_python_is_refused(tmp_path, monkeypatch, capsys, body):
    (tmp_path / "mine.py").write_text(GOOD.replace("learner.explore()", body))
    monkeypatch.setattr(trial, "SILENT_SECONDS", 0.1)
    monkeypatch.setattr(trial, "TRIAL_SECONDS", 0.2)
    with pytest.raises(UserError, match=r"mine\.py: (SystemExit|a life of two tasks .* has not ended)"):
        check_method(str(tmp_path / "mine.py"))
    assert ("trying method" in capsys.readouterr().err) == body.startswith("while")


def test_methods_of_one_colour_are_noted(tmp_path):
    (tmp_path / "mine.py").write_text(GOOD.replace("#123456", methods.load("ptl").colour))
    [note] = trial.colour_notes(["no_transfer", "ptl", str(tmp_path / "mine.py")])
    assert note.startswith("Mine and PTL have the same colour, #")
    assert trial.colour_notes(methods.names()) == []


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (GOOD.replace("explore()", "explore(); learner.begin_episode(0); learner.explore()"), "began another episode"),
        (GOOD.replace("return []", "return [0] * (learner.steps + 2)"), "at most one more than steps"),
        (GOOD.replace("return []", "return [2**40]"), "numbers from 0 to 2147483647"),
        (GOOD.replace("learner.explore()", "self.world.successors[0, :] = 1; learner.explore()"), "read-only"),
    ],
)
def test_a_method_cannot_hide_steps_or_change_the_map(tmp_path, text, says):
    (tmp_path / "own.py").write_text(text)
    with pytest.raises(UserError, match=says):
        check_method(str(tmp_path / "own.py"))


def test_the_step_limit_is_that_of_the_run():
    class SingleStep(Imported):
        def __init__(self, world, parameters, random):
            super().__init__(world, parameters.replace(learning__max_steps=1), random)

    life = learn_life(ROOMS, tasks_of(ROOMS, "AB"), SingleStep, Parameters().replace(learning__episodes=5), 1)
    assert not any(record.truncated.any() for record in life.records)
