"""A bad configuration is refused in one line that names the key, the value and the constraint."""

from __future__ import annotations

import copy
import json
import math
import os
from datetime import date
from typing import Any, get_args, get_origin

import msgspec
import pytest
import yaml
from projects import ROOT

from ptl.config import Configuration
from ptl.errors import UserError
from ptl.files.configuration import completed, read_yaml
from ptl.keys import Key, keys_of
from ptl.report.config_page import MARK, json_schema, tables

PUBLISHED = yaml.safe_load((ROOT / "config/config.yaml").read_text())


@pytest.fixture(autouse=True)
def in_the_project_folder(monkeypatch):
    monkeypatch.chdir(ROOT)


def changed(path: str, value: Any, config: dict[str, Any] = PUBLISHED) -> dict[str, Any]:
    config = copy.deepcopy(config)
    *parents, last = path.split(".")
    entry = config
    for parent in parents:
        entry = entry.setdefault(parent, {})
    entry[last] = value
    return config


def refusal(config: Any) -> str:
    with pytest.raises(UserError) as caught:
        completed(config)
    assert "\n" not in str(caught.value) and len(str(caught.value)) < 500
    return str(caught.value)


# -- the run


def test_pipes_and_what_is_huge_are_refused_at_once(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    with (tmp_path / "huge.yaml").open("wb") as file:
        file.truncate(2**40)
    for name, reason in (("pipe", "a pipe, not a file"), ("huge.yaml", "more than"), ("none", "No such file")):
        with pytest.raises(UserError, match=rf"{name}: cannot be read \({reason}.*\); check the path"):
            read_yaml(tmp_path / name)


def test_published_and_smoke_configurations_pass():
    assert completed(PUBLISHED).run == "published"
    smoke = yaml.safe_load((ROOT / "config/smoke.yaml").read_text())
    assert completed({**PUBLISHED, **smoke}).learning.episodes == 40


def test_published_configuration_names_only_what_differs_from_the_defaults():
    defaults = {key.name: key.default for key in keys_of(Configuration)}
    flat = {f"{group}.{key}": value for group, keys in PUBLISHED.items() if isinstance(keys, dict)
            for key, value in keys.items()} | PUBLISHED  # fmt: skip
    assert not [name for name, value in flat.items() if name in defaults and value == defaults[name]]


def test_a_map_and_a_method_are_enough():
    config = {"run": "own", "methods": ["ptl"], "environments": {"rooms": {"map": "config/environments/env2.txt"}}}
    complete = completed(config)
    entry = complete.environments["rooms"]
    assert (entry.title, entry.tasks, entry.discovery_tasks) == ("rooms", "ABCDEF", "DEF")
    assert complete.growth.environment == "rooms"
    assert completed(complete.to_dict()) == complete
    json.dumps(complete.to_dict(), allow_nan=False)


def test_environments_can_be_taken_away_and_added_to():
    own = {"map": "config/environments/env2.txt"}
    merged = {**PUBLISHED, "environments": {"own": own, **PUBLISHED["environments"], "env1": None}}
    assert list(completed(merged).environments) == ["env2", "env3", "own"], "the article's come first"
    nothing = dict.fromkeys(PUBLISHED["environments"])
    assert "environments: {} is not allowed; give one or more names" in refusal({**PUBLISHED, "environments": nothing})


@pytest.mark.parametrize(
    ("path", "value", "says"),
    [
        ("seeds", 0, "configuration key seeds: 0 is not allowed; give a whole number >= 1 and <= 100,000"),
        ("learning.alpha", -0.1, "configuration key learning.alpha: -0.1 is not allowed; give a number > 0 and <= 1"),
        ("learning.episodes", 20.0, "configuration key learning.episodes: 20.0 is not allowed; give a whole number"),
        ("learning.alhpa", 0.1, "configuration key learning.alhpa: unknown; known are episodes, alpha"),
        ("learing", {}, "configuration key learing: unknown; known are"),
        ("methods", ["ptl", "sarsa"], "unknown method 'sarsa'; known are full_transfer"),
        ("methods", [], "configuration key methods: [] is not allowed; give a list of one or more methods"),
        ("methods", ["ptl", "ptl"], "configuration key methods: ptl is repeated"),
        ("environments.env1", {}, "configuration key environments.env1.map: missing; give a path"),
        ("environments.env1.map", "config/none.txt", "config/none.txt: cannot be read"),
        ("environments.env1.tasks", "ABZ", "environments.env1.tasks: 'ABZ' is not allowed; give one or more of ABCDEF"),
        ("environments.env1.tasks", "ABA", "environments.env1.tasks: 'ABA' is not allowed"),
        ("environments.env1.tasks", "AIB", "environments.env1.tasks: 'AIB' is not allowed"),
        ("environments.env3.tasks", "AB", "env3.discovery_tasks: 'CDEF' is not allowed; give one or more of AB"),
        ("environments.env1.article_items.map", "figure06", "environments.env2.article_items.map: figure06 is already"),
        ("environments.env1.article_items.map", "figure14", "give one of figure05, figure06, figure07"),
        ("environments.Env", {"map": "m"}, "configuration key environments: 'Env' is not allowed; give lower-case"),
        ("run", "../elsewhere", "configuration key run: '../elsewhere' is not allowed; give letters, digits, _ and -"),
        ("run", "good\n", r"configuration key run: 'good\n' is not allowed"),
        ("measures.window", 201, "measures.window: 201 must not exceed learning.episodes (200)"),
        ("learning.episodes", 9, "measures.window: 10 must not exceed learning.episodes (9)"),
        ("growth.environment", "env9", "growth.environment: 'env9' is not allowed; give one of env1, env2, env3"),
        ("growth.tasks", 7, "configuration key growth.tasks: 7 must exceed growth.breakpoint (7)"),
        ("subgoal_frequencies.starts", "some", "starts: 'some' is not allowed; give all or a whole number >= 0"),
        ("statistics.confidence", 95, "configuration key statistics.confidence: 95 is not allowed; give a number > 0"),
    ],
)
def test_refusals(path, value, says):
    assert says in refusal(changed(path, value))


def test_keys_that_are_no_text_are_refused():
    """YAML reads `0:` as a number."""
    assert refusal(changed("environments", {**PUBLISHED["environments"], 0: {"map": "m"}})).startswith(
        "configuration key environments: 0 is not allowed"
    )
    assert "configuration key 7: unknown" in refusal({**PUBLISHED, 7: 1})


@pytest.mark.parametrize("config", [None, [], "text", 7, {1: 2}, {"run": "a"}], ids=repr)
def test_what_is_no_configuration_is_refused(config):
    if isinstance(config, dict):
        refusal(config)
    else:
        with pytest.raises(UserError, match="give keys and values"):
            Configuration.from_dict(config)


# -- every key, from its definition

KEYS = [(key, key.name.replace("<name>", "env1")) for key in keys_of(Configuration)]
NAMES = [name for _, name in KEYS]
EVERY_GROUP = {**PUBLISHED, "foreign_results": {"env1": {"file": "steps.csv"}}}


def wrong_values(key: Key) -> list[Any]:
    """Values of other types, and those just outside the range."""
    kind, meta = get_args(key.type)
    wrong: list[Any] = [math.nan, math.inf, -math.inf, [[]], {"a": {"b": 1}}, [None], b"bytes", "\x00", "a\n"]
    wrong = [value for value in wrong if not (get_origin(kind) is dict and isinstance(value, dict))]
    wrong += [None] if type(None) not in get_args(kind) else []
    wrong += {int: ["7", True, 1.5, 10**400], float: ["0.5", True, 10**400], str: [7], bool: ["yes", 1]}.get(
        kind, [7.5]
    )
    wrong += [bound for bound in (meta.gt, meta.lt) if bound is not None]
    wrong += [meta.ge - 1] if meta.ge is not None else []
    wrong += [meta.le + 1] if meta.le is not None else []
    return wrong


@pytest.mark.parametrize(("key", "name"), KEYS, ids=NAMES)
def test_every_key_refuses_what_it_cannot_mean(key, name):
    for value in wrong_values(key):
        assert refusal(changed(name, value, EVERY_GROUP)).startswith(f"configuration key {name}: "), repr(value)


@pytest.mark.parametrize("group", ["", *sorted({name.rpartition(".")[0] for name in NAMES} - {""})])
@pytest.mark.parametrize("name", ["color", "seeds\n"])
def test_unknown_keys_are_refused_everywhere(group, name):
    entry = config = copy.deepcopy(EVERY_GROUP)
    for part in filter(None, group.split(".")):
        entry = entry.setdefault(part, {})
    entry[name] = 1
    assert "unknown; known are" in refusal(config)


# -- the text of configuration files


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("run: a\nseeds: 1\nrun: b\n", "key run is given in lines 1 and 3; keep one of them"),
        ("learning: {alpha: 0.1, gamma: 1, alpha: 0.2}\n", "key learning.alpha is given in lines 1 and 1"),
        ("environments:\n  a: {map: x}\n  a: {map: y}\n", "key environments.a is given in lines 2 and 3"),
        ('{"run": "a", "run": "b"}', "key run is given in lines 1 and 1"),
        ("run: [a\n", "is not YAML"),
        ("\trun: a\n", "line 1: is indented with a tab; use blanks"),
        ("learning:\n \tepisodes: 20\n", "line 2: is indented with a tab; use blanks"),
        ("seeds: 010\n", "line 1: key seeds: 010 is read as 8, an octal number; write 10, or '010' for the text"),
        (
            "learning:\n  episodes: 0100\n",
            "line 2: key learning.episodes: 0100 is read as 64, an octal number; write 100",
        ),
        ("seeds: 1_00\n", "line 1: key seeds: 1_00 is read as 100, without the underscores; write 100, or '1_00'"),
        ("a: 1_0.5\n", "1_0.5 is read as 10.5, without the underscores; write 10.5"),
        ("a: [7, -0_17]\n", "key a: -0_17 is read as -15, an octal number; write -17"),
        ("a: !!int '010'\n", "key a: 010 is read as 8, an octal number; write 10"),
        ("learning: {episodes: 1:30}\n", "key learning.episodes: 1:30 is read as 90, a number in base 60; write 90"),
        (
            "a: 1:30:00.5\n",
            "1:30:00.5 is read as 5400.5, a number in base 60; write 5400.5, or",
        ),
        ("environments: {a: {tasks: NO}}\n", "key environments.a.tasks: NO is read as false; write 'NO' for the text"),
        ("methods: [ptl, on]\n", "key methods: on is read as true; write 'on' for the text, or true"),
        ("title: Yes\n", "key title: Yes is read as true; write 'Yes'"),
        ("environments: {no: {map: x}}\n", "key environments.no is read as bool, not as text; write 'no'"),
        ("environments: {7: {map: x}}\n", "key environments.7 is read as int, not as text; write '7'"),
        ("title: 2019-05-01\n", "key title: 2019-05-01 is read as a date; write '2019-05-01' for the text"),
        ("<<: {seeds: 1}\n", "key << is read as merge, not as text"),
        ("run: a\n---\nrun: b\n", "is not YAML"),
        ("run: 2024-13-45\n", "key run: 2024-13-45 is read as a date"),
        ("- run\n", "holds no keys"),
        ("", "holds no keys"),
        ("? [a, b]\n: 1\n", "a key must be a word"),
        ("a: &a [1]\nb: *a\n", "line 2: *a is an alias"),
        ("a: &a\n  b: *a\n", "line 2: *a is an alias"),
        ("[" * 5000, "nested more than 20 deep"),
        ("run: \x00\n", "is not YAML"),
    ],
    ids=lambda text: repr(text[:20]),
)
def test_text_of_a_configuration_file(tmp_path, text, says):
    path = tmp_path / "config.yaml"
    path.write_text(text)
    with pytest.raises(UserError) as caught:
        read_yaml(path)
    assert says in str(caught.value) and str(path) in str(caught.value) and "\n" not in str(caught.value)


