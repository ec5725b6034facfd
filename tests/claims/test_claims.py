"""Claims: made-up runs in which each verdict comes out either way, the rule from parts to verdicts, and places."""

from __future__ import annotations

import copy
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from made_up_run import (
    BASE,
    ENVIRONMENTS,
    FULL,
    GROUPS,
    METHODS,
    PTL,
    REUSE,
    SUPERVISED,
    TASKS,
    UNKNOWN,
    VARIANTS,
    MadeUpRun,
)  # fmt: skip

from ptl import claims
from ptl.claims import places
from ptl.claims.evidence import Evidence, MissingEvidence, settings_of
from ptl.claims.evidence_files import read_evidence
from ptl.claims.reading import DEFAULT
from ptl.claims.verdict import Outcome, Part, Verdict, above, below, between, decide, not_significant
from ptl.errors import UserError
from ptl.measures import statistics
from ptl.measures.run_files import write_steps
from ptl.measures.statistics import Estimate
from ptl.world.gridworld import GridWorld

CLAIMS = {claim.id: claim for claim in claims.CLAIMS}


@pytest.fixture(scope="module", autouse=True)
def few_fits():
    """Let the claim on growth be judged by fewer fits, which take most of the time of all claims."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(statistics, "FITS", 30)
        yield


def concerned(id):
    """Environments that a claim needs."""
    single = {"E1": ("env1",), "E2": ("env2",), "E3": ("env3",)}
    return ENVIRONMENTS if id == "E2-size" else single.get(id[:2], ENVIRONMENTS)


def judgement(evidence, id):
    return CLAIMS[id].judge(evidence)


# -- made-up runs that contradict claims ---------------------------------------------------------------------


def subgoals_in_room_1(run):
    incremental, _ = run.peaks["env1"]
    run.peaks["env1"] = ([(3, 4)] * 6, incremental)


def harder_is_easier(run):
    for position, value in ((1, 1000), (3, 1.3)):
        run.change("env1", BASE, position, value)
    for level, task in enumerate(TASKS):
        run.curves["env1", BASE, task][1] -= 150 * level
        run.curves["env1", BASE, task][3] *= 8.0 / 2**level


def ptl_worse_in_env1(run):
    run.swap("env1", BASE, VARIANTS)


def ptl_worse_in_env2_but_unknown_goal_starts_better(run):
    run.swap("env2", BASE, VARIANTS)
    run.change("env2", UNKNOWN, 0, 10)


def converged_slowly_or_not(run):
    run.change("env2", (BASE, FULL, PTL), 2, 200)


def two_env1(run):
    run.worlds = {"env1": run.worlds["env2"], "env2": run.worlds["env1"], "env3": run.worlds["env3"]}
    run.peaks["env1"], run.peaks["env2"] = run.peaks["env2"], run.peaks["env1"]


def subgoals_in_the_corridor(run):
    run.peaks["env2"] = ([(6, 1)] * 6, run.peaks["env2"][1])


def subgoals_at_the_start(run):
    run.peaks["env3"] = ([(9, 14)] * 6, run.peaks["env3"][1])


def all_slow_but_no_transfer(run):
    run.change("env3", (FULL, REUSE, *VARIANTS), 2, 150)
    run.change("env3", BASE, 2, 3)


def calm_reuse(run):
    for environment in ENVIRONMENTS:
        run.change(environment, REUSE, 4, ())
        run.change(environment, BASE, 4, (170, 180))


def stagnant_then_growing(run):
    run.library_sizes = np.interp(np.arange(31), [0, 3, 7, 30], [0, 3, 3, 26])


def quadratic_selection(run):
    run.selection["operations"] = run.selection["skills"] ** 2


def overfull_library(run):
    run.library_bytes["bytes"] *= 2
    every = [*range(run.worlds["env2"].n_states), 0]
    run.more_subgoals = pd.DataFrame({"environment": "env2", "method": PTL, "seed": 0, "task": "Z", "subgoal": every})


CONTRARY = {
    "E1-subgoals": subgoals_in_room_1,
    "E1-frequencies": lambda run: run.selected.update(env1=run.at("env1", (3, 4), 60) + run.at("env1", (6, 11), 40)),
    "E1-order": harder_is_easier,
    "E1-all": ptl_worse_in_env1,
    "E1-jump": lambda run: run.change("env1", PTL, 0, lambda steps: 20 * steps),
    "E1-asymptotic": lambda run: run.change("env1", VARIANTS, 3, 3.0),
    "E1-80": lambda run: run.change("env1", PTL, 3, 1.9),
    "E1-total": lambda run: run.change("env1", PTL, 1, 10**6),
    "E1-unknown": lambda run: (run.change("env1", UNKNOWN, 1, 10**6), run.change("env1", PTL, 1, 10**7)),
    "E1-negative": lambda run: run.change("env1", FULL, 1, 200),
    "E2-size": two_env1,
    "E2-all": ptl_worse_in_env2_but_unknown_goal_starts_better,
    "E2-unknown": lambda run: run.change("env2", UNKNOWN, 0, 4000),
    "E2-converge": converged_slowly_or_not,
    "E2-positive": lambda run: run.change("env2", FULL, 1, 5000),
    "E2-subgoals": subgoals_in_the_corridor,
    "E3-jump": lambda run: run.change("env3", PTL, 0, 200),
    "E3-recovery": lambda run: (run.change("env3", PTL, 1, 600), run.change("env3", PTL, 2, 30)),
    "E3-threshold": lambda run: run.change("env3", PTL, 2, 100),
    "E3-ratio": lambda run: run.change("env3", PTL, 1, 10**5),
    "E3-few": all_slow_but_no_transfer,
    "E3-subgoals": subgoals_at_the_start,
    "curves": lambda run: [run.change(env, PTL, p, 10**6) for env in ENVIRONMENTS for p in (0, 1, 3)],
    "reuse-spikes": calm_reuse,
    "growth": stagnant_then_growing,
    "selection-cost": quadratic_selection,
    "space": overfull_library,
}


@pytest.fixture(scope="module")
def as_in_the_article():
    return MadeUpRun().evidence()


@pytest.fixture(scope="module")
def nine_seeds():
    return MadeUpRun().evidence(seeds=9)


@pytest.fixture(scope="module")
def verdicts(as_in_the_article):
    return {judged.claim.id: judged for judged in claims.judge(as_in_the_article)}


def test_claims_have_names_of_their_own():
    assert len(CLAIMS) == len(claims.CLAIMS)


@pytest.mark.parametrize("id", [id for id in CONTRARY if id != "E2-unknown"])
def test_reproduced_where_the_run_is_as_in_the_article(verdicts, id):
    assert verdicts[id].verdict is Verdict.REPRODUCED, list(map(str, verdicts[id].parts))


def test_fewer_steps_on_average_are_significant_in_the_limit():
    """With as many runs as there are, the article's two sentences on the goal unknown cannot both hold."""
    run = MadeUpRun()
    run.change("env2", UNKNOWN, 0, 2000)
    evidence = run.evidence(environments=("env2",))
    assert judgement(evidence, "E2-unknown").verdict is Verdict.REPRODUCED
    assert judgement(evidence, "E2-all").verdict is Verdict.PARTLY


