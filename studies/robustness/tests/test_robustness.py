"""The robustness study: its design, its maps, one setting from raw file to verdicts, and what is made of them."""

from __future__ import annotations

import copy
import json
import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml
from made_up_run import GROUPS
from projects import MAPS
from scipy import stats

from ptl import claims, measures
from ptl.config import Parameters
from ptl.errors import UserError
from ptl.files.configuration import completed
from ptl.files.results import write_learning
from ptl.learning.life import learn_life, tasks_of
from ptl.report import robustness as pages
from ptl.report.figures import robustness as figure
from ptl.report.table import to_markdown
from ptl.world.drawing import chain_of_rooms, changed_world, region, with_start
from ptl.world.gridworld import GridWorld, load_map
from studies.robustness import summary
from studies.robustness.design import (
    LATIN_HYPERCUBE,
    ONE_AT_A_TIME,
    REFERENCE,
    Setting,
    Study,
    job_of,
    jobs_of,
)
from studies.robustness.running import read_setting, run_setting
from studies.robustness.verdicts import NOT_VARIED, load_setting, target_frame, verdict_frame

CONFIG = MAPS.parent


@pytest.fixture(scope="module")
def config() -> dict:
    """The completed configuration of the published run, with paths that hold in every folder."""
    given = yaml.safe_load((CONFIG / "config.yaml").read_text())
    for entry in given["environments"].values():
        entry["map"] = str(CONFIG.parent / entry["map"])
    return completed(given).to_dict()


@pytest.fixture(scope="module")
def content() -> dict:
    return yaml.safe_load((CONFIG / "robustness.yaml").read_text())


# -- design ----------------------------------------------------------------------------------------------------


def test_the_published_study_varies_every_chosen_item(content: dict) -> None:
    study = Study.from_dict(content)
    assert study.seeds >= 10
    groups = {group: [s for s in study.settings() if s.group == group] for group in
              (REFERENCE, ONE_AT_A_TIME, LATIN_HYPERCUBE)}  # fmt: skip
    assert len(groups[LATIN_HYPERCUBE]) >= 64
    assert len(groups[REFERENCE]) >= 2, "one replicate cannot show what chance does"
    wanted = {
        "learning.alpha", "learning.gamma", "learning.epsilon", "learning.episodes", "skills.prior_width",
        "skills.prior_form", "skills.likelihood_exponent", "skills.likelihood_weight", "skills.patience",
        "skills.skill_use", "skills.null_skill", "subgoals.cover_radius", "subgoals.novelty",
        "subgoals.threshold", "subgoals.trajectories", "env3.start", "env1.room_size", "env1.goal_depth",
        "policy_reuse.temperature_step", "policy_reuse.psi_decay",
    }  # fmt: skip
    assert wanted <= {key for setting in groups[ONE_AT_A_TIME] for key in setting.changes}
    assert all(wanted <= set(setting.changes) for setting in groups[LATIN_HYPERCUBE])


def test_one_at_a_time_changes_one_thing_and_really_changes_it(content: dict, config: dict) -> None:
    study = Study.from_dict(content)
    reference = job_of(Setting("x", REFERENCE), study, config)
    for setting in study.settings():
        job = job_of(setting, study, config)
        assert re.fullmatch("[a-z0-9_.]+", setting.name), "the workflow's wildcard"
        if setting.group == ONE_AT_A_TIME:
            assert len(setting.changes) == 1
            assert (job["parameters"], job["environments"]) != (reference["parameters"], reference["environments"])
    names = [setting.name for setting in study.settings()]
    assert len(set(names)) == len(names)


def test_hypercube_has_one_value_in_every_stratum(content: dict) -> None:
    study = Study.from_dict(content)
    cube = [setting for setting in study.settings() if setting.group == LATIN_HYPERCUBE]
    low, high = study.unknowns["learning.alpha"].range
    share = np.log([s.changes["learning.alpha"] / low for s in cube]) / np.log(high / low)
    assert sorted((share * len(cube)).astype(int)) == list(range(len(cube)))
    radius = [setting.changes["subgoals.cover_radius"] for setting in cube]
    assert set(radius) == {0, 1, 2, 3, 4}
    assert max(radius.count(value) for value in radius) <= min(radius.count(value) for value in radius) + 2
    assert {setting.changes["skills.null_skill"] for setting in cube} == {True, False}
    assert cube == [s for s in Study.from_dict(content).settings() if s.group == LATIN_HYPERCUBE], "reproducible"