def test_values_that_are_read_as_they_are_written_pass(tmp_path):
    path = tmp_path / "config.yaml"
    path.write_text(
        "\ufeffa: 0\r\nb: 0.05\r\nc: 'NO'\r\nd: '010'\r\ne: true\r\nskills: {null_skill: off}\r\nf: 1000\r\n"
    )
    read = {"a": 0, "b": 0.05, "c": "NO", "d": "010", "e": True, "skills": {"null_skill": False}, "f": 1000}
    assert read_yaml(path) == read


@pytest.mark.parametrize(
    ("path", "value", "meant"),
    [
        ("learning.alpha", "5e-2", 0.05), ("learning.alpha", "0,05", 0.05), ("learning.alpha", "1", 1),
        ("learning.episodes", "1e3", 1000), ("learning.episodes", "1,000", 1000), ("learning.episodes", "09", 9),
        ("learning.episodes", "0o17", 15), ("learning.episodes", 20.0, 20),
        ("learning.max_steps", "1.0e6", 1000000),
    ],
)  # fmt: skip
def test_the_value_that_was_probably_meant_is_named(path, value, meant):
    assert refusal(changed(path, value)).endswith(f" (perhaps {meant!r} was meant)")


@pytest.mark.parametrize("value", [2024, True, date(2024, 5, 1)], ids=repr)
def test_a_text_that_needs_quotes_is_named(value):
    assert refusal(changed("run", value)).endswith("(a text that looks like something else needs quotes)")


