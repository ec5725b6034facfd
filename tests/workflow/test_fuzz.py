"""Rubbish in, one line out: configurations and maps of every wrong kind either run or are refused with a reason."""

from __future__ import annotations

import copy
import json
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
from projects import ROOMS, ROOT, TINY, Project, errors_of

from ptl.config import Configuration
from ptl.errors import UserError
from ptl.files.configuration import completed
from ptl.keys import keys_of
from ptl.world.gridworld import MAX_CELLS, GridWorld
from ptl.world.map_files import load_map

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
        complete = completed(config)
    except UserError as error:
        line = str(error)
        assert line.strip() and "\n" not in line and len(line) < 2000, line[:300]
        return line
    # Accepted values are safe in names and commands.
    for name in (complete.run, *complete.environments, *complete.methods):
        assert SAFE_NAME.fullmatch(name)
    json.dumps(complete.to_dict(), allow_nan=False)
    return "runs"


def changed(*changes: tuple[tuple[str, ...], Any]) -> dict[str, Any]:
    config = copy.deepcopy(PUBLISHED)
    for (*parents, last), value in changes:
        entry = config
        for parent in parents:
            entry = entry.setdefault(parent, {}) if isinstance(entry, dict) else {}
        if isinstance(entry, dict):
            entry[last] = value
    return config


ANYTHING = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20) | st.sampled_from(HOSTILE)
    | st.integers(min_value=10**300) | st.dates() | st.binary(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=6) | st.integers(), inner, max_size=3),
    max_leaves=6,
)  # fmt: skip
KEYS = [tuple(key.name.replace("<name>", "env1").split(".")) for key in keys_of(Configuration)]
PATHS = st.sampled_from([path[:depth] for path in KEYS for depth in range(1, len(path) + 1)])
QUICK = settings(
    max_examples=300,
    deadline=None,
    derandomize="FUZZ_FREELY" not in os.environ,
    suppress_health_check=list(HealthCheck),
)
"""The same examples every time; set FUZZ_FREELY to try others."""


@pytest.mark.parametrize("number", [300, pytest.param(10_000, marks=pytest.mark.slow)])
def test_any_configuration_runs_or_is_refused(number, record_property):
    @settings(QUICK, max_examples=number)
    @given(st.lists(st.tuples(PATHS, ANYTHING), min_size=1, max_size=3))
    def run(changes):
        outcome(changed(*changes))

    run()
    record_property("configurations tried", number)


# -- names ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", [name for name in HOSTILE if name != "-rf"], ids=lambda name: repr(name[:12]))
def test_hostile_names_never_become_names(name):
    for path, value in [
        (("run",), name), (("environments", name), PUBLISHED["environments"]["env1"]), (("methods",), [name]),
        (("environments", "env1", "article_items", "map"), name),
        *([(("growth", "environment"), name), (("environments", "env1", "tasks"), name)] if name else []),
    ]:  # fmt: skip
        assert outcome(changed((path, value))) != "runs", path


def test_the_end_of_a_name_is_the_end_of_its_line():
    """In regular expressions $ also matches before a final line end."""
    for path, value in [
        (("run",), "good\n"), (("environments", "env1", "tasks"), "AB\n"), (("methods",), ["ptl\n"]),
        (("environments", "good\n"), PUBLISHED["environments"]["env1"]),
    ]:  # fmt: skip
        assert outcome(changed((path, value))) != "runs", path


TEXTS = ["a b", "it's", 'say "so"', "$(touch hacked)", "`touch hacked`", "a;touch hacked", "a|b>c&d", "é*?~", "..x"]
"""Texts that titles and paths of maps may contain."""


def test_titles_and_map_paths_never_become_shell_text(tmp_path):
    """Titles and paths may be any text; a job that gets them must take them as text."""
    project = Project(tmp_path / "project", methods=["no_transfer"], seeds=1)
    environments = dict(TINY["environments"])
    for number, text in enumerate(TEXTS):
        path = project.folder / f"maps/{text}/{text}.txt"
        path.parent.mkdir(parents=True)
        path.write_text(ROOMS)
        environments[f"rooms{number}"] = {"map": f"maps/{text}/{text}.txt", "title": text, "tasks": "A"}
    project.configure(project.config | {"environments": environments})
    before = {path for path in tmp_path.rglob("*") if path.is_file()}
    targets = [f"results/tiny/learning/rooms{number}/no_transfer/seed_000.h5" for number in range(len(TEXTS))]
    targets += ["reports/tiny/figures/map_rooms3.png", "reports/tiny/tables/library_bytes.csv"]
    project.make(*targets)
    new = {path for path in tmp_path.rglob("*") if path.is_file()} - before
    inside = [project.folder / folder for folder in ("results", "reports", "logs", ".snakemake")]
    strangers = [path for path in new if "__pycache__" not in path.parts]
    strangers = [path for path in strangers if not any(path.is_relative_to(folder) for folder in inside)]
    assert {project.folder / target for target in targets} <= new and not strangers


@pytest.mark.parametrize(
    "path", ["-rf", "{x}", "a{b", "a\nb", "a\n", "a\0b", "", "x" * 2000], ids=lambda path: repr(path[:9])
)
def test_map_paths_that_mean_something_to_snakemake_are_refused(path):
    assert "environments.env1.map" in outcome(changed((("environments", "env1", "map"), path)))
    if path and not path.startswith("-"):
        assert "environments.env1.title" in outcome(changed((("environments", "env1", "title"), path)))


def test_a_key_given_twice_stops_the_workflow(tmp_path):
    project = Project(tmp_path)
    with (tmp_path / "config/config.yaml").open("a") as file:
        file.write("seeds: 3\n")
    [line] = errors_of(project.snakemake("-n"))
    assert "config/config.yaml: key seeds is given in lines 2 and" in line


def test_more_jobs_than_can_be_planned_are_refused_in_bounded_memory(tmp_path):
    project = Project(tmp_path, seeds=100_000)
    done = project.snakemake("-n", preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (2**30, 2**30)))
    [line] = errors_of(done)
    assert "more than 40,000 learning jobs; split it" in line


def test_the_cost_is_said_before_the_first_job(tmp_path):
    assert "a whole run takes about 10 learning jobs" in Project(tmp_path).make("-n")


@pytest.mark.parametrize(
    ("path", "value", "says"),
    [
        (("seeds",), 2.0, "seeds: 2.0 is not allowed; give a whole number"),
        (("measures", "window"), 5.0, "measures.window: 5.0 is not allowed; give a whole number"),
        (("measures", "window"), 201, "measures.window: 201 must not exceed learning.episodes (200)"),
    ],
)
def test_whole_numbers_are_whole_and_windows_fit(path, value, says):
    assert says in outcome(changed((path, value)))


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


def test_random_maps(record_property):
    chance = random.Random(6)
    found = Counter(map_outcome(GridWorld.from_text, random_text(chance)).split(":")[-1][:12] for _ in range(2000))
    record_property("maps tried", found.total())
    assert found["runs"] > 100 and len(found) > 5, found


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


@pytest.mark.parametrize(("rows", "columns"), [(1000, 1000), (MAX_CELLS, 1)], ids=["square", "one column"])
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