@pytest.mark.parametrize("id", CONTRARY)
def test_not_reproduced_where_the_run_says_the_contrary(id):
    run = MadeUpRun()
    CONTRARY[id](run)
    judged = judgement(run.evidence(environments=concerned(id)), id)
    # skills are stored and the line has a bend there, too
    contrary = Verdict.PARTLY if id in ("E3-subgoals", "growth") else Verdict.NOT
    assert judged.verdict is contrary, (list(map(str, judged.parts)), judged.reason)


@pytest.mark.parametrize(
    ("id", "change"),
    [
        ("E1-total", lambda run: run.change("env1", PTL, 1, lambda steps: 8 * steps)),
        ("E1-jump", lambda run: run.change("env1", PTL, 0, lambda steps: 3 * steps)),
        ("E1-80", lambda run: run.change("env1", PTL, 2, 30)),
        ("E1-all", lambda run: run.change("env1", UNKNOWN, 0, 10**6, tasks="C")),
        ("E2-all", lambda run: run.change("env2", UNKNOWN, 0, 10, tasks="D")),
        ("E2-converge", lambda run: run.change("env2", FULL, 2, 20)),
        ("E3-threshold", lambda run: run.change("env3", PTL, 2, 25)),
        ("E3-ratio", lambda run: run.change("env3", PTL, 1, 4000)),
        ("E3-few", lambda run: run.change("env3", REUSE, 2, 50)),
        ("curves", lambda run: run.change("env2", PTL, 3, 1.25)),
    ],
)
def test_partly_reproduced_where_only_some_of_it_is_so(id, change):
    run = MadeUpRun()
    change(run)
    judged = judgement(run.evidence(environments=concerned(id)), id)
    assert judged.verdict is Verdict.PARTLY, (list(map(str, judged.parts)), judged.reason)
    assert {part.outcome for part in judged.parts} > {Outcome.HOLDS}


