"""Hyper-parameters: defaults of the schema, ranges, and nothing unknown."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from ptl.errors import UserError
from ptl.parameters import Parameters

ROOT = Path(__file__).resolve().parent.parent
SCHEMA = yaml.safe_load((ROOT / "workflow/schemas/config.schema.yaml").read_text())
GROUPS = Parameters().to_dict()


@pytest.mark.parametrize("group", GROUPS)
def test_defaults_of_code_schema_and_published_run_agree(group):
    in_schema = {key: entry["default"] for key, entry in SCHEMA["properties"][group]["properties"].items()}
    published = yaml.safe_load((ROOT / "config/config.yaml").read_text())[group]
    if group == "subgoals":
        assert published["trajectories"] == 30
    assert GROUPS[group] == in_schema == published


def test_round_trip():
    changed = Parameters().replace(learning__alpha=0.1, skills__null_skill=False)
    assert Parameters.from_dict(changed.to_dict()) == changed
    assert changed.learning.alpha == 0.1 and Parameters().learning.alpha == 0.05


@pytest.mark.parametrize(
    ("group", "key", "value"),
    [
        ("learning", "alpha", -0.1),
        ("learning", "alpha", 0),
        ("learning", "alpha", float("nan")),
        ("learning", "alpha", "fast"),
        ("learning", "alpha", True),
        ("learning", "episodes", 0),
        ("learning", "episodes", 1.5),
        ("learning", "max_steps", float("inf")),
        ("skills", "prior_form", "cauchy"),
        ("skills", "null_skill", 1),
        ("policy_reuse", "psi_decay", 1.0),
        ("subgoals", "cover_radius", -1),
    ],
)
def test_bad_values_are_refused_by_name(group, key, value):
    with pytest.raises(UserError, match=rf"^configuration key {group}\.{key}: .* is not allowed; give "):
        Parameters.from_dict({group: {key: value}})


@pytest.mark.parametrize("groups", [{"lerning": {}}, {"learning": {"alhpa": 0.1}}, {"learning": 3}])
def test_unknown_keys_are_refused(groups):
    with pytest.raises(UserError, match="configuration key"):
        Parameters.from_dict(groups)
