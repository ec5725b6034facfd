"""The multiverse: its draws, one setting from learning to verdicts, and the summaries of all settings."""

from __future__ import annotations

import shutil
from pathlib import Path

import msgspec
import numpy as np
import pandas as pd
import pytest
import yaml
from projects import ROOT, Project, errors_of

from ptl.claims.degrees import SOME
from ptl.claims.reading import DEFAULT, LAST_TASK, TRANSFER_TASKS
from ptl.config import Configuration, Parameters
from ptl.errors import UserError
from ptl.files import store
from ptl.files.configuration import completed
from ptl.files.csv import read_csv, write_csv
from ptl.learning.life import learn_life, tasks_of
from ptl.measures.measures import measure, runs_of
from ptl.world.drawing import chain_of_rooms
from ptl.world.gridworld import GridWorld, map_digest
from ptl.world.map_files import load_map
from studies.multiverse import adoption, compatibility, curves, page, shares
from studies.multiverse.design import Multiverse, Point, drawings_of, parameters_of, read_study
from studies.multiverse.jobs import Block, block_jobs, cost_of
from studies.multiverse.judging import (
    ESTIMATE_COLUMNS,
    JUDGED,
    VERDICT_COLUMNS,
    Setting,
    estimate_rows,
    replicated,
    settings_in,
    verdict_rows,
)
from studies.multiverse.learning import COMPLETE, MEASURED, STREAM, learn_point, worlds_of

STUDY_FILE = ROOT / "studies/multiverse/config/multiverse.yaml"


@pytest.fixture(scope="module")
def run() -> Configuration:
    """The completed configuration of the published run, with paths that hold in every folder."""
    given = yaml.safe_load((ROOT / "config/config.yaml").read_text())
    for entry in given["environments"].values():
        entry["map"] = str(ROOT / entry["map"])
    return completed(given)


@pytest.fixture(scope="module")
def study() -> Multiverse:
    return read_study(STUDY_FILE)


@pytest.fixture(scope="module")
def worlds(run: Configuration, study: Multiverse) -> dict[str, GridWorld]:
    maps = {name: entry.map for name, entry in run.environments.items()}
    return {name: load_map(path) for name, path in maps.items()} | {
        name: load_map(ROOT / path) for name, path in study.maps.items()
    }


@pytest.fixture(scope="module")
def digests(worlds: dict[str, GridWorld]) -> dict[str, str]:
    return {name: map_digest(world.text) for name, world in worlds.items()}


# -- design ------------------------------------------------------------------------------------------------------


def test_every_unknown_says_why_and_covers_its_range(study: Multiverse) -> None:
    points = [point for point in study.points() if point.name not in study.named]
    assert len(points) == study.settings
    for name, unknown in study.unknowns.items():
        assert len(unknown.reason) > 10
        values = [point.changes[name] for point in points]
        if unknown.options:
            counts = [sum(value == option for value in values) for option in unknown.options]
            assert min(counts) > 0.8 * len(points) / len(counts)
        else:
            low, high = unknown.range
            assert low <= min(values) < max(values) <= high
            assert min(values) < low + 0.05 * (high - low)
            assert max(values) > high - 0.05 * (high - low)


def test_every_key_that_the_reference_chose_is_drawn_or_named(study: Multiverse) -> None:
    groups = {"learning", "skills", "subgoals", "policy_reuse", "full_transfer"}
    keys = {f"{group}.{key}" for group in groups for key in getattr(Parameters(), group).to_dict()}
    # if ties go to the first action, a first episode takes 10^9 steps and more with the reference's epsilon
    assert keys - set(study.unknowns) == {"policy_reuse.psi", "policy_reuse.temperature", "learning.ties"}


def test_a_change_of_a_drawing_goes_to_its_map_and_the_rest_to_the_parameters() -> None:
    changes = {"env1.chain.size": 8, "env1.chain.door": 0.5, "env3.start": [8, 8], "learning.alpha": 0.5}
    assert drawings_of(changes) == {"env1": {"chain": {"size": 8, "door": 0.5}}, "env3": {"start": [8, 8]}}
    assert parameters_of(changes, Parameters()) == Parameters().replace(learning__alpha=0.5)


