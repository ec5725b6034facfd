"""The explorer's data set against the learning files and the learning itself, and the joined page."""

from __future__ import annotations

import base64
import gzip
import hashlib
import json
import re
from itertools import groupby
from pathlib import Path

import msgspec
import numpy as np
import pytest
from explorer_runs import METHODS, PARAMETERS, SEEDS, TITLES, WORLDS, chain_job, opened, write_runs
from lives import read_lives

from ptl import methods
from ptl.agent.policies import greedy_policy
from ptl.errors import UserError
from ptl.files import store
from ptl.files.store import Result
from ptl.methods._base import BaseMethod
from ptl.methods.policy_reuse import Method as PolicyReuse
from ptl.methods.ptl import Method as PartialTransfer
from ptl.report.explorer import page, replay
from ptl.report.explorer.data import collect


@pytest.fixture(scope="module")
def paths(tmp_path_factory):
    return write_runs(tmp_path_factory.mktemp("learning"))


@pytest.fixture(scope="module")
def data(paths):
    return collect(read_lives(*paths), window=10, titles=TITLES)


def actions_of(letters):
    """Actions of a text, -1 where undefined."""
    return ["NSWE".find(letter) for letter in letters]


def run_of(data, environment, method, seed):
    [entry] = [entry for entry in data["environments"] if entry["name"] == environment]
    return entry["runs"][f"{method}/{seed}"]


def tasks_of(job, arrays, **options):
    """Tasks of the data set of one life on the chain of rooms that is in memory."""
    result = Result(Path("life.h5"), job, arrays, {"chain": WORLDS["chain"].text}, {})
    data = collect([result], window=10, **options)
    return run_of(data, "chain", job.method, job.seed)["tasks"]


# -- data against files -------------------------------------------------------------------------------------


def test_order_titles_and_methods(data):
    assert [entry["name"] for entry in data["environments"]] == ["chain", "flat"]
    for entry in data["environments"]:
        assert entry["title"] == TITLES[entry["name"]]
        assert (entry["methods"], entry["seeds"]) == (list(METHODS), list(SEEDS))
    for name, look in data["methods"].items():
        assert (look["label"], look["colour"]) == (methods.load(name).label, methods.load(name).colour)
    assert {name: look["guides"] for name, look in data["methods"].items()} == {
        "no_transfer": "none",
        "full_transfer": "none",
        "policy_reuse": "policies",
        "ptl": "skills",
        "ptl_supervised": "skills",
    }


def test_the_order_given_is_the_order_of_the_page(paths):
    """Files that are named in another order reorder the page; tasks stay in the order in which they were learned."""
    turned = collect(read_lives(*paths[::-1]), window=7)
    assert turned["window"] == 7
    assert [entry["name"] for entry in turned["environments"]] == ["flat", "chain"]
    for entry in turned["environments"]:
        assert (entry["methods"], entry["seeds"]) == (list(METHODS[::-1]), list(SEEDS))
        assert entry["tasks"] == {"chain": ["C", "A", "B"], "flat": ["A", "B"]}[entry["name"]]


def test_every_array_is_that_of_the_file(data, paths):
    skills = 0
    for path in paths:
        file = opened(path)
        run = run_of(data, file.job.environment, file.job.method, file.job.seed)
        for index, (stored, task) in enumerate(zip(run["tasks"], file.tasks.values(), strict=True)):
            assert stored["steps"] == task.steps.tolist()
            assert actions_of(stored["policy"]) == greedy_policy(task.q).tolist()
            value = [0 if exponent is None else 10**exponent for exponent in stored["log10_value"]]
            np.testing.assert_allclose(value, task.q.max(axis=1), rtol=1.2e-4)
            np.testing.assert_allclose(stored["metric"], task.incremental, atol=5.1e-5)
            assert stored["drawn"] == [task.selected_in(episode) for episode in range(len(task.steps))]
            assert stored["truncated"] == np.flatnonzero(task.truncated).tolist()
            assert stored["first"]["informed"] == (file.job.method == "full_transfer" and index > 0)
            for key in ("name", "start", "goal", "subgoal", "reason"):
                assert stored[key] == getattr(task, key)
        for stored, skill in zip(run["skills"], file.library or [], strict=True):
            assert (stored["subgoal"], stored["after"]) == (skill.subgoal, skill.learned_after)
            assert actions_of(stored["policy"]) == skill.policy.tolist()
            skills += 1
    assert skills > 4  # the small runs do find subgoals