def test_not_improved_needs_more_than_lack_of_significance(as_in_the_article):
    noisy = as_in_the_article.per_seed.copy()
    rows = (noisy["environment"] == "env3") & (noisy["method"] == PTL)
    noisy.loc[rows, "first_episode"] = noisy.loc[rows, "seed"] % 4 * 1000
    noisy.loc[rows, "jump_start"] = 2000 - noisy.loc[rows, "first_episode"]
    judged = judgement(replace(as_in_the_article, per_seed=noisy), "E3-jump")
    assert [part.outcome for part in judged.parts] == [Outcome.HOLDS, Outcome.OPEN]
    assert judged.verdict is Verdict.PARTLY


# -- missing evidence ----------------------------------------------------------------------------------------

COUNTED = {"E1-frequencies", "E2-size", "selection-cost", "space"}
"""Claims that rest on no runs."""


@pytest.mark.parametrize("id", CONTRARY)
def test_too_few_seeds_decide_nothing(nine_seeds, id):
    judged = judgement(nine_seeds, id)
    if id in COUNTED:
        assert judged.verdict is Verdict.REPRODUCED
    else:
        assert judged.verdict is Verdict.UNDECIDED
        assert "9" in judged.reason
        assert "fewer than the 10" in judged.reason


@pytest.mark.parametrize("environment", ENVIRONMENTS)
def test_claims_on_an_environment_that_is_missing_are_undecided(environment):
    others = tuple(name for name in ENVIRONMENTS if name != environment)
    evidence = MadeUpRun().evidence(environments=others)
    for id in CONTRARY:
        if id.startswith(f"E{environment[-1]}"):
            judged = judgement(evidence, id)
            assert judged.verdict is Verdict.UNDECIDED
            assert judged.reason == f"environment {environment} is not in this run"


def test_files_that_are_missing_make_undecided(as_in_the_article):
    bare = Evidence(per_seed=as_in_the_article.per_seed, worlds=as_in_the_article.worlds, **settings_of(GROUPS))
    reasons = {judged.claim.id: judged.reason for judged in claims.judge(bare)}
    assert reasons["growth"] == "growth: not in this run"
    assert reasons["selection-cost"] == "selection cost: not in this run"
    assert reasons["E1-subgoals"] == "subgoals: not in this run"
    assert reasons["curves"].startswith("env1: steps per episode of ptl, task F")
    assert reasons["E1-all"] == ""


def test_too_short_lives_do_not_show_the_growth(as_in_the_article):
    judged = judgement(replace(as_in_the_article, growth=as_in_the_article.growth[:, :10]), "growth")
    assert judged.verdict is Verdict.UNDECIDED
    assert "9 tasks" in judged.reason


@pytest.mark.parametrize(
    ("method", "concerned"),
    [
        (
            FULL,
            {"E1-asymptotic", "E1-unknown", "E1-negative", "E2-converge", "E2-positive", "E3-few", "curves"},
        ),
        (REUSE, {"E1-unknown", "E3-few", "curves", "reuse-spikes"}),
        (SUPERVISED, {"E1-all", "E1-asymptotic", "E2-all", "E3-few"}),
        (UNKNOWN, {"E1-all", "E1-asymptotic", "E1-unknown", "E2-all", "E2-unknown", "E3-few"}),
    ],
)
def test_a_method_counts_only_in_claims_about_it(verdicts, method, concerned):
    left = tuple(name for name in METHODS if name != method)
    for judged in claims.judge(MadeUpRun().evidence(methods=left)):
        before = verdicts[judged.claim.id]
        if judged.claim.id in concerned:
            assert judged.verdict is Verdict.UNDECIDED
            assert f"method {method} is not in this run" in judged.reason
        else:
            assert (judged.verdict, judged.parts) == (before.verdict, before.parts)