def test_a_named_setting_may_have_another_map(worlds: dict[str, GridWorld]) -> None:
    point = Point("fitted", {}, {}, maps={"env1": "fitted_env1"})
    own = worlds_of(point, worlds, ["env1", "env2"])
    assert own["env1"].text == worlds["fitted_env1"].text
    assert own["env2"].text == worlds["env2"].text
    drawn = worlds_of(Point("drawn", {"env1.chain.size": 7}, {}), worlds, ["env1"])
    assert drawn["env1"].text == chain_of_rooms(7)


def test_a_slip_of_every_environment_is_that_of_drawn_maps_too(worlds: dict[str, GridWorld]) -> None:
    point = Point("slips", {"env1.chain.size": 7, "environments.slip": 0.1, "env3.start": [8, 8]}, {})
    own = worlds_of(point, worlds, ["env1", "env2", "env3"])
    assert [world.slip for world in own.values()] == [0.1] * 3
    assert own["env1"].text == chain_of_rooms(7)
    assert own["env3"].cells[own["env3"].start].tolist() == [8, 8]


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"settings": 0}, "settings"),
        ({"unknowns": {"learning.alpha": {"symbol": "a", "reason": "r"}}}, "range"),
        ({"unknowns": {"learning.alpha": {"symbol": "a", "reason": "r", "range": [0.5, 2.0]}}}, "learning.alpha"),
        ({"unknowns": {"learning.alpha": {"symbol": "a", "reason": "r", "range": [0.5, 0.1]}}}, "the lower first"),
        ({"unknowns": {"learning.beta": {"symbol": "a", "reason": "r", "range": [0.1, 0.5]}}}, "beta"),
        ({"unknowns": {"env1.colour": {"symbol": "a", "reason": "r", "options": [1]}}}, "neither a key"),
        ({"named": {}}, "reference"),
    ],
)
def test_a_wrong_study_is_refused_in_one_line(tmp_path, changes, says) -> None:
    content = yaml.safe_load(STUDY_FILE.read_text())
    path = tmp_path / "study.yaml"
    path.write_text(yaml.safe_dump({**content, **changes}))
    with pytest.raises(UserError, match=says) as error:
        read_study(path)
    assert "\n" not in str(error.value)


# -- jobs --------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def small(study: Multiverse) -> Multiverse:
    """The study with two settings and few runs."""
    methods = {name: msgspec.structs.replace(effort, seeds=10, every=1) for name, effort in study.methods.items()}
    fast = {"no_transfer", "ptl", "ptl_unknown_goal", "ptl_supervised"}
    return msgspec.structs.replace(
        study,
        settings=2,
        block=2,
        methods={name: own for name, own in methods.items() if name in fast},
        named={"reference": msgspec.structs.replace(study.named["reference"], seeds=10)},
        growth=msgspec.structs.replace(study.growth, runs=10, tasks=14, every=1),
    )


@pytest.fixture(scope="module")
def short(run: Configuration) -> Configuration:
    """The run with short tasks."""
    return run.replace(learning__episodes=30)


@pytest.fixture(scope="module")
def reference(small, short, digests, worlds, tmp_path_factory) -> Setting:
    """The reference, learned, written and read again."""
    job = next(iter(block_jobs(small, short, digests).values()))
    own = {name: worlds[name] for name in job.maps}
    path = tmp_path_factory.mktemp("block") / "block.h5"
    store.write(path, job, job.run(own), own)
    [setting] = settings_in(store.read(path, job), short)
    return setting


def test_blocks_hold_all_settings_once(study, run, digests, worlds) -> None:
    jobs = block_jobs(study, run, digests)
    names = [point.name for job in jobs.values() for point in job.points]
    assert len(names) == len(set(names)) == study.settings + len(study.named)
    assert cost_of(jobs.values(), worlds).steps > 0
    assert {job.place for job in jobs.values()} == set(jobs)
    assert all(job.code == job.sources() for job in jobs.values()), "or a check of results calls them outdated"


def test_a_block_survives_its_text(small, short, digests) -> None:
    for job in block_jobs(small, short, digests).values():
        assert msgspec.json.decode(job.text, type=Block) == job