# -- first episodes -----------------------------------------------------------------------------------------


def walk(world, start, letters):
    """States of a walk."""
    path = [start]
    for action in actions_of(letters):
        path.append(int(world.successors[path[-1], action]))
    return path


def test_first_episodes_lead_to_the_goal_in_the_stored_number_of_steps(data, paths):
    whole = guided = 0
    for path in paths:
        file = opened(path)
        for task in run_of(data, file.job.environment, file.job.method, file.job.seed)["tasks"]:
            length, first = task["steps"][0], task["first"]
            visited = walk(file.world, task["start"], first["actions"])
            assert len(first["actions"]) == min(length, replay.MAX_RECORDED_STEPS)
            assert sum(steps for _, steps in first["parts"]) == length
            if length <= replay.MAX_RECORDED_STEPS:
                assert visited.index(task["goal"]) == length
                whole += 1
            guides = [candidate for candidate, _ in first["parts"] if candidate]
            # a skill that was drawn leads again in its initiation set
            drawn = [candidate for candidate in task["drawn"][0] if candidate]
            assert [candidate for candidate, _ in groupby(guides)] == [candidate for candidate, _ in groupby(drawn)]
            guided += len(guides)
    assert whole > 20 and guided > 5


def test_a_skill_leads_to_its_subgoal_in_its_part_of_the_episode(data, paths):
    led = 0
    for path in paths:
        file = opened(path)
        if not file.library:
            continue
        for task in run_of(data, file.job.environment, file.job.method, file.job.seed)["tasks"]:
            visited = walk(file.world, task["start"], task["first"]["actions"])
            begin = 0
            for candidate, steps in task["first"]["parts"]:
                if candidate:
                    skill = file.library[candidate - 1]
                    part = visited[begin : begin + steps + 1]
                    taken = actions_of(task["first"]["actions"][begin : begin + steps])
                    assert taken == [skill.policy[state] for state in part[: len(taken)]]
                    assert skill.subgoal not in part[:-1]
                    end = part[-1]
                    assert end in (skill.subgoal, task["goal"]) or skill.policy[end] < 0
                    led += steps
                begin += steps
    assert led > 50


def test_long_first_episodes_are_cut(paths, monkeypatch, data):
    monkeypatch.setattr(replay, "MAX_RECORDED_STEPS", 30)
    cut = collect(read_lives(*paths[:1]), window=10)["environments"][0]["runs"]
    [(name, run)] = cut.items()
    whole = data["environments"][0]["runs"][name]
    for short, full in zip(run["tasks"], whole["tasks"], strict=True):
        assert full["steps"][0] > 30
        assert short["first"]["actions"] == full["first"]["actions"][:30]
        assert short["first"]["parts"] == full["first"]["parts"]


# -- probabilities ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "kind", "now"),
    [
        ("ptl", PartialTransfer, lambda method: method.selection.probabilities()),
        ("ptl_unknown_goal", PartialTransfer, lambda method: method.selection.probabilities()),
        ("policy_reuse", PolicyReuse, lambda method: method.arm_probabilities()),
    ],
)
def test_replayed_probabilities_are_those_of_the_run(name, kind, now, monkeypatch):
    """The probabilities are noted while the method learns, then compared with those of the data set."""
    noted = []
    run_episode = kind.run_episode

    def note_and_run(method, learner):
        noted.append(now(method))
        return run_episode(method, learner)

    job = chain_job(name, 1)
    with monkeypatch.context() as patch:
        patch.setattr(kind, "run_episode", note_and_run)
        arrays = job.run(WORLDS)
    tasks = tasks_of(job, arrays)
    episodes = PARAMETERS.learning.episodes
    widths = set()
    for index, task in enumerate(tasks):
        expected = np.array(noted[index * episodes : (index + 1) * episodes])
        np.testing.assert_allclose(np.transpose(task["chances"]), expected, atol=5.1e-5)
        widths.add(expected.shape[1])
    assert max(widths) > 1