def test_a_foreign_method_moves_nothing(as_in_the_article, verdicts):
    foreign = as_in_the_article.per_seed.query("method == 'ptl'").assign(method="another", total_steps=1)
    more = pd.concat([foreign, as_in_the_article.per_seed], ignore_index=True)
    for judged in claims.judge(replace(as_in_the_article, per_seed=more)):
        assert judged == verdicts[judged.claim.id]


def test_a_claim_needs_its_base():
    evidence = MadeUpRun().evidence(methods=(FULL, *VARIANTS))
    judged = judgement(evidence, "E1-negative")
    assert judged.verdict is Verdict.UNDECIDED
    assert "no_transfer" in judged.reason


def test_methods_are_paired_by_seed(as_in_the_article, verdicts):
    shuffled = as_in_the_article.per_seed.sample(frac=1, random_state=1)
    for id in ("E1-order", "E1-total", "E1-unknown", "E2-converge", "E3-ratio"):
        assert judgement(replace(as_in_the_article, per_seed=shuffled), id) == verdicts[id]


# -- settings of the configuration ----------------------------------------------------------------------------


def with_settings(group, **keys):
    groups = copy.deepcopy(GROUPS)
    vars(groups)[group].__dict__.update(keys)
    return groups


def test_the_bend_of_the_growth_is_that_of_the_configuration(as_in_the_article):
    run = MadeUpRun()
    run.library_sizes = np.interp(np.arange(31), [0, 5, 30], [0, 3.5, 6])
    slopes = {
        bend: judgement(run.evidence(groups=with_settings("growth", breakpoint=bend)), "growth").parts[1]
        for bend in (5, 10)
    }
    assert slopes[5].estimate.value == pytest.approx(0.1 / 0.7, rel=0.01)  # sizes are whole
    assert slopes[10].estimate.value > 1.1 * slopes[5].estimate.value
    assert [part.outcome for part in slopes.values()] == [Outcome.HOLDS, Outcome.HOLDS]
    assert "after 5 tasks" in slopes[5].text


@pytest.mark.parametrize("bend", [1, 16])
def test_a_bend_that_leaves_nothing_to_compare_is_undecided(bend):
    judged = judgement(MadeUpRun().evidence(groups=with_settings("growth", breakpoint=bend)), "growth")
    assert judged.verdict is Verdict.UNDECIDED
    assert f"after {bend} (growth.breakpoint)" in judged.reason


@pytest.mark.parametrize(("window", "blocks"), [(10, 20), (50, 4), (150, 1)])
def test_curves_are_compared_in_blocks_of_the_window(window, blocks):
    judged = judgement(MadeUpRun().evidence(groups=with_settings("measures", window=window)), "curves")
    assert len(judged.parts) == 2 * 3 * blocks
    assert f"episodes 1-{window}" in judged.parts[0].text


def test_a_window_of_all_episodes_has_no_episode_to_be_a_spike():
    judged = judgement(MadeUpRun().evidence(groups=with_settings("measures", window=200)), "reuse-spikes")
    assert judged.verdict is Verdict.UNDECIDED
    assert "no episode comes after the first 200" in judged.reason


def test_a_higher_confidence_widens_every_interval(as_in_the_article):
    wide = MadeUpRun().evidence(groups=with_settings("statistics", confidence=0.999))
    for id in ("E1-jump", "growth", "E2-converge"):
        for one, other in zip(judgement(as_in_the_article, id).parts, judgement(wide, id).parts, strict=True):
            assert other.estimate.high - other.estimate.low >= one.estimate.high - one.estimate.low


# -- the rule ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("low", "high", "expected"),
    [(1, 2, Outcome.HOLDS), (-2, -1, Outcome.FAILS), (-1, 1, Outcome.OPEN), (0, 1, Outcome.OPEN),
     (-1, 0, Outcome.FAILS), (0, 0, Outcome.FAILS), (np.nan, np.nan, Outcome.OPEN)],
)  # fmt: skip
def test_a_part_is_judged_by_its_whole_interval(low, high, expected):
    estimate = Estimate((low + high) / 2, low, high)
    mirrored = Estimate(-estimate.value, -high, -low)
    assert above("x", estimate, 0).outcome is expected
    assert below("x", mirrored, 0).outcome is expected
    assert between("x", estimate, 0, 5).outcome is expected


