"""Rubbish in, one line out: configurations and maps of every wrong kind either run or are refused with a reason."""

from __future__ import annotations

import copy
import json
import math
import os
import random
import re
import resource
import time
from collections import Counter
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from test_workflow import ROOT, Project

from ptl.configuration import check, check_text
from ptl.errors import UserError
from ptl.gridworld import MAX_CELLS, GridWorld, load_map
from ptl.parameters import Parameters

SCHEMA_PATH = ROOT / "workflow/schemas/config.schema.yaml"
SCHEMA = yaml.safe_load(SCHEMA_PATH.read_text())
PUBLISHED = yaml.safe_load((ROOT / "config/config.yaml").read_text())

HOSTILE = [
    "../elsewhere", "/etc/passwd", "a b", "a'b", 'a"b', "$(touch hacked)", "`touch hacked`", "a;touch hacked", "a\nb",
    "a\\b", "{wildcards}", "{{x}}", "-rf", "--config", "*", "~", "a\0b", "a|b", "a>b", "é", "", ".", "..", "x" * 5000,
]  # fmt: skip
"""Names that mean something to a shell, to Snakemake or to a file system."""

SAFE_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]*")


@pytest.fixture(autouse=True)
def in_the_project_folder(monkeypatch):
    monkeypatch.chdir(ROOT)


def outcome(config: Any) -> str:
    """'runs', or the one line of the refusal; anything else that is raised fails the test."""
    try:
        check(config, SCHEMA_PATH)
    except UserError as error:
        line = str(error)
        assert line.strip() and "\n" not in line and len(line) < 2000, line[:300]
        return line
    return "runs"


def changed(path: tuple[str, ...], value: Any) -> dict[str, Any]:
    config = copy.deepcopy(PUBLISHED)
    entry = config
    for parent in path[:-1]:
        entry = entry.setdefault(parent, {})
    entry[path[-1]] = value
    return config


def keys(entry: dict[str, Any], above: tuple[str, ...] = ()) -> list[tuple[tuple[str, ...], dict[str, Any]]]:
    """Every key of the schema with its own schema; the environments stand for themselves."""
    found = []
    for name, value in entry.get("properties", {}).items():
        found += [((*above, name), value), *keys(value, (*above, name))]
        if isinstance(value.get("additionalProperties"), dict):
            found += keys(value["additionalProperties"], (*above, name, "env1"))
    return found


KEYS = keys(SCHEMA)
NAMES = [".".join(path) for path, _ in KEYS]


def out_of_range(schema: dict[str, Any]) -> list[Any]:
    """Values just outside the range that the schema gives."""
    found: list[Any] = []
    for limit, step in (("minimum", -1), ("maximum", 1)):
        if limit in schema:
            found.append(schema[limit] + step)
    for limit in ("exclusiveMinimum", "exclusiveMaximum"):
        if limit in schema:
            found.append(schema[limit])
    return found


@pytest.mark.parametrize(("path", "schema"), KEYS, ids=NAMES)
def test_every_key_refuses_what_it_cannot_mean(path, schema):
    wrong: list[Any] = [math.nan, math.inf, -math.inf, [[]], {"a": {"b": 1}}, [None], *out_of_range(schema)]
    if "type" in schema:
        wrong += [value for kind, value in {
            "integer": "7", "number": "0.5", "string": 7, "boolean": "yes", "array": 7, "object": 7,
        }.items() if kind == schema["type"]]  # fmt: skip
        wrong.append(None)
    if schema.get("type") in {"integer", "number"}:
        wrong += [True, 10**400, -(10**400), 1e308]
    if schema.get("type") == "integer":
        wrong.append(1.5)
    for value in wrong:
        assert outcome(changed(path, value)) != "runs", f"{path}: {value!r:.80} was accepted"


@pytest.mark.parametrize(("path", "schema"), KEYS, ids=NAMES)
def test_every_key_may_be_missing_or_is_asked_for(path, schema):
    config = changed(path, None)
    entry = config
    for parent in path[:-1]:
        entry = entry[parent]
    del entry[path[-1]]
    line = outcome(config)
    if line != "runs":
        assert path[-1] in line or "environments" in path, line