def test_the_measures_of_a_file_are_those_of_the_package(reference: Setting, short: Configuration) -> None:
    world = reference.worlds["env2"]
    tasks = tasks_of(world, "ABCDEF")
    names = (STREAM, "reference", "env2")
    lives = [learn_life(world, tasks, "ptl", short, short.root_seed, *names, seed) for seed in range(10)]
    steps = np.array([[record.steps for record in life.records] for life in lives])
    arrays = {"seeds": np.arange(10), "steps": steps, "truncated": np.zeros(steps.shape[:2], dtype=int)}
    runs = runs_of("env2", "ptl", "ABCDEF", arrays)
    table = measure(runs, {"env2": world}, short.measures.window, short.measures.threshold_factor).per_seed
    evidence = reference.evidence()
    for metric in ("first_episode", "asymptotic", "threshold_episode", "total_steps"):
        for task, part in table.groupby("task"):
            expected = part[metric].to_numpy(dtype=float, na_value=np.nan)
            np.testing.assert_allclose(evidence.values("env2", task, "ptl", metric), expected)


def test_a_setting_that_fails_is_recorded(worlds, short) -> None:
    point = Point("bad", {"env3.start": [0, 0]}, {"ptl": 1})
    arrays = learn_point(point, worlds, {"env3": "AB"}, short, short.measures, 1, 10**9, ("env3", 3))
    assert arrays["status"].item().decode().startswith("failed: UserError: ")


def test_a_method_beyond_its_budget_begins_no_further_run(worlds, short) -> None:
    point = Point("cheap", {}, {"no_transfer": 3})
    arrays = learn_point(point, worlds, {"env2": "AB"}, short, short.measures, 1, 1, ("env3", 3))
    assert arrays["env2/no_transfer/measured"].shape == (len(MEASURED), 1, 2)
    assert "given up after 1 of 3 seeds" in arrays["status"].item().decode()


def test_damage_of_a_block_is_found(reference, small, short, digests, worlds) -> None:
    job = next(iter(block_jobs(small, short, digests).values()))
    own = {name: worlds[name] for name in job.maps}
    whole = {f"reference/{name}": values for name, values in reference.arrays.items()}
    assert list(job.faults(whole, own)) == []
    place = "reference/env1/ptl/measured"
    lost = {name: values for name, values in whole.items() if name != place}
    assert any("missing" in fault for fault in job.faults(lost, own))
    wrong = whole[place].copy()
    wrong[0] = 1
    assert any("shorter than the shortest path" in fault for fault in job.faults({**whole, place: wrong}, own))
    far = whole["reference/env1/ptl/subgoals"].copy()
    far[0, 0, 0] = 10**6
    assert any("not in its map" in fault for fault in job.faults({**whole, "reference/env1/ptl/subgoals": far}, own))


# -- judging -----------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def verdicts(reference: Setting) -> pd.DataFrame:
    return pd.DataFrame(verdict_rows("reference", reference.evidence()), columns=list(VERDICT_COLUMNS))


def test_every_claim_is_judged_under_all_its_readings(reference: Setting, verdicts: pd.DataFrame) -> None:
    assert reference.status == COMPLETE
    strict = verdicts[verdicts["words"] == "strict"]
    for claim in JUDGED:
        own = strict[strict["claim"] == claim.id]
        assert len(own) == len(list(claim.readings()))
    lacking = set(strict.loc[strict["holds"].isna(), "claim"])
    assert lacking == {"E1-negative", "E1-asymptotic", "E1-unknown", "E2-converge", "E2-positive", "E3-few"}


def test_a_verdict_by_points_is_the_sign_of_the_estimate(reference: Setting, verdicts: pd.DataFrame) -> None:
    evidence = reference.evidence()
    for tasks in ("B", LAST_TASK, TRANSFER_TASKS):
        ratio = evidence.values("env3", tasks, "ptl", "transfer_ratio").mean()
        own = verdicts[(verdicts["claim"] == "E3-ratio") & (verdicts["tasks"] == tasks)]
        assert own["holds"].item() == float(ratio > 0.5)