def test_every_job_is_one_that_the_learner_accepts(content: dict, config: dict) -> None:
    study = Study.from_dict(content)
    worlds = {name: load_map(entry["map"]) for name, entry in config["environments"].items()}
    for setting in study.settings():
        job = job_of(setting, study, config)
        Parameters.from_dict(job["parameters"])
        for name, entry in job["environments"].items():
            world = changed_world(worlds[name], entry["changes"])
            assert "".join(world.goals) == "ABCDEF"
    assert config["learning"]["max_steps"] == 10**7, "the run's configuration is left alone"


def test_jobs_of_the_workflow_are_those_of_the_study(content: dict, config: dict) -> None:
    study = Study.from_dict(content)
    jobs = jobs_of(study, config)
    assert list(jobs) == [setting.name for setting in study.settings()]
    assert jobs["reference_1"] == job_of(Setting("reference_1", REFERENCE), study, config)


# -- worlds ----------------------------------------------------------------------------------------------------


def test_chain_of_rooms_is_the_published_map_at_its_own_values(env1: GridWorld) -> None:
    assert chain_of_rooms() == env1.text
    assert changed_world(env1, {}) is env1


def test_other_rooms_and_goals(env1: GridWorld) -> None:
    small = changed_world(env1, {"room_size": 6})
    assert small.n_states == 7 * 36 + 6
    near, far = (changed_world(env1, {"room_size": 10, "goal_depth": depth}) for depth in (0.3, 0.9))
    for letter in "ABCDEF":
        assert near.cells[near.goal(letter)][1] == far.cells[far.goal(letter)][1] - 6
        assert near.cells[near.goal(letter)][0] == far.cells[far.goal(letter)][0]


def test_another_start(env3: GridWorld) -> None:
    moved = with_start(env3, [8, 8])
    assert moved.cells[moved.start].tolist() == [8, 8]
    assert moved.goals == env3.goals
    assert moved.n_states == env3.n_states


@pytest.mark.parametrize(
    "changes",
    [{"start": [0, 0]}, {"start": [2, 3]}, {"start": [99, 1]}, {"room_size": 8}, {"goal_depth": 0.5}, {"doors": 2}],
)
def test_changes_that_make_no_map_are_refused(env3: GridWorld, changes: dict) -> None:
    with pytest.raises(UserError):
        changed_world(env3, changes)


@pytest.mark.parametrize("changes", [{"room_size": 3}, {"room_size": 7.5}, {"goal_depth": 0}, {"goal_depth": 1.1}])
def test_impossible_rooms_are_refused(env1: GridWorld, changes: dict) -> None:
    with pytest.raises(UserError, match="is not allowed"):
        changed_world(env1, changes)


def cells_that_must_pass(world: GridWorld, through: np.ndarray, goals: list[int]) -> np.ndarray:
    """Return the states, goals excluded, from which every path to each of ``goals`` passes a region, bool (n_states,).

    Parameters
    ----------
    through : bool array (n_states,)
        The region; its own cells are not counted.
    goals : list of int
        States outside the region.
    """
    result = ~through
    result[list(world.goals.values())] = False
    for goal in goals:
        open_ = ~through
        reached = np.zeros(world.n_states, dtype=bool)
        reached[goal] = True
        frontier = [goal]
        while frontier:
            after = np.unique(world.successors[frontier])
            frontier = after[open_[after] & ~reached[after]].tolist()
            reached[frontier] = True
        result &= ~reached
    return result


def test_start_cells_are_candidates(env3: GridWorld, content: dict) -> None:
    entry = content["unknowns"]["env3.start"]
    goals = [env3.goal(letter) for letter in entry["candidates"]["goals"]]
    found = np.ones(env3.n_states, dtype=bool)
    for place in entry["candidates"]["through"].values():
        found &= cells_that_must_pass(env3, region(env3, place["rows"], place["columns"]), goals)
    assert found.sum() == 59
    assert found[env3.start]
    assert entry["options"] == [env3.cells[env3.start].tolist(), *entry["values"]]
    assert all(found[env3.state_at(*cell)] for cell in entry["options"])