@pytest.mark.parametrize("group", [(), *[path for path, schema in KEYS if "properties" in schema]], ids=str)
def test_unknown_keys_are_refused_everywhere(group):
    for name in ("colour", "Seeds", "run ", "__use_yte__", "seeds\n"):
        line = outcome(changed((*group, name), 1))
        assert line != "runs" and "unknown key" in line


ANYTHING = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20) | st.sampled_from(HOSTILE)
    | st.integers(min_value=10**300) | st.dates() | st.binary(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=6) | st.integers(), inner, max_size=3),
    max_leaves=6,
)  # fmt: skip
PATHS = st.sampled_from([path for path, _ in KEYS])
QUICK = settings(
    max_examples=300,
    deadline=None,
    derandomize="FUZZ_FREELY" not in os.environ,
    suppress_health_check=list(HealthCheck),
)
"""The same examples every time; set FUZZ_FREELY to try others."""
THOROUGH = settings(QUICK, max_examples=10_000)


def any_configuration_runs_or_is_refused(changes: list[tuple[tuple[str, ...], Any]]) -> None:
    config = copy.deepcopy(PUBLISHED)
    for path, value in changes:
        entry = config
        for parent in path[:-1]:
            entry = entry.setdefault(parent, {}) if isinstance(entry, dict) else {}
        if isinstance(entry, dict):
            entry[path[-1]] = value
    if outcome(config) != "runs":
        return
    # What was let through is safe to build names and commands from, and the learner takes it too.
    assert SAFE_NAME.fullmatch(config["run"])
    for name in [*config["environments"], *config["methods"]]:
        assert SAFE_NAME.fullmatch(name)
    groups = ("learning", "skills", "subgoals", "policy_reuse")
    json.dumps({group: config.get(group, {}) for group in groups}, allow_nan=False)
    Parameters.from_dict({group: config.get(group, {}) for group in groups})


CHANGES = st.lists(st.tuples(PATHS, ANYTHING), min_size=1, max_size=3)


def try_configurations(how: settings) -> int:
    tried = 0

    @how
    @given(CHANGES)
    def run(changes):
        nonlocal tried
        tried += 1
        any_configuration_runs_or_is_refused(changes)

    run()
    return tried


def test_any_configuration_runs_or_is_refused(record_property):
    record_property("configurations tried", try_configurations(QUICK))


@pytest.mark.slow
def test_ten_thousand_configurations_run_or_are_refused(record_property):
    record_property("configurations tried", try_configurations(THOROUGH))


@pytest.mark.parametrize("config", [None, [], "text", 7, {1: 2}, {"run": "a"}], ids=repr)
def test_what_is_no_configuration_is_refused(config):
    assert outcome(config) != "runs"


# -- names ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", [name for name in HOSTILE if name != "-rf"], ids=lambda name: repr(name[:12]))
def test_hostile_names_never_become_names(name):
    assert outcome(changed(("run",), name)) != "runs"
    assert outcome(changed(("environments", name), PUBLISHED["environments"]["env1"])) != "runs"
    assert outcome(changed(("methods",), [name])) != "runs"
    assert outcome(changed(("growth", "environment"), name)) != "runs"
    assert outcome(changed(("environments", "env1", "tasks"), name)) != "runs"
    assert outcome(changed(("environments", "env1", "article_items", "map"), name)) != "runs"


def test_the_end_of_a_name_is_the_end_of_its_line():
    """In regular expressions $ also matches before a final line end."""
    for path, value in [(("run",), "good\n"), (("environments", "env1", "tasks"), "AB\n"),
                        (("methods",), ["ptl\n"])]:  # fmt: skip
        assert outcome(changed(path, value)) != "runs", path
    assert outcome(changed(("environments", "good\n"), PUBLISHED["environments"]["env1"])) != "runs"


TEXTS = ["a b", "it's", 'say "so"', "$(touch hacked)", "`touch hacked`", "a;touch hacked", "a|b>c&d", "é*?~", "..x"]
"""Texts that titles and paths of maps may hold."""


