"""The search for a reading that fits: its rule, its stages, and what it keeps."""

from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml
from projects import ROOT

from ptl import claims
from ptl.claims.claim import Claim, Judgement
from ptl.claims.verdict import Outcome, Part, Verdict
from ptl.config import Parameters
from ptl.errors import UserError
from ptl.files.configuration import completed
from ptl.learning.lives import learn_lives
from ptl.measures.statistics import Estimate
from ptl.report.table import to_markdown
from ptl.world.drawing import chain_of_rooms, changed_world, corridor_with_rooms
from ptl.world.gridworld import GridWorld, load_map
from studies.fit.page import FINAL, SCREEN, claims_table, halves_table, setting_text, settings_table
from studies.fit.search import (
    IGNORED,
    Searcher,
    Setting,
    halves_frame,
    parts_frame,
    read_by,
    read_search,
    score,
    tried_frame,
)

ROOMS = "#########\n#I..#..A#\n#.......#\n#...#..B#\n#########\n"
WORLD = GridWorld.from_text(ROOMS, "rooms")


def judged(verdict: Verdict, *outcomes: Outcome) -> Judgement:
    parts = tuple(Part("x", Estimate(0, 0, 0), "", outcome) for outcome in outcomes)
    return Judgement(Claim("x", "", (), lambda evidence: iter(())), verdict, parts)


def test_the_rule_counts_claims_then_failing_parts_then_changes() -> None:
    fails, bound = Outcome.FAILS, Outcome.AT_BOUND
    changed, plain = Setting({"a": 1}, {"env1": {"start": [1, 1]}, "env2": {}}), Setting({}, {"env1": {}})
    good, poor = judged(Verdict.REPRODUCED), judged(Verdict.PARTLY, fails, bound)
    best_first = [
        score([good, good], changed).rank, score([good, judged(Verdict.PARTLY, bound)], plain).rank,
        score([good, poor], plain).rank, score([good, poor], changed).rank, score([poor, poor], plain).rank,
    ]  # fmt: skip
    assert all(one < other for one, other in pairwise(best_first))
    assert (changed.changes, plain.changes) == (2, 0)


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


# -- the published search


def test_the_published_search_names_every_claim_and_draws_maps_with_all_goals() -> None:
    search = read_search(ROOT / "config/fit.yaml")
    assert sum(map(len, search.halves)) == len(claims.CLAIMS) - 2
    for name, drawings in search.drawings.items():
        world = load_map(ROOT / search.reference.maps[name])
        drawn = [changed_world(world, drawing).text for drawing in drawings]
        assert len({world.text, *drawn}) == 1 + len(drawings)
        assert all("".join(changed_world(world, drawing).goals) == "ABCDEF" for drawing in drawings)


def test_first_reference_of_the_search_is_that_of_the_configuration() -> None:
    """config/first_reference.yaml and config/fit.yaml say the same of the first reference."""
    search = read_search(ROOT / "config/fit.yaml")
    path = ROOT / "config/first_reference.yaml"
    given = yaml.safe_load(path.read_text())
    base = yaml.safe_load((ROOT / "config/config.yaml").read_text())
    environments = {name: entry | given["environments"].get(name, {}) for name, entry in base["environments"].items()}
    assert {name: entry["map"] for name, entry in environments.items()} == search.reference.maps
    parameters = Parameters.from_dict({name: given[name] for name in Parameters.__struct_fields__ if name in given})
    for name, value in search.reference.learner.items():
        group, _, last = name.partition(".")
        assert getattr(getattr(parameters, group), last) == value


@pytest.mark.parametrize(
    ("change", "complaint"),
    [({"halves": [["E1-jump"], []]}, "must name each claim"),
     ({"learners": [{"skills.patience": 2.0}]}, "skills.patience")],
)  # fmt: skip
def test_a_search_that_cannot_be_told_is_refused(tmp_path: Path, change: dict, complaint: str) -> None:
    content = yaml.safe_load((ROOT / "config/fit.yaml").read_text())
    path = tmp_path / "fit.yaml"
    path.write_text(yaml.safe_dump(content | change))
    with pytest.raises(UserError, match=complaint):
        read_search(path)


def test_corridor_with_rooms_draws_what_its_parameters_say() -> None:
    world = GridWorld.from_text(corridor_with_rooms(3, 5, 1, (9, 6)), "drawn")
    assert world.n_states == 8 * (3 * 5 + 1) + 1 * (4 * 4 - 1) + 1 + 9 * 6
    lengths = [world.shortest_path_length(world.start, world.goal(letter)) for letter in "ABCD"]
    assert [later - sooner for sooner, later in pairwise(lengths)] == [4, 4, 4], "each door is a room further along"
    with pytest.raises(UserError, match="make no map"):
        corridor_with_rooms(1)