def test_cells_that_must_pass_on_a_small_map() -> None:
    world = GridWorld.from_text("#######\n#I....#\n#.###.#\n#..#.A#\n#######\n")
    through = region(world, (1, 1), (3, 3))
    must = cells_that_must_pass(world, through, [world.goal("A")])
    assert [world.cells[s].tolist() for s in np.flatnonzero(must)] == [[1, 1], [1, 2], [2, 1], [3, 1], [3, 2]]


# -- one setting -----------------------------------------------------------------------------------------------

SMALL_MAPS = {
    "env1": "#########\n#I..#..A#\n#.......#\n#..#.B..#\n#########\n",
    "env3": "########\n#..A#.B#\n#I.....#\n########\n",
}
METHODS = ["no_transfer", "full_transfer", "policy_reuse", "ptl", "ptl_supervised", "ptl_unknown_goal"]


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> dict:
    """A job on two small maps."""
    folder = tmp_path_factory.mktemp("maps")
    for name, text in SMALL_MAPS.items():
        (folder / f"{name}.txt").write_text(text)
    parameters = Parameters().replace(learning__episodes=15, subgoals__trajectories=5).to_dict()
    return {
        "setting": "reference_1",
        "group": REFERENCE,
        "changes": {},
        "environments": {
            name: {"map": str(folder / f"{name}.txt"), "tasks": "AB", "changes": {}} for name in SMALL_MAPS
        },
        "methods": METHODS,
        "seeds": 3,
        "root_seed": 11,
        "parameters": parameters,
        "step_budget": 10**9,
        "growth": {"environment": "env3", "tasks": 4, "runs": 2},
    }


def test_a_raw_file_gives_the_measures_of_the_main_runs_own_code(small: dict, tmp_path: Path) -> None:
    run_setting(small, tmp_path / "raw.h5")
    setting = load_setting(tmp_path / "raw.h5", GROUPS)
    assert setting.status == "complete"
    parameters = Parameters.from_dict(small["parameters"])
    paths = []
    for name, entry in small["environments"].items():
        world = load_map(entry["map"])
        for method in METHODS:
            for seed in range(3):
                life = learn_life(
                    world, tasks_of(world, "AB"), method, parameters, 11, "robustness", "reference_1", name, seed
                )
                origin = {"environment": name, "method": method, "seed": seed, "root_seed": 11}
                origin["parameters"] = small["parameters"]
                paths.append(tmp_path / f"{name}_{method}_{seed}.h5")
                write_learning(paths[-1], life, world, origin | {"code": "0" * 16})
    expected = measures.measure_files(paths, 10, 1.5)
    pd.testing.assert_frame_equal(setting.evidence.per_seed, expected.per_seed)
    pd.testing.assert_frame_equal(setting.evidence.subgoals, expected.subgoals)
    assert setting.evidence.steps.keys() == expected.steps.keys()
    for key, steps in expected.steps.items():
        assert np.array_equal(setting.evidence.steps[key], steps)
    total = sum(int(steps.sum()) for steps in expected.steps.values())
    assert verdict_frame(setting)["total_steps"].unique().tolist() == [total]


def test_equal_settings_give_equal_bytes_and_settings_share_no_random_numbers(small: dict, tmp_path: Path) -> None:
    job = small | {"methods": ["ptl"], "seeds": 1}
    for name, setting in (("a", "reference_1"), ("b", "reference_1"), ("c", "reference_2")):
        run_setting(job | {"setting": setting}, tmp_path / f"{name}.h5")
    assert (tmp_path / "a.h5").read_bytes() == (tmp_path / "b.h5").read_bytes()
    one, other = (read_setting(tmp_path / f"{name}.h5")[0]["env1/ptl/steps"] for name in "ac")
    assert not np.array_equal(one, other)