def test_titles_and_map_paths_never_become_shell_text(tmp_path):
    """Titles and paths may be any text; a job that gets them must take them as text."""
    (tmp_path / "project").mkdir()
    project = Project(tmp_path / "project")
    config = yaml.safe_load((project.folder / "tiny.yaml").read_text())
    config["methods"], config["seeds"] = ["no_transfer"], 1
    for number, text in enumerate(TEXTS):
        path = project.folder / f"maps/{text}/{text}.txt"
        path.parent.mkdir(parents=True)
        path.write_text((project.folder / "rooms.txt").read_text())
        name = f"rooms{number}"
        config["environments"][name] = {"map": f"maps/{text}/{text}.txt", "title": text, "tasks": "A"}
    (project.folder / "tiny.yaml").write_text(yaml.safe_dump(config, allow_unicode=True))
    before = {path for path in tmp_path.rglob("*") if path.is_file()}
    names = [f"rooms{number}" for number in range(len(TEXTS))]
    targets = [f"results/tiny/learning/{name}/no_transfer/seed_000.h5" for name in names]
    targets.append("reports/tiny/figures/map_rooms3.png")
    targets.append("reports/tiny/tables/library_bytes.csv")
    done = project.snakemake(*targets, config="tiny")
    assert done.returncode == 0, done.stderr[-3000:]
    new = {path for path in tmp_path.rglob("*") if path.is_file()} - before
    inside = [project.folder / folder for folder in ("results", "reports", "logs", ".snakemake")]
    strangers = [path for path in new if not any(path.is_relative_to(folder) for folder in inside)]
    assert {project.folder / target for target in targets} <= new and not strangers


@pytest.mark.parametrize(
    "path", ["-rf", "{x}", "a{b", "a\nb", "a\n", "a\0b", "", "x" * 2000], ids=lambda path: repr(path[:9])
)
def test_map_paths_that_mean_something_to_snakemake_are_refused(path):
    assert "environments.env1.map" in outcome(changed(("environments", "env1", "map"), path))
    if path and not path.startswith("-"):
        assert "environments.env1.title" in outcome(changed(("environments", "env1", "title"), path))


# -- the text of configuration files ----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("run: a\nseeds: 1\nrun: b\n", "key run stands in lines 1 and 3; keep one of them"),
        ("learning: {alpha: 0.1, gamma: 1, alpha: 0.2}\n", "key learning.alpha stands in lines 1 and 1"),
        ("environments:\n  a: {map: x}\n  a: {map: y}\n", "key environments.a stands in lines 2 and 3"),
        ('{"run": "a", "run": "b"}', "key run stands in lines 1 and 1"),
        ("run: [a\n", "is not YAML"),
        ("\trun: a\n", "is not YAML"),
        ("run: a\n---\nrun: b\n", "is not YAML"),
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
        check_text(path)
    assert says in str(caught.value) and str(path) in str(caught.value) and "\n" not in str(caught.value)


def test_published_texts_pass():
    for path in (ROOT / "config").glob("*.yaml"):
        check_text(path)


def test_files_that_are_not_text_are_refused(tmp_path):
    (tmp_path / "binary.yaml").write_bytes(b"run: \xff\xfe")
    for path, says in [(tmp_path / "binary.yaml", "is not UTF-8"), (tmp_path / "none.yaml", "cannot be read"),
                       (tmp_path, "cannot be read")]:  # fmt: skip
        with pytest.raises(UserError, match=says):
            check_text(path)


def test_a_key_given_twice_stops_the_workflow(tmp_path):
    project = Project(tmp_path)
    text = (tmp_path / "tiny.yaml").read_text()
    (tmp_path / "tiny.yaml").write_text(text + "seeds: 3\n")
    done = project.snakemake("-n", config="tiny")
    assert done.returncode != 0
    [line] = [line for line in done.stderr.splitlines() if line.startswith("error:")]
    assert "config/config.yaml: key seeds stands in lines 3 and" in line and "Traceback" not in done.stderr


# -- maps -------------------------------------------------------------------------------------------------------