@pytest.mark.parametrize(
    ("value", "says"),
    [
        (None, "has no value; give a number"),
        (True, "true is not allowed"),
        (math.inf, ".inf is not allowed"),
        ([None, {"a": math.nan}], "[null, {'a': .nan}] is not allowed"),
    ],
    ids=repr,
)
def test_values_are_shown_as_they_are_written(value, says):
    assert f"learning.alpha: {says}" in refusal(changed("learning.alpha", value))


@pytest.mark.parametrize("value", ["many", "2e9", "inf", "1.5", True, None, -3])
def test_where_no_value_was_probably_meant_none_is_named(value):
    assert "perhaps" not in refusal(changed("learning.episodes", value))


def test_published_texts_pass():
    for path in (ROOT / "config").glob("*.yaml"):
        assert read_yaml(path) == yaml.safe_load(path.read_text())


def test_files_that_are_not_text_are_refused(tmp_path):
    (tmp_path / "binary.yaml").write_bytes(b"run: \xff\xfe")
    for path, says in [(tmp_path / "binary.yaml", "is not UTF-8"), (tmp_path / "none.yaml", "cannot be read"),
                       (tmp_path, "cannot be read")]:  # fmt: skip
        with pytest.raises(UserError, match=says):
            read_yaml(path)


# -- what is made from the definition


def test_the_tables_of_keys_are_up_to_date():
    page = (ROOT / "config/README.md").read_text(encoding="utf-8")
    assert page.partition(MARK)[2] == "\n" + tables(), "run: ptl docs"


def test_every_key_has_a_sentence_and_a_row():
    rows = tables()
    for key in keys_of(Configuration):
        assert key.meta.description.endswith(".")
        assert f"| `{key.name}` |" in rows


def test_the_schema_for_editors_knows_every_key():
    definitions = json.loads(json_schema())["$defs"]
    last = {key.name.rpartition(".")[2] for key in keys_of(Configuration)}
    assert last <= {name for definition in definitions.values() for name in definition["properties"]}
    assert definitions["Learning"]["properties"]["alpha"] == {
        "type": "number", "description": "Learning rate.", "exclusiveMinimum": 0, "maximum": 1, "default": 0.05,
    }  # fmt: skip
    assert msgspec.json.decode(json_schema())["$defs"]["Configuration"]["additionalProperties"] is False