def test_the_supervisor_names_what_was_drawn(data):
    for task in run_of(data, "chain", "ptl_supervised", 3)["tasks"]:
        chances = np.transpose(task["chances"])
        [named] = set(chances.argmax(axis=1).tolist())
        assert (chances == np.eye(chances.shape[1])[named]).all()
        assert task["drawn"][0][0] == named


class OwnRule(PartialTransfer):
    """A method whose rule of drawing the explorer cannot know."""

    name = "own"
    label, colour = "Own rule", "#123456"

    def draw_skill(self) -> int:
        return int(self.random.integers(len(self.candidates)))


class OwnGuide(BaseMethod):
    """A method that follows its own policy."""

    name = "own"
    label, colour = "Own guide", "#654321"

    def run_episode(self, learner) -> list[int]:
        north = np.zeros(self.world.n_states, dtype=np.int8)
        learner.follow(north, int(self.random.integers(self.world.n_states)))
        learner.explore()
        return []


class OwnSteps(BaseMethod):
    """Chooses each step itself."""

    name = "own"
    label, colour = "Own steps", "#abcdef"

    def run_episode(self, learner) -> list[int]:
        while not (learner.at_goal or learner.truncated):
            learner.act(learner.choose())
        return []


def learned_by(kind, monkeypatch):
    """A job of a user's method, and its arrays."""
    parameters = PARAMETERS.replace(learning__max_steps=2000)
    job = msgspec.structs.replace(chain_job("ptl", parameters=parameters), method="own", reference="own.py")
    with monkeypatch.context() as patch:
        patch.setattr(methods, "load", lambda reference: kind)
        return job, job.run(WORLDS)


def test_a_method_with_its_own_rule_shows_no_probabilities(monkeypatch):
    tasks = tasks_of(*learned_by(OwnRule, monkeypatch), kinds={"own": OwnRule})
    assert [task["chances"] for task in tasks] == [None] * 3
    assert [task["steps"][0] for task in tasks] == [len(task["first"]["actions"]) for task in tasks]


def test_single_steps_of_the_first_episode_make_one_part(monkeypatch):
    for task in tasks_of(*learned_by(OwnSteps, monkeypatch), kinds={"own": OwnSteps}):
        assert task["first"]["parts"] == [[0, task["steps"][0]]]
        assert len(task["first"]["actions"]) == task["steps"][0]


def test_a_method_with_its_own_guide_shows_its_first_episode(monkeypatch):
    for task in tasks_of(*learned_by(OwnGuide, monkeypatch), kinds={"own": OwnGuide}):
        (guide, steps), (none, rest) = task["first"]["parts"]
        assert (guide, none) == (replay.OWN_GUIDE, 0)
        assert task["first"]["actions"][:steps] == "N" * steps
        assert steps + rest == task["steps"][0] == len(task["first"]["actions"])


def test_looks_are_those_of_the_class(monkeypatch, tmp_path):
    job, arrays = learned_by(OwnRule, monkeypatch)
    store.write(tmp_path / "own.h5", job, arrays, {"chain": WORLDS["chain"]})
    data = collect(read_lives(tmp_path / "own.h5"), window=10, kinds={"own": OwnRule})
    assert data["methods"] == {"own": {"label": "Own rule", "colour": "#123456", "guides": "skills"}}


