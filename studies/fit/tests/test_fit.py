"""The search for a reading that fits: a tiny search, and the records of the published one."""

from __future__ import annotations

import json
from pathlib import Path

import msgspec
import numpy as np
import pandas as pd
import pytest
import yaml
from projects import ROOT

from ptl.claims import CLAIMS
from ptl.config import Parameters
from ptl.files.configuration import completed, read_yaml
from ptl.learning.lives import learn_lives
from ptl.world.drawing import chain_of_rooms
from ptl.world.gridworld import GridWorld
from studies.fit.search import (
    IGNORED,
    NOT_VARIED,
    Search,
    Searcher,
    halves_frame,
    main,
    parts_frame,
    read_by,
    tried_frame,
)

ROOMS = "#########\n#I..#..A#\n#.......#\n#...#..B#\n#########\n"
FIT = ROOT / "studies/fit/config/fit.yaml"


def test_a_tiny_search_keeps_to_its_rule_and_records_every_stage(tmp_path: Path) -> None:
    (tmp_path / "rooms.txt").write_text(ROOMS)
    effort = {"seeds": 10, "growth_runs": 10, "resamples": 100}
    maps = dict.fromkeys(("env1", "env2"), str(tmp_path / "rooms.txt"))
    content = yaml.safe_load(FIT.read_text())
    content |= {
        "screen": effort, "final": dict(effort), "probes": 1, "kept": 1, "finalists": 1,
        "drawings": {"env1": [{"start": [2, 1]}, {"start": [3, 1]}]},
        "learners": [{"skills.prior_width": 0.5}, {"policy_reuse.untaught": "first_action"}],
        "reference": content["reference"] | {"maps": maps},
    }  # fmt: skip
    given = {
        "run": "x", "methods": ["no_transfer", "policy_reuse", "ptl"],
        "environments": {name: {"map": path, "tasks": "AB"} for name, path in maps.items()},
        "learning": {"episodes": 12}, "subgoals": {"trajectories": 5}, "growth": {"environment": "env2", "tasks": 8},
    }  # fmt: skip
    search = msgspec.convert(content, Search)
    outcomes = Searcher(search, completed(given)).run()
    finals = [own for own in outcomes.tried if own.stage == "final"]
    assert outcomes.choice.rank() == min(own.rank() for own in finals)
    assert outcomes.reference in finals, "the reference is decided too"
    tried = tried_frame(outcomes)
    assert list(dict.fromkeys(tried["stage"])) == ["probe", "drawings", "screen", "final", "final drawings"]
    assert (tried["stage"] == "probe").sum() == 3 + 1, "every drawing of either map"
    assert set(tried.loc[tried["stage"] == "screen", "learner"]) == {"{}", *map(json.dumps, search.learners)}
    for name, frame in (("search", content), ("config", given)):
        (tmp_path / f"{name}.yaml").write_text(yaml.safe_dump(frame))
    main(tmp_path / "search.yaml", tmp_path / "config.yaml", tmp_path / "out")
    halves, parts = halves_frame(outcomes, search.halves), parts_frame(outcomes)
    for name, frame in (("tried", tried), ("halves", halves), ("parts", parts)):
        published = pd.read_csv(ROOT / f"reports/fit/{name}.csv", nrows=1)
        assert list(pd.read_csv(tmp_path / f"out/{name}.csv")) == list(frame) == list(published)


@pytest.mark.parametrize("method", list(IGNORED))
def test_what_a_method_is_said_not_to_read_does_not_change_it(method: str) -> None:
    brief = Parameters().replace(learning__episodes=15, subgoals__trajectories=5)
    other = brief.replace(
        skills__prior_width=3.0, skills__prior_form="gaussian", skills__likelihood_exponent=0.5,
        skills__likelihood_weight=0.9, skills__patience=0.3, skills__patience_growth=1.1, subgoals__cover_radius=0,
        subgoals__distance_form="parabola", subgoals__known="paths", subgoals__threshold=0.05,
        policy_reuse__temperature_step=2.0, policy_reuse__untaught="first_action", policy_reuse__psi_decay=0.5,
    )  # fmt: skip
    kept = {name.replace(".", "__"): value for name, value in read_by(method, brief).items()}
    world = GridWorld.from_text(chain_of_rooms(4, 0.6, rooms=4), "chain")
    one, same, changed = (
        learn_lives(world, "ABC", method, parameters, 3, range(4), "x")["steps"]
        for parameters in (brief, other.replace(**kept), other)
    )
    np.testing.assert_array_equal(one, same)
    if method not in ("no_transfer", "full_transfer"):
        assert not np.array_equal(one, changed), "the other values change nothing, so the test shows nothing"


def test_the_page_tells_what_is_on_record() -> None:
    search = msgspec.convert(read_yaml(FIT), Search)
    named = [claim for half in search.halves for claim in half]
    assert sorted(named) == sorted({claim.id for claim in CLAIMS} - {*NOT_VARIED})
    page = (ROOT / "studies/fit/README.md").read_text()
    tried = pd.read_csv(ROOT / "reports/fit/tried.csv", keep_default_na=False)
    for row in tried[tried["stage"] == "final"].itertuples():
        assert f"| {row.reproduced} of {row.claims} | {row.parts_failing} | {row.changes} | {row.chosen_by} |" in page
    for row in pd.read_csv(ROOT / "reports/fit/halves.csv").itertuples():
        numbers = (row.reference_chosen_on, row.choice_chosen_on, row.reference_checked_on, row.choice_checked_on)
        assert f"| {' | '.join(f'{number} of 11' for number in numbers)} |" in page