def map_outcome(read: Any, *arguments: Any) -> str:
    """'runs', or the one line of the refusal, for a map; a world that was let through is consistent."""
    try:
        world = read(*arguments)
    except UserError as error:
        line = str(error)
        assert line.strip() and "\n" not in line and len(line) < 2000
        return line
    assert world.n_states == (~world.walls).sum() > 0 and world.successors.shape == (world.n_states, 4)
    assert world.successors.min() >= 0 and world.successors.max() < world.n_states
    distances = world.distances_to(world.start)
    assert world.goals and all(distances[goal] > 0 for goal in world.goals.values())
    return "runs"


def random_text(random: random.Random) -> str:
    """From nearly right to hopeless."""
    rows, columns = random.randint(0, 12), random.randint(0, 12)
    alphabet = random.choice(["#.", "#..", "#.IA", "#.IAB", ".IABCDEFGHIJKLMNOPQRSTUVWXYZ#", "#. \t\r\x00é\u2028🤖ia"])
    lines = [[random.choice(alphabet) for _ in range(columns)] for _ in range(rows)]
    if rows and columns and random.random() < 0.7:
        for letter in "I" + "ABC"[: random.randint(0, 3)]:
            lines[random.randrange(rows)][random.randrange(columns)] = letter
    if rows and random.random() < 0.2:
        lines[random.randrange(rows)].append(".")
    return random.choice(["\n", "\n", "\n", "\r\n"]).join("".join(line) for line in lines) + random.choice(["", "\n"])


def test_thousands_of_random_maps(record_property):
    chance = random.Random(6)
    found = Counter(map_outcome(GridWorld.from_text, random_text(chance)).split(":")[-1][:12] for _ in range(6000))
    record_property("maps tried", found.total())
    assert found["runs"] > 300 and len(found) > 5, found


def test_random_bytes(tmp_path, record_property):
    chance = random.Random(7)
    path = tmp_path / "map.txt"
    record_property("maps tried", 400)
    for _ in range(400):
        path.write_bytes(chance.randbytes(chance.randint(0, 300)))
        assert map_outcome(load_map, path) != "runs"


@QUICK
@given(st.text(alphabet=st.characters(), max_size=80))
def test_any_text_as_a_map(text):
    map_outcome(GridWorld.from_text, text)


def peak_bytes() -> int:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


@pytest.mark.parametrize(
    ("rows", "columns"), [(1000, 1000), (1, MAX_CELLS), (MAX_CELLS, 1)], ids=["square", "one row", "one column"]
)
def test_largest_maps_are_read_quickly_and_in_bounded_memory(rows, columns):
    lines = [["."] * columns for _ in range(rows)]
    lines[0][0], lines[-1][-1] = "I", "A"
    text = "\n".join(map("".join, lines))
    before, started = peak_bytes(), time.process_time()
    assert map_outcome(GridWorld.from_text, text) == "runs"
    assert time.process_time() - started < 20
    assert peak_bytes() - before < 10**9


@pytest.mark.parametrize(
    "text",
    ["." * (MAX_CELLS + 1), ".\n" * (MAX_CELLS + 1), "." * MAX_CELLS + "\n\nI", "I" + "A" * 10**6],
    ids=["wide", "high", "ragged", "letters"],
)
def test_larger_maps_are_refused_at_once(text):
    started = time.process_time()
    assert map_outcome(GridWorld.from_text, text) != "runs"
    assert time.process_time() - started < 5


def test_maps_that_are_no_files(tmp_path):
    (tmp_path / "folder.txt").mkdir()
    for path in (tmp_path / "folder.txt", tmp_path / "none.txt", Path("a\0b"), Path("x" * 300)):
        assert map_outcome(load_map, path) != "runs"


def test_a_map_file_of_endless_size_is_refused(tmp_path):
    path = tmp_path / "huge.txt"
    with path.open("wb") as file:
        file.truncate(4 * 2**30)  # sparse: 4 GiB of zero bytes that take no room
    before = peak_bytes()
    assert "is larger than" in map_outcome(load_map, path)
    assert peak_bytes() - before < 10**8
    if Path("/dev/zero").exists():
        assert map_outcome(load_map, Path("/dev/zero")) != "runs"