def test_a_method_that_has_changed_since_is_refused_by_its_name(monkeypatch):
    learned = learned_by(OwnGuide, monkeypatch)
    monkeypatch.setattr(OwnGuide, "run_episode", lambda method, learner: [])
    with pytest.raises(UserError, match="method 'Own guide': run_episode returned in episode 1"):
        tasks_of(*learned, kinds={"own": OwnGuide})


# -- bad input ----------------------------------------------------------------------------------------------


def altered_steps(arrays):
    arrays["tasks/A/steps"][4] += 1


def altered_draws(arrays):
    arrays["tasks/A/selected"][4] += 1


def altered_values(arrays):
    arrays["tasks/A/q"][0, 0] += 1e-12


@pytest.mark.parametrize(
    ("alter", "name"), [(altered_steps, "steps"), (altered_draws, "draws"), (altered_values, "values")]
)
def test_a_life_that_cannot_be_learned_again_is_refused(alter, name):
    job = chain_job("ptl", 0)
    arrays = job.run(WORLDS)
    alter(arrays)
    with pytest.raises(UserError, match=rf"life\.h5: task A learned again gives other {name} than the file has"):
        tasks_of(job, arrays)


def test_no_file():
    with pytest.raises(UserError, match="no learning file"):
        collect([], window=10)


# -- the page -----------------------------------------------------------------------------------------------


def test_equal_data_give_equal_bytes(paths, data):
    assert page.build(collect(read_lives(*paths), window=10, titles=TITLES)) == page.build(data)


def test_the_page_refers_to_nothing_outside(data):
    text = page.build(data)
    assert set(re.findall(r'(?:src|href)="([^"]*)"', text)) == {"data:,", "#board"}
    assert not re.search(r"@import|url\(|fetch\(|XMLHttpRequest|WebSocket|sendBeacon|\bimport\(", text)
    outside = set(re.findall(r"https?://[^\"'\s]*", text))
    assert outside == {"http://www.w3.org/2000/svg"}  # a name, not an address that is loaded


def test_the_policy_allows_exactly_the_style_and_script_inside(data):
    text = page.build(data)
    allowed = re.search(r'Content-Security-Policy" content="([^"]*)"', text).group(1)
    assert allowed.startswith("default-src 'none'")
    for pattern in (r"<style>(.*?)</style>", r"<script>(.*?)</script>"):
        [source] = re.findall(pattern, text, re.DOTALL)
        digest = base64.b64encode(hashlib.sha256(source.encode()).digest()).decode()
        assert f"'sha256-{digest}'" in allowed


def test_the_page_holds_the_data(data):
    [packed] = re.findall(r'<script type="text/plain" id="data">([A-Za-z0-9+/=]*)</script>', page.build(data))
    assert json.loads(gzip.decompress(base64.b64decode(packed))) == data


def test_every_script_is_joined_once():
    assert sorted((*page.PURE_MODULES, *page.VIEW_MODULES)) == sorted(path.name for path in page.WEB.glob("*.js"))
    assert not re.search(r"^(import|export)\b", page.bundle(), re.MULTILINE)


def test_scripts_import_only_what_is_joined_before_them():
    order = [*page.PURE_MODULES, *page.VIEW_MODULES]
    for place, name in enumerate(order):
        source = (page.WEB / name).read_text(encoding="utf-8")
        for imported in re.findall(r'from "\./([a-z_]+\.js)"', source):
            assert order.index(imported) < place or imported in page.VIEW_MODULES, (name, imported)


@pytest.mark.parametrize(
    ("first", "second", "message"),
    [
        ("const twice = 1;\n", "export async function twice() {}\n", "more than one module: twice"),
        ("export default 3;\n", "", "a.js: cannot join this line"),
    ],
)
def test_scripts_that_cannot_be_joined(first, second, message, tmp_path, monkeypatch):
    (tmp_path / "a.js").write_text(first)
    (tmp_path / "b.js").write_text(second)
    monkeypatch.setattr(page, "WEB", tmp_path)
    with pytest.raises(ValueError, match=message):
        page.bundle(["a.js", "b.js"])