# -- a small search


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> tuple:
    """A search on two small maps, with its configuration and folder."""
    folder = tmp_path_factory.mktemp("fit")
    (folder / "rooms.txt").write_text(ROOMS)
    content = yaml.safe_load((ROOT / "config/fit.yaml").read_text())
    effort = {"seeds": 10, "growth_runs": 10, "resamples": 100}
    content |= {
        "screen": effort, "final": dict(effort), "probes": 1, "kept": 1, "finalists": 1,
        "drawings": {"env1": [{"start": [2, 1]}, {"start": [3, 1]}]},
        "learners": [{"skills.prior_width": 0.5}, {"policy_reuse.untaught": "first_action"}],
    }  # fmt: skip
    content["reference"]["maps"] = dict.fromkeys(("env1", "env2"), str(folder / "rooms.txt"))
    (folder / "fit.yaml").write_text(yaml.safe_dump(content))
    given = {
        "run": "x", "methods": ["no_transfer", "policy_reuse", "ptl"],
        "environments": {name: {"map": str(folder / "rooms.txt"), "tasks": "AB"} for name in ("env1", "env2")},
        "learning": {"episodes": 12}, "subgoals": {"trajectories": 5}, "growth": {"environment": "env2", "tasks": 8},
    }  # fmt: skip
    config = completed(given)
    searcher = Searcher(read_search(folder / "fit.yaml"), config, folder / "lives")
    return searcher.run(), config, folder


def test_every_stage_is_on_record(small: tuple) -> None:
    outcomes, _, _ = small
    frame = tried_frame(outcomes)
    assert list(dict.fromkeys(frame["stage"])) == ["probe", "drawings", "screen", "final", "final drawings"]
    probes = frame[frame["stage"] == "probe"]
    assert len(probes) == 3 + 1, "every drawing of either map"
    screened = set(frame.loc[frame["stage"] == "screen", "learner"])
    assert screened == {"{}", '{"skills.prior_width": 0.5}', '{"policy_reuse.untaught": "first_action"}'}
    finals = frame[frame["stage"] == "final"]
    assert (finals["changes"] == 0).sum() == 1, "the reference is decided too"
    assert ";".join(finals["chosen_by"]).count("all claims") == 1
    assert set(json.loads(finals["verdicts"].iloc[0])) == {id for half in read_halves(small) for id in half}
    assert set(parts_frame(outcomes)["outcome"]) <= {str(outcome) for outcome in Outcome}


def read_halves(small: tuple) -> list[list[str]]:
    return read_search(small[2] / "fit.yaml").halves


def test_the_choice_is_the_best_of_the_finals(small: tuple) -> None:
    outcomes, _, _ = small
    finals = [own for own in outcomes.tried if own.stage == "final"]
    assert outcomes.choice.score().rank == min(own.score().rank for own in finals)


def test_an_interrupted_search_goes_on_where_it_stopped(small: tuple) -> None:
    outcomes, config, folder = small
    before = {path: path.stat().st_mtime_ns for path in (folder / "lives").iterdir()}
    again = Searcher(read_search(folder / "fit.yaml"), config, folder / "lives").run()
    assert {path: path.stat().st_mtime_ns for path in (folder / "lives").iterdir()} == before
    assert tried_frame(again).equals(tried_frame(outcomes))


def test_finalists_have_other_random_numbers_than_the_screen(small: tuple) -> None:
    _, config, folder = small
    searcher = Searcher(read_search(folder / "fit.yaml"), config, folder / "lives")
    lives = [
        searcher._lives(stage, WORLD, "env1", "AB", "no_transfer", Parameters.from_dict({}), searcher.search.screen)
        for stage in ("probe", "screen", "final")
    ]
    np.testing.assert_array_equal(lives[0]["steps"], lives[1]["steps"])
    assert not np.array_equal(lives[0]["steps"], lives[2]["steps"])


def test_pages_describe_settings_in_words(small: tuple) -> None:
    outcomes, _, _ = small
    tried = tried_frame(outcomes)
    for stage in (FINAL, SCREEN):
        page = to_markdown(settings_table(tried, stage))
        assert "most claims reproduced, then fewest failing parts" in page
    halves = halves_frame(outcomes, read_halves(small))
    assert halves["half"].tolist() == ["first", "second"]
    assert (halves["claims_chosen_on"] + halves["claims_checked_on"]).tolist() == [22, 22]
    assert "had not seen" in to_markdown(halves_table(halves))
    claims = to_markdown(claims_table(tried, read_halves(small)))
    assert all(f"| {name} |" in claims for half in read_halves(small) for name in half)
    assert setting_text("{}", '{"env1": {}}') == "first reference"
    assert setting_text('{"a.b": 2}', '{"env1": {"chain": {"size": 3}}, "env3": {"start": [1, 2]}}').splitlines() == [
        "a.b = 2", "env1: chain, size 3", "env3: start [1, 2]",
    ]  # fmt: skip


def test_a_claim_is_checked_on_the_setting_that_it_did_not_choose() -> None:
    """Each verdict names its setting, so the table shows whose it took."""
    rows = [("reference", 0, "", "a"), ("both", 3, "all claims; second half", "b"), ("one", 2, "first half", "c")]
    tried = pd.DataFrame(
        {"stage": FINAL, "changes": changes, "chosen_by": chosen, "verdicts": json.dumps(dict.fromkeys("XY", verdict))}
        for _, changes, chosen, verdict in rows
    )
    page = to_markdown(claims_table(tried, [["X"], ["Y"]]))
    assert "| X | first | a | b | b |" in page
    assert "| Y | second | a | b | c |" in page
