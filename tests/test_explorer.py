"""The explorer's data set against the learning files, the replayed probabilities, and the joined page."""

from __future__ import annotations

import base64
import hashlib
import json
import re
import struct

import numpy as np
import pytest
from click.testing import CliRunner
from explorer_runs import METHODS, PARAMETERS, SEEDS, TITLES, learn, origin, write_runs
from hypothesis import given
from hypothesis import strategies as st

from ptl import methods
from ptl.commands.explorer import command
from ptl.errors import UserError
from ptl.explorer import encoding, page
from ptl.explorer.data import collect
from ptl.methods.policy_reuse import Method as PolicyReuse
from ptl.methods.ptl import Method as PartialTransfer
from ptl.policies import greedy_policy
from ptl.store import open_learning, write_learning


@pytest.fixture(scope="module")
def paths(tmp_path_factory):
    return write_runs(tmp_path_factory.mktemp("learning"))


@pytest.fixture(scope="module")
def data(paths):
    return collect(paths, titles=TITLES)


def unpack(text, kind):
    """Present values of a sparse array, put in their places among zeros."""
    runs, values = text.split(".")
    runs = unpack_varints(runs)
    full = np.zeros(sum(runs))
    present = np.repeat(np.arange(len(runs)) % 2 == 1, runs)
    full[present] = np.frombuffer(base64.b64decode(values), dtype=kind)
    if kind == "<f4":
        full[present] = np.exp(full[present])
    else:
        full /= encoding.SHARE_STEPS
    return full