def test_estimates_are_means_over_runs(reference: Setting) -> None:
    evidence = reference.evidence()
    frame = pd.DataFrame(estimate_rows("reference", evidence), columns=list(ESTIMATE_COLUMNS))
    own = frame.query("environment == 'env1' and tasks == 'BCDEF' and method == 'ptl' and measure == 'total_steps'")
    values = np.sum([evidence.values("env1", task, "ptl", "total_steps") for task in "BCDEF"], axis=0)
    assert own["mean"].item() == pytest.approx(values.mean())
    assert own["sd"].item() == pytest.approx(values.std(ddof=1))


def test_replicates_of_equal_runs_agree_with_the_setting(reference: Setting, verdicts: pd.DataFrame) -> None:
    """Where all runs are the same one, samples of 30 are the setting itself."""
    same = {
        name: values[:, :1].repeat(10, axis=1) if "/" in name else values for name, values in reference.arrays.items()
    }
    same["growth"] = same["growth"][:1].repeat(10, axis=0)
    setting = Setting(reference.point, same, reference.worlds, reference.tasks, reference.run)
    frame = pd.DataFrame(verdict_rows("x", setting.evidence()), columns=list(VERDICT_COLUMNS))
    printed = replicated(setting, 2, np.random.default_rng(1))
    merged = frame.merge(printed, on=shares.KEYS)
    assert len(merged) == len(frame)
    np.testing.assert_array_equal(merged["holds"], merged["printed"])


# -- summaries ---------------------------------------------------------------------------------------------------


def cloud(held: dict[str, list[float]]) -> pd.DataFrame:
    """Return verdict rows of made-up settings; all readings of a claim have the same outcome."""
    rows = []
    for claim in JUDGED:
        values = held.get(claim.id, [0.0] * len(next(iter(held.values()))))
        for number, value in enumerate(values):
            for reading in claim.readings():
                runs = "limit" if reading.runs is None else str(reading.runs)
                rows.append(
                    (
                        f"setting_{number:04d}",
                        claim.id,
                        "strict",
                        reading.tasks,
                        reading.tolerance,
                        runs,
                        value,
                        1,
                        value,
                    )
                )
    return pd.DataFrame(rows, columns=list(VERDICT_COLUMNS))


def test_shares_are_counts_with_wilson_intervals() -> None:
    table = shares.share_table(cloud({"E1-jump": [1, 1, 0, np.nan]}), 0.95)
    own = table[(table["claim"] == "E1-jump") & (table["tasks"] == "F")].iloc[0]
    assert own["settings"] == 3
    assert own["share"] == pytest.approx(2 / 3)
    # Wilson's interval of 2 of 3 by hand: (0.2077, 0.9385)
    assert (own["low"], own["high"]) == (pytest.approx(0.2077, abs=1e-4), pytest.approx(0.9385, abs=1e-4))


@pytest.mark.parametrize("number", [3, 7, 97, 100, 600, 24.5])
def test_a_share_is_in_its_interval(number: float) -> None:
    for count in (0.0, number / 3, number):
        share, low, high = shares._wilson(count, number, 0.95)
        assert 0 <= low <= share <= high <= 1


def test_the_best_quarter_shares_ties() -> None:
    weights = shares.best_weights(pd.Series([3, 2, 2, 2, 1, 0, 0, 0]))
    np.testing.assert_allclose(weights, [1, 1 / 3, 1 / 3, 1 / 3, 0, 0, 0, 0])


def test_a_claim_that_goes_with_the_others_holds_more_often_given_them() -> None:
    with_others = {claim.id: [1.0] * 5 + [0.0] * 15 for claim in JUDGED}
    with_others["E3-jump"] = [0.0] * 5 + [1.0] * 15
    table = shares.given_others(shares.held(cloud(with_others), LAST_TASK), 0.95)
    assert table.loc["E1-jump", "given_others"] == 1
    assert table.loc["E3-jump", "given_others"] == 0


def test_claims_that_exclude_each_other_are_named() -> None:
    half = {"E3-jump": [1.0, 0.0] * 40, "E3-ratio": [0.0, 1.0] * 40, "E1-order": [1.0] * 80}
    pairs = compatibility.pair_table(compatibility.tables(cloud(half)))
    found = list(compatibility.sentences(pairs))
    assert len(found) == 2
    assert "E3-jump and E3-ratio, both read on task F: together in 0 of 80 settings" in found[0]
    row = pairs[(pairs["read"] == "F") & (pairs["first"] == "E3-jump") & (pairs["second"] == "E3-ratio")].iloc[0]
    assert (row["together"], row["expected"]) == (0, 0.25)