def test_a_setting_that_runs_out_of_steps_says_so_and_keeps_what_it_has(small: dict, tmp_path: Path) -> None:
    run_setting(small | {"step_budget": 1}, tmp_path / "raw.h5")
    setting = load_setting(tmp_path / "raw.h5", GROUPS)
    assert "env1, no_transfer: given up after 1 of 3 seeds" in setting.status
    assert setting.evidence.steps["env3", "ptl", "B"].shape == (1, 15)
    frame = verdict_frame(setting)
    assert (frame["verdict"] == "undecided").all()
    assert (frame["status"] == setting.status).all()


def test_a_setting_that_fails_says_so(small: dict, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    environments = copy.deepcopy(small["environments"])
    environments["env3"]["changes"] = {"start": [0, 0]}
    run_setting(small | {"environments": environments}, tmp_path / "raw.h5")
    setting = load_setting(tmp_path / "raw.h5", GROUPS)
    assert setting.status.startswith("failed: UserError:")
    assert "Traceback" in capsys.readouterr().err
    frame = verdict_frame(setting)
    assert frame["verdict"].tolist() == ["undecided"] * (len(claims.CLAIMS) - len(NOT_VARIED))


def test_verdicts_are_those_of_the_ledger(small: dict, tmp_path: Path) -> None:
    run_setting(small | {"seeds": 10, "growth": small["growth"] | {"runs": 10}}, tmp_path / "raw.h5")
    setting = load_setting(tmp_path / "raw.h5", GROUPS)
    frame = verdict_frame(setting).set_index("claim")
    for judgement in claims.judge(setting.evidence):
        if judgement.claim.id not in NOT_VARIED:
            row = frame.loc[judgement.claim.id]
            assert row["verdict"] == judgement.verdict
            assert row["parts"] == len(judgement.parts)
            assert (row["parts_holding"] == row["parts"] > 0) == (row["verdict"] == "reproduced")
    assert set(NOT_VARIED) < {claim.id for claim in claims.CLAIMS}
    numbers = target_frame(setting)
    own = setting.evidence.per_seed.query("environment == 'env3' and task == 'B'")
    first = own.groupby("method")["first_episode"].mean()
    row = numbers.query("claim == 'E3-jump' and task == 'B' and method == 'ptl'").iloc[0]
    assert row["first_episode"] == pytest.approx(first["ptl"])
    assert row["jump_start_percent"] == pytest.approx(100 * (1 - first["ptl"] / first["no_transfer"]))


# -- all settings ----------------------------------------------------------------------------------------------

STUDY = {
    "seeds": 10, "replicates": 3, "max_steps": 100, "step_budget": 100, "growth": {"tasks": 2, "runs": 1},
    "latin_hypercube": {"settings": 40, "seed": 3},
    "unknowns": {
        "learning.alpha": {"symbol": "α", "values": [0.2, 0.5], "range": [0.02, 0.5], "scale": "log"},
        "learning.gamma": {"symbol": "γ", "values": [0.9], "range": [0.9, 0.99]},
        "skills.skill_use": {"symbol": "skill use", "values": ["lead_in"], "options": ["reselect", "lead_in"]},
    },
}  # fmt: skip


def made_up_verdicts() -> pd.DataFrame:
    """`on_alpha` fails where alpha is high, `on_use` is partly so with lead_in; `always` holds, `never` is open."""
    rows = []
    for setting in Study.from_dict(STUDY).settings():
        alpha, use = setting.changes.get("learning.alpha", 0.05), setting.changes.get("skills.skill_use", "reselect")
        holding = {
            "on_alpha": 0 if alpha > 0.15 else 2,
            "on_use": 2 if use == "reselect" else 1,
            "always": 2,
            "never": 0,
        }
        for claim, number in holding.items():
            verdict = ("not reproduced", "partly reproduced", "reproduced")[number]
            rows.append(
                {"setting": setting.name, "group": setting.group, "changes": json.dumps(setting.changes),
                 "status": "complete", "truncated": 0, "total_steps": 5, "claim": claim,
                 "verdict": "undecided" if claim == "never" else verdict,
                 "parts": 0 if claim == "never" else 2, "parts_holding": number, "evidence": ""}
            )  # fmt: skip
    return pd.DataFrame(rows)


@pytest.fixture
def verdicts() -> pd.DataFrame:
    return made_up_verdicts()


UNKNOWNS = Study.from_dict(STUDY).unknowns


def test_shares_and_what_a_claim_hangs_on(verdicts: pd.DataFrame) -> None:
    table = summary.share_table(verdicts, UNKNOWNS).set_index("claim")
    assert table.loc["always", "one_at_a_time_reproduced"] == 1
    assert table.loc["always", ["hangs_on", "flipped_by", "associated_with"]].tolist() == ["", "", ""]
    assert table.loc["on_alpha", "hangs_on"] == "α"
    assert table.loc["on_alpha", "flipped_by"] == "α (0.2: not reproduced, 0.5: not reproduced)"
    assert table.loc["on_alpha", "one_at_a_time_not_reproduced"] == pytest.approx(2 / 4)
    assert table.loc["on_alpha", "associated_with"].startswith("α (−0.")
    assert table.loc["on_use", "hangs_on"] == "skill use"
    assert table.loc["on_use", "one_at_a_time_partly_reproduced"] == pytest.approx(1 / 4)
    assert table.loc["on_use", "latin_hypercube_reproduced"] == pytest.approx(1 / 2)
    assert table.loc["never", "reference"] == "undecided"
    assert table.loc["never", "latin_hypercube_undecided"] == 1


def test_associations_are_those_of_scipy(verdicts: pd.DataFrame) -> None:
    found = summary.associations(verdicts, UNKNOWNS).set_index(["claim", "unknown"])
    cube = verdicts[(verdicts["group"] == LATIN_HYPERCUBE) & (verdicts["claim"] == "on_alpha")]
    alpha = [json.loads(text)["learning.alpha"] for text in cube["changes"]]
    expected = stats.spearmanr(alpha, cube["parts_holding"])
    assert found.loc[("on_alpha", "learning.alpha"), "association"] == pytest.approx(expected.statistic)
    assert found.loc[("on_alpha", "learning.alpha"), "p_value"] == pytest.approx(expected.pvalue)
    assert found.loc[("on_use", "skills.skill_use"), "association"] == pytest.approx(1.0)
    assert found.loc[("always", "learning.alpha"), ["association", "p_value"]].tolist() == [0.0, 1.0]
    assert "never" not in found.index.get_level_values("claim")


def test_chance_among_replicates_is_shown(verdicts: pd.DataFrame) -> None:
    verdicts.loc[(verdicts["setting"] == "reference_2") & (verdicts["claim"] == "always"), "verdict"] = "not reproduced"
    table = summary.share_table(verdicts, UNKNOWNS).set_index("claim")
    assert table.loc["always", "reference"] == "reproduced"
    assert table.loc["always", "agreement"] == pytest.approx(2 / 3)
    assert summary.most_common(pd.Series(["reproduced", "not reproduced"])) == "not reproduced"


def test_an_undecided_setting_is_no_flip(verdicts: pd.DataFrame) -> None:
    moved = (verdicts["setting"] == "learning.gamma_0.9") & (verdicts["claim"] == "always")
    verdicts.loc[moved, "verdict"] = "undecided"
    assert not (summary.flips(verdicts)["claim"] == "always").any()
    verdicts.loc[moved, "verdict"] = "not reproduced"
    assert (summary.flips(verdicts)["claim"] == "always").sum() == 1


def test_unknowns_are_ranked(verdicts: pd.DataFrame) -> None:
    table = summary.unknown_table(verdicts, UNKNOWNS)
    assert table["rank"].tolist() == [1, 2, 3]
    assert table["symbol"].tolist()[-1] == "γ"
    assert table.set_index("symbol").loc["α", "flipped"] == "on_alpha"


def test_heat_map_shows_every_setting_once(verdicts: pd.DataFrame) -> None:
    frame = figure.heat_frame(verdicts)
    assert len(frame) == len(verdicts)
    columns = frame.drop_duplicates("setting").sort_values("column")
    assert columns["column"].tolist() == list(range(3 + 4 + 40))
    cube = columns[columns["group"] == LATIN_HYPERCUBE]["setting"]
    means = frame.groupby("setting")["score"].mean()[cube]
    assert means.is_monotonic_decreasing


def test_tables_are_made_from_the_files_of_all_settings(verdicts: pd.DataFrame, tmp_path: Path) -> None:
    verdicts.loc[verdicts["setting"] == "hypercube_002", "status"] = "env1, full_transfer: given up after 1 of 10 seeds"
    paths = []
    for name, part in verdicts.groupby("setting", sort=False):
        paths.append(tmp_path / f"{name}.verdicts.csv")
        part.to_csv(paths[-1], index=False)
    read = summary.read_verdicts(paths)
    pd.testing.assert_frame_equal(read.drop(columns="evidence"), verdicts.drop(columns="evidence"), check_dtype=False)
    settings = summary.setting_table(read, UNKNOWNS)
    assert settings.loc[settings["setting"] == "learning.alpha_0.2", "changes"].item() == "α = 0.2"
    text = to_markdown(pages.share_table(summary.share_table(read, UNKNOWNS), settings))
    assert "given up after 1 of 10 seeds" in text
    cube = verdicts[(verdicts["group"] == LATIN_HYPERCUBE) & (verdicts["claim"] == "on_alpha")]
    share = summary.share_table(read, UNKNOWNS).set_index("claim")
    expected = (cube["verdict"] == "reproduced").mean()
    assert share.loc["on_alpha", "latin_hypercube_reproduced"] == pytest.approx(expected)
    paths[-1].unlink()
    with pytest.raises(UserError, match=re.escape(paths[-1].name)):
        summary.read_verdicts(paths)
    with pytest.raises(UserError, match="no setting"):
        summary.read_verdicts([])


def test_targeted_pages_put_settings_beside_each_other(verdicts: pd.DataFrame) -> None:
    rows = [
        {"claim": "E3-few", "setting": setting, "group": "", "changes": json.dumps(changes), "environment": "env3",
         "task": "F", "method": method, "episodes": value, "episodes_low": value - 1, "episodes_high": value + 1}
        for setting, changes, value in (
            ("reference_1", {}, 66.0), ("learning.alpha_0.2", {"learning.alpha": 0.2}, 20.0),
        )
        for method in ("policy_reuse", "ptl")
    ]  # fmt: skip
    [table] = pages.target_tables(pd.DataFrame(rows), verdicts, UNKNOWNS)
    text = to_markdown(table)
    assert re.search(r"reference 1 *\|.*66 \\?\[65, 67", text)
    assert re.search(r"α = 0.2 *\|.*20 \\?\[19, 21", text)


def test_labels_of_the_heat_map_are_apart_and_in_order() -> None:
    moved = figure._apart([0.0, 5.0, 6.0, 6.5, 12.0], 1.65)
    assert (np.diff(moved) >= 1.65 - 1e-9).all()
    assert moved[[0, 4]].tolist() == [0, 12]
    assert abs(moved[1:4].mean() - np.mean([5, 6, 6.5])) < 0.5


@pytest.mark.parametrize(
    ("unknown", "says"),
    [
        ({"symbol": "a\ud800b"}, "symbol"),
        ({"symbol": "_a"}, "symbol"),
        ({"symbol": "a\u202eb"}, "symbol"),
        ({"symbol": "a", "values": [0.1, 0.1]}, "share the name"),
    ],
)
def test_symbols_and_values_that_cannot_be_shown_are_refused(content: dict, unknown: dict, says: str) -> None:
    with pytest.raises(UserError, match=f"learning.alpha.*{says}"):
        Study.from_dict({**content, "unknowns": {"learning.alpha": unknown}})


def test_every_value_makes_a_name_for_files(content: dict) -> None:
    unknowns = {
        "learning.alpha": {"symbol": "a", "values": [0.00001]},
        "env1.start": {"symbol": "b", "values": [["a/b", 1], ["../../x", -1]]},
        "env1.chain": {"symbol": "c", "values": [{"a b; touch x": 1}]},
    }
    names = [setting.name for setting in Study.from_dict({**content, "unknowns": unknowns}).settings()]
    assert all(re.fullmatch("[a-z0-9_.]+", name) and ".." not in name for name in names)
    assert "learning.alpha_1e_05" in names