@pytest.mark.parametrize(
    ("low", "high", "bound", "scale", "expected"),
    [(9, 11, 10, 1, Outcome.AT_BOUND), (8, 12, 10, 1, Outcome.AT_BOUND), (7.9, 11, 10, 1, Outcome.OPEN),
     (9, 12.1, 10, 1, Outcome.OPEN), (-2, 2, 0, 10, Outcome.AT_BOUND), (-2.1, 2, 0, 10, Outcome.OPEN),
     (-0.1, 0.2, 0, 1, Outcome.AT_BOUND), (0.1, 0.2, 0, 100, Outcome.HOLDS), (-2, -1, 0, 100, Outcome.FAILS)],
)  # fmt: skip
def test_a_value_within_a_fifth_of_the_bound_is_called_at_the_bound(low, high, bound, scale, expected):
    estimate = Estimate((low + high) / 2, low, high)
    assert above("x", estimate, bound, scale=scale).outcome is expected
    assert below("x", Estimate(-estimate.value, -high, -low), -bound, scale=scale).outcome is expected


def test_either_end_of_a_range_is_a_bound():
    assert between("x", Estimate(80, 76, 84), 80, 95).outcome is Outcome.AT_BOUND
    assert between("x", Estimate(95, 90, 99), 80, 95).outcome is Outcome.AT_BOUND
    assert between("x", Estimate(80, 60, 100), 80, 95).outcome is Outcome.OPEN


def test_a_part_that_denies_significance_fails_only_beyond_doubt():
    assert not_significant("x", Estimate(1, -1, 3)).outcome is Outcome.HOLDS
    assert not_significant("x", Estimate(-2, -3, -1)).outcome is Outcome.HOLDS
    assert not_significant("x", Estimate(2, 1, 3)).outcome is Outcome.FAILS
    assert not_significant("x", Estimate(2, np.nan, np.nan)).outcome is Outcome.OPEN


@pytest.mark.parametrize(
    ("outcomes", "verdict"),
    [("hh", Verdict.REPRODUCED), ("hf", Verdict.PARTLY), ("ho", Verdict.PARTLY), ("hfo", Verdict.PARTLY),
     ("hb", Verdict.PARTLY), ("b", Verdict.NOT), ("bo", Verdict.NOT),
     ("ff", Verdict.NOT), ("fo", Verdict.NOT), ("oo", Verdict.UNDECIDED), ("", Verdict.UNDECIDED)],
)  # fmt: skip
def test_the_rule_from_parts_to_a_verdict(outcomes, verdict):
    kinds = {"h": Outcome.HOLDS, "f": Outcome.FAILS, "b": Outcome.AT_BOUND, "o": Outcome.OPEN}
    parts = [Part("x", Estimate(0, 0, 0), "", kinds[letter]) for letter in outcomes]
    assert decide(parts) is verdict


# -- places --------------------------------------------------------------------------------------------------


def cells(world, states):
    return sorted(map(tuple, world.cells[np.asarray(states)].tolist()))


def test_doorways_of_the_maps(env1, env2):
    assert cells(env1, places.doorways(env1)) == [(6, 11 * level) for level in range(1, 7)]
    small = [(row, column) for row in (4, 7) for column in (2, 7, 12, 17)]
    assert cells(env2, places.doorways(env2)) == sorted([*small, (5, 20)])


def test_newest_doorway_is_the_last_on_the_way(env1):
    for level, task in enumerate(TASKS, start=1):
        newest = places.newest_doorway(env1, env1.goal(task))
        assert env1.cells[newest].tolist() == [6, 11 * level]


def test_rooms_and_their_doors(env2):
    room = places.rooms(env2)
    assert room.max() == 9
    assert np.count_nonzero(room == -1) == 9
    assert sorted(np.bincount(room[room >= 0]).tolist()) == [12] * 8 + [38, 100]
    for task, door in zip("ABCDE", [(4, 2), (7, 7), (4, 12), (7, 17), (5, 20)], strict=True):
        assert cells(env2, places.doors_of(env2, room[env2.goal(task)])) == [door]