def test_independent_claims_are_not_named() -> None:
    random = np.random.default_rng(1)
    free = {claim.id: random.integers(0, 2, 200).astype(float).tolist() for claim in JUDGED}
    found = list(compatibility.sentences(compatibility.pair_table(compatibility.tables(cloud(free)))))
    assert found == [
        "With claims read on task F, no two claims that hold at times exclude each other.",
        "With claims read on B to F together, no two claims that hold at times exclude each other.",
    ]


def test_scores_rank_a_named_setting_among_the_drawn_ones() -> None:
    frame = cloud({claim.id: [1.0, 0.0, 0.0, 0.0] for claim in JUDGED})
    named = frame[frame["setting"] == "setting_0000"].assign(setting="reference")
    scores = compatibility.score_table(pd.concat([frame, named])).set_index("setting")
    assert scores.loc["reference", "held_F"] == len(JUDGED)
    assert scores.loc["reference", "rank_F"] == 3 / 4 + 1 / 8


def test_the_rule_adopts_the_highest_share_and_of_equals_the_first() -> None:
    ids = list(adoption.ABOUT_PTL)
    frame = cloud({claim: [1.0] * 20 + [0.0] * 20 + [1.0] * 20 for claim in ids})
    changes = {f"setting_{n:04d}": {adoption.UNKNOWN: "abc"[n // 20]} for n in range(60)}
    ways = adoption.way_table(frame, changes)
    assert ways.set_index("way")["mean"].to_dict() == {"a": 1.0, "b": 0.0, "c": 1.0}
    # ways without any error are told apart only if their means differ
    assert adoption.adopted(ways, ["c", "b", "a"]) == ("a", ["a"])
    blurred = ways.assign(error=0.1)
    assert adoption.adopted(blurred, ["c", "b", "a"]) == ("c", ["c", "a"])


def test_the_intervals_of_savings_are_those_of_a_ratio_of_means() -> None:
    random = np.random.default_rng(3)
    own, base = random.normal(50, 10, 40), random.normal(100, 20, 40)
    rows = [
        ("setting_0000", "env1", "F", method, "total_steps", values.mean(), values.std(ddof=1), 40)
        for method, values in (("ptl", own), ("no_transfer", base))
    ]
    frame = pd.DataFrame(rows, columns=list(ESTIMATE_COLUMNS))
    more = frame.assign(measure="first_episode")
    times = frame.assign(measure="threshold_episode")
    found = curves.curve_frame(pd.concat([frame, more, times])).set_index("headline").loc["transfer_ratio"]
    assert found["value"] == pytest.approx(100 * (1 - own.mean() / base.mean()))
    draws = 1 - random.choice(own, (4000, 40)).mean(axis=1) / random.choice(base, (4000, 40)).mean(axis=1)
    assert found["high"] - found["low"] == pytest.approx(2 * 1.96 * 100 * draws.std(), rel=0.1)


def test_drawings_of_other_maps_are_not_associated(study: Multiverse) -> None:
    points = [point for point in study.points() if point.name not in study.named][:30]
    changes = {point.name: point.changes for point in points}
    frame = pd.DataFrame(
        [(name, "env1", "F", "jump_start", own["learning.alpha"]) for name, own in changes.items()],
        columns=["setting", "environment", "tasks", "headline", "value"],
    )
    table = curves.association_table(frame, changes, study.unknowns)
    assert table.iloc[0]["unknown"] == "learning.alpha"
    assert table.iloc[0]["association"] == pytest.approx(1)
    assert not table["unknown"].str.startswith(("env2.", "env3.")).any()
    assert "environments.slip" in set(table["unknown"])


def test_levels_are_values_or_thirds(study: Multiverse) -> None:
    width = study.unknowns["env2.corridor.corridor"]
    assert curves.levels([1, 3, 2, 1], width)[0] == ["1", "2", "3"]
    assert curves.levels([1, 3, 2, 1], width)[1].tolist() == [0, 2, 1, 0]
    names, level = curves.levels([0.1 * number for number in range(9)], study.unknowns["learning.alpha"])
    assert names == ["low", "middle", "high"]
    assert level.tolist() == [0, 0, 0, 1, 1, 1, 2, 2, 2]
    assert curves.levels([[9, 14]], study.unknowns["env3.start"])[0][0] == "9, 14"


def test_the_ledger_has_the_degrees_of_each_claim(verdicts: pd.DataFrame) -> None:
    ids = [claim.id for claim in JUDGED]
    classes = pd.DataFrame({"id": ids, "class": SOME, "holds_when": ["on task F", *[np.nan] * (len(ids) - 1)]})
    drawn = pd.concat([verdicts, verdicts.assign(setting="setting_0000")])
    printed = verdicts[shares.KEYS].assign(printed=0.5)
    ledger = shares.ledger(drawn, printed, classes, 0.95)
    assert tuple(ledger.columns) == shares.LEDGER_COLUMNS
    assert len(ledger) == len(JUDGED)
    table = page.ledger_table(ledger.assign(share=0.0, low=0.0, high=0.0038))
    assert len(table.groups[0].rows) == len(JUDGED)
    assert "0% [0, 1]" in str(table.groups[0].rows[0])
    for row, text in zip(table.groups[0].rows, (f"{SOME}: on task F", SOME), strict=False):
        assert f"'{text}'" in str(row)


def test_the_reading_of_a_summary_changes_only_what_a_claim_leaves_open() -> None:
    by_id = {claim.id: claim for claim in JUDGED}
    assert shares.reading_of(by_id["E1-order"], TRANSFER_TASKS) == DEFAULT
    assert shares.reading_of(by_id["E1-jump"], TRANSFER_TASKS).tasks == TRANSFER_TASKS
    assert shares.reading_of(by_id["E3-jump"], "F").runs == 30


def test_a_compressed_table_is_the_same_bytes_each_time(tmp_path) -> None:
    frame = pd.DataFrame({"a": [1.5, np.nan], "b": ["x", "limit"]})
    for name in ("one.csv.gz", "two.csv.gz"):
        write_csv(frame, tmp_path / name)
    assert (tmp_path / "one.csv.gz").read_bytes() == (tmp_path / "two.csv.gz").read_bytes()
    pd.testing.assert_frame_equal(read_csv(tmp_path / "one.csv.gz"), frame)
    (tmp_path / "one.csv.gz").write_bytes(b"no gzip")
    with pytest.raises(UserError, match="cannot be decompressed"):
        read_csv(tmp_path / "one.csv.gz")


# -- the workflow --------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_the_workflow_makes_remakes_and_refuses(tmp_path: Path) -> None:
    project = Project(tmp_path, None)
    project.add_study("multiverse")
    classes = tmp_path / "reports/published/claims.csv"
    classes.parent.mkdir(parents=True)
    shutil.copy(ROOT / "reports/published/claims.csv", classes)
    path = tmp_path / "studies/multiverse/config/multiverse.yaml"
    given = yaml.safe_load(path.read_text())
    brief = given | {
        "settings": 4,
        "block": 2,
        "methods": {name: {"seeds": 10} for name in given["methods"]},
        "named": {"reference": given["named"]["reference"] | {"seeds": 10}},
        "replicates": 2,
    }
    path.write_text(yaml.safe_dump(brief))
    arguments = ("--snakefile", "studies/multiverse/Snakefile")
    project.make(*arguments)
    assert project.waiting(*arguments) == {}
    assert "are whole" in project.ptl("verify", "results/multiverse").stdout
    assert len(pd.read_csv(tmp_path / "reports/multiverse/settings.csv")) == 5
    products = project.files("reports")
    assert len(products) == 32
    (tmp_path / "reports/multiverse/ways.csv").write_text("edited\n")
    waiting = project.waiting(*arguments)
    assert "report_multiverse" in waiting and "learn_block" not in waiting
    path.write_text(yaml.safe_dump(brief | {"seed": 7}))
    assert project.waiting(*arguments)["learn_block"] == 2
    path.write_text(yaml.safe_dump(brief | {"settings": 0}))
    [line] = errors_of(project.snakemake("-n", *arguments))
    assert "settings" in line
    path.write_text(yaml.safe_dump(brief))
    project.make(*arguments)
    assert project.files("reports") == products