def unpack_rows(text):
    columns, *changes = unpack_varints(text)
    changes = [-(change + 1) // 2 if change % 2 else change // 2 for change in changes]
    return np.cumsum(np.reshape(changes, (-1, columns)), axis=0) / encoding.SHARE_STEPS


def unpack_actions(text, size):
    digits = [byte // 5**place % 5 for byte in base64.b64decode(text) for place in range(3)]
    return [digit - 1 for digit in digits[:size]]


def unpack_varints(text):
    numbers, number, shift = [], 0, 0
    for byte in base64.b64decode(text):
        number |= (byte & 0x7F) << shift
        shift += 7
        if byte < 0x80:
            numbers.append(number)
            number = shift = 0
    return numbers


def run_of(data, environment, method, seed):
    [entry] = [entry for entry in data["environments"] if entry["name"] == environment]
    return entry["runs"][f"{method}/{seed}"]


# -- encodings ----------------------------------------------------------------------------------------------


@given(st.lists(st.integers(0, 2**50)))
def test_varints_come_back(numbers):
    assert unpack_varints(encoding.varints(numbers)) == numbers


def test_varints_by_hand():
    assert base64.b64decode(encoding.varints([0, 127, 128, 300])) == bytes([0, 127, 0x80, 1, 0xAC, 2])


@given(st.lists(st.just(0.0) | st.floats(1e-300, 1)))
def test_logarithms_keep_tiny_values(values):
    back = unpack(encoding.logarithms(np.array(values)), "<f4")
    np.testing.assert_allclose(back, values, rtol=4e-5)


def test_sparse_values_by_hand():
    runs, values = encoding.logarithms(np.array([0, 0, 1, np.e, 0])).split(".")
    assert base64.b64decode(runs) == bytes([2, 2, 1])
    assert base64.b64decode(values) == struct.pack("<ff", 0, 1)


@given(st.lists(st.floats(0, 1)))
def test_shares_within_half_a_step(values):
    back = unpack(encoding.shares(np.array(values)), "<u2")
    np.testing.assert_allclose(back, values, atol=0.5001 / encoding.SHARE_STEPS)


@given(
    st.integers(1, 4).flatmap(
        lambda width: st.lists(st.lists(st.floats(0, 1), min_size=width, max_size=width), min_size=1)
    )
)
def test_rows_of_shares_within_half_a_step(rows):
    np.testing.assert_allclose(unpack_rows(encoding.share_rows(rows)), rows, atol=0.5001 / encoding.SHARE_STEPS)


@given(st.lists(st.integers(-1, 3)))
def test_actions_come_back(policy):
    packed = encoding.actions(np.array(policy, dtype=np.int8))
    assert unpack_actions(packed, len(policy)) == policy
    assert len(base64.b64decode(packed)) == -(-len(policy) // 3)


# -- data against files -------------------------------------------------------------------------------------


def test_order_titles_and_methods(data):
    assert [entry["name"] for entry in data["environments"]] == ["chain", "flat"]
    for entry in data["environments"]:
        assert entry["title"] == TITLES[entry["name"]]
        assert (entry["methods"], entry["seeds"]) == (list(METHODS), list(SEEDS))
    for name, look in data["methods"].items():
        assert (look["label"], look["colour"]) == (methods.load(name).label, methods.load(name).colour)
    kinds = {name: (look["guides"], look["episode"]) for name, look in data["methods"].items()}
    assert kinds == {
        "no_transfer": ("none", "explore"),
        "full_transfer": ("none", "explore"),
        "policy_reuse": ("policies", "reuse"),
        "ptl": ("skills", "skills"),
        "ptl_supervised": ("skills", "skills"),
    }


def test_every_array_is_that_of_the_file(data, paths):
    skills = 0
    for path in paths:
        with open_learning(path) as file:
            run = run_of(data, file.environment, file.method, file.seed)
            for stored, task in zip(run["tasks"], file.tasks.values(), strict=True):
                assert unpack_varints(stored["steps"]) == task.steps.tolist()
                assert unpack_actions(stored["policy"], len(task.q)) == greedy_policy(task.q).tolist()
                np.testing.assert_allclose(unpack(stored["value"], "<f4"), task.q.max(axis=1), rtol=4e-5)
                np.testing.assert_allclose(unpack(stored["metric"], "<u2"), task.incremental, atol=8e-6)
                drawn = [task.selected_in(episode) for episode in range(len(task.steps))]
                assert unpack_varints(stored["drawn"]) == [number for draw in drawn for number in (len(draw), *draw)]
                for key in ("name", "start", "goal", "subgoal", "reason"):
                    assert stored[key] == getattr(task, key)
            for stored, skill in zip(run["skills"], file.library or [], strict=True):
                assert (stored["subgoal"], stored["after"]) == (skill.subgoal, skill.learned_after)
                assert unpack_actions(stored["policy"], len(skill.policy)) == skill.policy.tolist()
                skills += 1
    assert skills > 4  # the small runs do find subgoals


def test_only_full_transfer_starts_from_earlier_values(data, paths):
    for path in paths:
        with open_learning(path) as file:
            tasks = list(file.tasks.values())
            run = run_of(data, file.environment, file.method, file.seed)
            for index, stored in enumerate(run["tasks"]):
                if file.method != "full_transfer" or index == 0:
                    assert stored["initial"] is None
                else:
                    initial = unpack(stored["initial"], "<f4").reshape(-1, 4)
                    np.testing.assert_allclose(initial, tasks[index - 1].q, rtol=4e-5)


# -- probabilities ------------------------------------------------------------------------------------------


def test_two_arms_in_an_episode_are_refused(tmp_path):
    life, world = learn("chain", "policy_reuse", 0)
    life.records[1].selected[4] = [1, 0]
    write_learning(tmp_path / "odd.h5", life, world, origin("chain", "policy_reuse", 0))
    with pytest.raises(UserError, match=r"draws \[1, 0\] of 2 candidates, which policy_reuse does not make"):
        collect([tmp_path / "odd.h5"])


@pytest.mark.parametrize(
    ("name", "kind", "now"),
    [
        ("ptl", PartialTransfer, lambda method: method.selection.probabilities()),
        ("ptl_unknown_goal", PartialTransfer, lambda method: method.selection.probabilities()),
        ("policy_reuse", PolicyReuse, lambda method: method.arm_probabilities()),
    ],
)
def test_replayed_probabilities_are_those_of_the_run(name, kind, now, tmp_path, monkeypatch):
    """The probabilities are noted down while the method learns, then compared with those of the data set."""
    noted = []
    run_episode = kind.run_episode

    def note_and_run(method, learner):
        noted.append(now(method))
        return run_episode(method, learner)

    with monkeypatch.context() as patch:
        patch.setattr(kind, "run_episode", note_and_run)
        life, world = learn("chain", name, 1)
    path = tmp_path / "run.h5"
    write_learning(path, life, world, origin("chain", name, 1))
    tasks = collect([path])["environments"][0]["runs"][f"{name}/1"]["tasks"]
    episodes = PARAMETERS.learning.episodes
    widths = set()
    for index, task in enumerate(tasks):
        expected = np.array(noted[index * episodes : (index + 1) * episodes])
        np.testing.assert_allclose(unpack_rows(task["chances"]), expected, atol=8e-6)
        widths.add(expected.shape[1])
    assert max(widths) > 1


def test_the_supervisor_names_what_was_drawn(data):
    for task in run_of(data, "chain", "ptl_supervised", 3)["tasks"]:
        chances = unpack_rows(task["chances"])
        [named] = set(chances.argmax(axis=1).tolist())
        assert (chances == np.eye(chances.shape[1])[named]).all()
        counted = unpack_varints(task["drawn"])
        assert counted[1] == named


class OwnRule(PartialTransfer):
    """A method whose rule of drawing the explorer cannot know."""

    label, colour = "Own rule", "#123456"

    def draw_skill(self) -> int:
        return int(self.random.integers(len(self.candidates)))


def test_a_method_with_its_own_rule_shows_no_probabilities(tmp_path, monkeypatch):
    load = methods.load
    monkeypatch.setattr(methods, "load", lambda name: OwnRule if name == "own" else load(name))
    life, world = learn("chain", "own", 0)
    write_learning(tmp_path / "own.h5", life, world, origin("chain", "own", 0))
    data = collect([tmp_path / "own.h5"])
    assert data["methods"]["own"] == {
        "label": "Own rule", "colour": "#123456", "guides": "skills", "episode": "unknown"
    }  # fmt: skip
    assert [task["chances"] for task in data["environments"][0]["runs"]["own/0"]["tasks"]] == [None] * 3


def test_draws_that_the_method_cannot_make_are_refused(tmp_path):
    life, world = learn("chain", "ptl", 0)
    life.records[1].selected[4] = [9]
    write_learning(tmp_path / "odd.h5", life, world, origin("chain", "ptl", 0))
    with pytest.raises(UserError, match=r"odd\.h5: task B, episode 5 holds the draws \[9\]"):
        collect([tmp_path / "odd.h5"])


# -- bad input ----------------------------------------------------------------------------------------------


def test_no_file():
    with pytest.raises(UserError, match="no learning file"):
        collect([])


def test_a_missing_seed_is_named(paths):
    with pytest.raises(UserError, match="chain/no_transfer: no file of seed 8"):
        collect([paths[0], *paths[2:4]])
    with pytest.raises(UserError, match="no file of seed 4"):
        collect(paths[:2], seeds=[3, 4])


def test_a_file_given_twice(paths):
    with pytest.raises(UserError, match="given twice"):
        collect([paths[0], paths[0]])


def test_files_of_two_runs(paths, tmp_path):
    parameters = PARAMETERS.replace(learning__alpha=0.5)
    life, world = learn("chain", "ptl", 3, parameters)
    write_learning(tmp_path / "other.h5", life, world, origin("chain", "ptl", 3, parameters))
    with pytest.raises(UserError, match=r"other\.h5: its parameters differ"):
        collect([paths[0], tmp_path / "other.h5"])


def test_a_damaged_file(paths, tmp_path):
    damaged = tmp_path / "damaged.h5"
    content = bytearray(paths[0].read_bytes())
    content[len(content) // 2] ^= 0xFF
    damaged.write_bytes(content)
    with pytest.raises(UserError, match=r"damaged\.h5: damaged"):
        collect([damaged])


# -- the page -----------------------------------------------------------------------------------------------


def test_equal_data_give_equal_bytes(paths, data):
    assert page.build(collect(paths, titles=TITLES)) == page.build(data)


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


def test_no_text_of_a_file_can_end_the_data(data):
    text = page.build(data)
    [packed] = re.findall(r'<script type="application/json" id="data">(.*?)</script>', text, re.DOTALL)
    assert json.loads(packed) == data


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
        ("const twice = 1;\n", "export function twice() {}\n", "more than one module: twice"),
        ("export default 3;\n", "", "a.js: cannot join this line"),
    ],
)
def test_scripts_that_cannot_be_joined(first, second, message, tmp_path, monkeypatch):
    (tmp_path / "a.js").write_text(first)
    (tmp_path / "b.js").write_text(second)
    monkeypatch.setattr(page, "WEB", tmp_path)
    with pytest.raises(ValueError, match=message):
        page.bundle(["a.js", "b.js"])


def test_command_embeds_the_seeds_that_are_asked_for(paths, tmp_path):
    output = tmp_path / "report" / "explorer.html"
    options = [
        *map(str, paths),
        "--output",
        str(output),
        "--seed",
        "8",
        "--environment",
        "chain=Rooms",
    ]
    result = CliRunner().invoke(command, options, catch_exceptions=False)
    assert result.exit_code == 0, result.output
    assert output.read_text(encoding="utf-8") == page.build(collect(paths, [8], {"chain": "Rooms"}))
