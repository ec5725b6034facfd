"""A bad configuration is refused in one line that names the key and the remedy."""

from __future__ import annotations

import copy
import math
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from ptl.configuration import check
from ptl.errors import UserError

ROOT = Path(__file__).resolve().parent.parent
SCHEMA = ROOT / "workflow/schemas/config.schema.yaml"
PUBLISHED = yaml.safe_load((ROOT / "config/config.yaml").read_text())


@pytest.fixture(autouse=True)
def in_the_project_folder(monkeypatch):
    monkeypatch.chdir(ROOT)


def changed(path: str, value: Any) -> dict:
    config = copy.deepcopy(PUBLISHED)
    *parents, last = path.split(".")
    entry = config
    for parent in parents:
        entry = entry.setdefault(parent, {})
    entry[last] = value
    return config


def test_published_and_smoke_configurations_pass():
    check(PUBLISHED, SCHEMA)
    smoke = yaml.safe_load((ROOT / "config/smoke.yaml").read_text())
    merged = copy.deepcopy(PUBLISHED)
    for key, value in smoke.items():
        merged[key] = {**merged[key], **value} if isinstance(value, dict) else value
    check(merged, SCHEMA)


def test_keys_that_are_no_text_are_refused_beside_other_faults():
    """YAML reads `0:` as a number, and errors at such keys cannot be sorted."""
    config = changed("environments.env1.map", None)
    config["environments"][0] = None
    with pytest.raises(UserError, match=r"configuration key environments: 0 is not allowed as a key; give a word"):
        check(config, SCHEMA)
    with pytest.raises(UserError, match=r"\(top level\): 7 is not allowed as a key"):
        check({**PUBLISHED, 7: 1}, SCHEMA)


@pytest.mark.parametrize(
    ("path", "value", "says"),
    [
        ("seeds", 0, "configuration key seeds: 0 is not allowed; give at least 1"),
        ("learning.alpha", -0.1, "configuration key learning.alpha: -0.1 is not allowed; give greater than 0"),
        ("learning.alhpa", 0.1, "configuration key learning: unknown key 'alhpa'; known are episodes, alpha"),
        ("learing", {}, "unknown key 'learing'; known are run, root_seed"),
        ("methods", ["ptl", "sarsa"], "unknown method 'sarsa'; known are full_transfer"),
        ("methods", [], "configuration key methods"),
        ("environments.env1.map", "config/none.txt", "config/none.txt: cannot be read"),
        ("environments.env1.tasks", "ABZ", "no goal 'Z' on the map"),
        ("environments.env1.tasks", "ABA", "A stands there twice"),
        ("environments.env1.tasks", "AIB", "configuration key environments.env1.tasks"),
        ("environments.env1.discovery_tasks", "AG", "configuration key environments.env1"),
        ("environments.../x", {"map": "m", "tasks": "A"}, "configuration key"),
        ("run", "../elsewhere", "configuration key run"),
        ("run", "$(touch x)", "configuration key run"),
        ("run", "a b", "configuration key run"),
        ("growth.environment", "env9", "configuration key growth.environment: 'env9' is not among the environments"),
        ("growth.tasks", 7, "configuration key growth.tasks: 7 leaves nothing beyond growth.breakpoint (7)"),
        ("subgoal_frequencies.starts", "some", "configuration key subgoal_frequencies.starts"),
        ("statistics.confidence", 95, "configuration key statistics.confidence: 95 is not allowed; give less than 1"),
    ],
)
def test_refusals(path, value, says):
    with pytest.raises(UserError) as caught:
        check(changed(path, value), SCHEMA)
    assert says in str(caught.value) and "\n" not in str(caught.value)


def _leaves(entry: Any, path: str = "") -> list[str]:
    if not isinstance(entry, dict):
        return [path]
    return [leaf for key, value in entry.items() for leaf in _leaves(value, f"{path}.{key}" if path else key)]


ANYTHING = st.one_of(
    st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=8), st.lists(st.integers(), max_size=3),
    st.dictionaries(st.text(max_size=4), st.integers(), max_size=2),
)  # fmt: skip


@settings(max_examples=150, deadline=None)
@given(st.sampled_from(_leaves(PUBLISHED)), ANYTHING)
def test_any_value_at_any_key_passes_or_is_refused_in_one_line(path, value):
    try:
        check(changed(path, value), SCHEMA)
    except UserError as error:
        assert "\n" not in str(error)
    else:
        assert not (isinstance(value, float) and math.isnan(value))


def test_every_key_of_the_schema_is_described():
    def walk(entry: dict, path: str) -> None:
        for key, value in entry.get("properties", {}).items():
            assert value.get("description"), f"{path}.{key} has no description"
            walk(value, f"{path}.{key}")
            if isinstance(value.get("additionalProperties"), dict):
                walk(value["additionalProperties"], f"{path}.{key}.*")

    walk(yaml.safe_load(SCHEMA.read_text()), "")