def test_one_step_from_a_doorway_counts_as_on_it(env1):
    near = np.flatnonzero(places.near(env1, places.doorways(env1), DEFAULT.tolerance))
    assert cells(env1, near) == [(6, 11 * level + step) for level in range(1, 7) for step in (-1, 0, 1)]


def test_places_of_another_map_are_refused(env1):
    with pytest.raises(MissingEvidence, match="21 by 24"):
        places.rectangle(env1, (1, 2), (1, 2), (21, 24))
    with pytest.raises(MissingEvidence, match="no doorway"):
        places.doorways(GridWorld.from_text("I.A\n...\n"))


def test_the_regions_of_env3_are_what_they_are_called(env3):
    corridor, room, inner = (
        places.rectangle(env3, *where, claims.env3.MAP_SHAPE)
        for where in (claims.env3.LOWER_CORRIDOR, claims.env3.ROOM, claims.env3.INNER_HALF)
    )
    assert corridor.sum() == 44
    assert all(room[env3.goal(letter)] for letter in "AEF")
    assert [bool(inner[env3.goal(letter)]) for letter in "AEF"] == [False, True, True]
    doors = np.flatnonzero(~room & room[env3.successors].any(axis=1))
    assert cells(env3, doors) == [(4, 13)]


# -- from files ----------------------------------------------------------------------------------------------


@pytest.fixture
def files(tmp_path, as_in_the_article):
    evidence = as_in_the_article
    runs, points = evidence.growth.shape
    frames = {
        "per_seed": evidence.per_seed,
        "subgoals": evidence.subgoals,
        "growth": pd.DataFrame(
            {"run": np.repeat(range(runs), points), "tasks": np.tile(range(points), runs),
             "library_size": evidence.growth.ravel()}
        ),
        "selection_cost": evidence.selection_cost,
        "library_bytes": evidence.library_bytes,
    }  # fmt: skip
    paths = {name: tmp_path / f"{name}.csv" for name in frames}
    for name, frame in frames.items():
        frame.to_csv(paths[name], index=False)
    paths["steps"] = tmp_path / "steps.h5"
    write_steps(paths["steps"], evidence.steps)
    survey = [
        SimpleNamespace(job=SimpleNamespace(environment=name), arrays={"counts": counts})
        for name, counts in evidence.frequencies.items()
    ]
    return {**paths, "survey": survey}


def test_files_give_the_verdicts_of_the_run_in_memory(files, as_in_the_article, verdicts):
    for judged in claims.judge(read_evidence(as_in_the_article.worlds, GROUPS, **files)):
        expected = verdicts[judged.claim.id]
        assert judged.verdict is expected.verdict
        assert [part.text for part in judged.parts] == [part.text for part in expected.parts]
        for part, other in zip(judged.parts, expected.parts, strict=True):
            assert part.estimate.value == pytest.approx(other.estimate.value)


def test_editing_the_data_flips_the_verdict(files, as_in_the_article, verdicts):
    table = pd.read_csv(files["per_seed"])
    rows = table.query("environment == 'env1' and task == 'F' and method == 'full_transfer'").index
    table.loc[rows, "transfer_ratio"] = table.loc[rows, "transfer_ratio"].abs().clip(upper=1)
    table.to_csv(files["per_seed"], index=False)
    judged = claims.judge(read_evidence(as_in_the_article.worlds, GROUPS, **files))
    changed = {j.claim.id: j.verdict for j in judged if j.verdict is not verdicts[j.claim.id].verdict}
    assert changed == {"E1-negative": Verdict.NOT}


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda files: files["subgoals"].write_text("environment\n1\n"), "no column 'method'"),
        (lambda files: files["growth"].unlink(), "cannot be read as CSV"),
        (lambda files: files["steps"].write_text("no"), "no result file of this version"),
        (lambda files: files["per_seed"].write_text("environment,seed\nenv1,1\n"), "no column"),
    ],
)
def test_damaged_files_are_named(files, spoil, message, as_in_the_article):
    spoil(files)
    with pytest.raises(UserError, match=message):
        read_evidence(as_in_the_article.worlds, GROUPS, **files)


def test_made_up_runs_do_not_share_state():
    run = MadeUpRun()
    before = copy.deepcopy(run.curves)
    other = MadeUpRun()
    other.change("env1", PTL, 0, 1)
    assert run.curves == before
