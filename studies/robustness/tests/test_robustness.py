"""The robustness study: its design, its maps, one setting from raw file to verdicts, and their summary."""

from __future__ import annotations

import copy
import json
import re
from pathlib import Path

import msgspec
import numpy as np
import pandas as pd
import pytest
import yaml
from made_up_run import GROUPS
from projects import ROOT, TINY, Project, errors_of
from scipy import stats

from ptl import claims
from ptl.config import Configuration, Parameters
from ptl.errors import UserError
from ptl.files import store
from ptl.files.configuration import completed
from ptl.files.csv import read_csv
from ptl.keys import keys_of
from ptl.learning.life import learn_life, tasks_of
from ptl.measures.measures import measure, runs_of
from ptl.report.config_page import section
from ptl.report.table import to_markdown
from ptl.world.drawing import changed_world, region
from ptl.world.gridworld import GridWorld, load_map, map_digest
from studies.robustness import figure, pages, summary
from studies.robustness.design import LATIN_HYPERCUBE, ONE_AT_A_TIME, REFERENCE, Robustness, read_study
from studies.robustness.jobs import Setting, setting_jobs, settings_cost
from studies.robustness.verdicts import NOT_VARIED, SettingEvidence, evidence_of, target_frame, verdict_frame

FOLDER = ROOT / "studies/robustness"
STUDY_FILE = FOLDER / "config/robustness.yaml"


@pytest.fixture(scope="module")
def run() -> Configuration:
    """The completed configuration of the published run, with paths that hold in every folder."""
    given = yaml.safe_load((ROOT / "config/config.yaml").read_text())
    for entry in given["environments"].values():
        entry["map"] = str(ROOT / entry["map"])
    return completed(given)


@pytest.fixture(scope="module")
def worlds(run: Configuration) -> dict[str, GridWorld]:
    return {name: load_map(entry.map) for name, entry in run.environments.items()}


@pytest.fixture(scope="module")
def content() -> dict:
    return yaml.safe_load(STUDY_FILE.read_text())


@pytest.fixture(scope="module")
def study(content: dict) -> Robustness:
    return Robustness.from_dict(content)


@pytest.fixture(scope="module")
def jobs(study: Robustness, run: Configuration, worlds: dict[str, GridWorld]) -> dict[str, Setting]:
    return setting_jobs(study, run, {name: map_digest(world.text) for name, world in worlds.items()})


# -- design ----------------------------------------------------------------------------------------------------


def test_the_published_study_varies_every_chosen_item(study: Robustness) -> None:
    groups = {
        group: [point for point in study.points() if point.group == group]
        for group in (REFERENCE, ONE_AT_A_TIME, LATIN_HYPERCUBE)
    }
    assert study.seeds >= 10
    assert len(groups[LATIN_HYPERCUBE]) >= 64
    assert len(groups[REFERENCE]) >= 2, "one replicate cannot show what chance does"
    wanted = {
        "learning.alpha", "learning.gamma", "learning.epsilon", "learning.episodes", "skills.prior_width",
        "skills.prior_form", "skills.likelihood_exponent", "skills.likelihood_weight", "skills.patience",
        "skills.skill_use", "skills.null_skill", "subgoals.cover_radius", "subgoals.novelty",
        "subgoals.threshold", "subgoals.trajectories", "env3.start", "env1.room_size", "env1.goal_depth",
        "policy_reuse.temperature_step", "policy_reuse.psi_decay",
    }  # fmt: skip
    assert wanted <= {key for point in groups[ONE_AT_A_TIME] for key in point.changes}
    assert all(wanted <= set(point.changes) for point in groups[LATIN_HYPERCUBE])


def test_hypercube_has_one_value_in_every_stratum(content: dict, study: Robustness) -> None:
    cube = [point for point in study.points() if point.group == LATIN_HYPERCUBE]
    low, high = study.unknowns["learning.alpha"].range
    share = np.log([point.changes["learning.alpha"] / low for point in cube]) / np.log(high / low)
    assert sorted((share * len(cube)).astype(int)) == list(range(len(cube)))
    radius = [point.changes["subgoals.cover_radius"] for point in cube]
    assert set(radius) == {0, 1, 2, 3, 4}
    assert max(radius.count(value) for value in radius) <= min(radius.count(value) for value in radius) + 2
    assert {point.changes["skills.null_skill"] for point in cube} == {True, False}
    assert cube == [p for p in Robustness.from_dict(content).points() if p.group == LATIN_HYPERCUBE], "reproducible"


def test_every_job_is_one_that_the_learner_accepts(
    jobs: dict[str, Setting], run: Configuration, worlds: dict[str, GridWorld]
) -> None:
    reference = jobs["settings/reference_1.h5"]
    for place, job in jobs.items():
        assert place == f"settings/{job.name}.h5"
        assert re.fullmatch("[a-z0-9_.]+", job.name), "the workflow's wildcard"
        assert job.settings.learning.max_steps == 3_000_000
        maps = {name: {} for name in worlds}
        for key, value in job.changes.items():
            if key.partition(".")[0] in maps:
                maps[key.partition(".")[0]][key.partition(".")[2]] = value
        changed = {name: changed_world(world, maps[name]) for name, world in worlds.items()}
        assert all("".join(world.goals) == "ABCDEF" for world in changed.values())
        if job.group == ONE_AT_A_TIME:
            assert len(job.changes) == 1
            drawn = any(changed[name].text != worlds[name].text for name in worlds)
            assert drawn == (job.parameters == reference.parameters), "one thing is changed, and really is"
    assert run.learning.max_steps == 10**7, "the run's configuration is left alone"


def test_the_cost_is_that_of_the_published_study(jobs: dict[str, Setting], worlds: dict[str, GridWorld]) -> None:
    learned = read_csv(ROOT / "reports/robustness/settings.csv")["total_steps"].sum()
    cost = settings_cost(jobs.values(), worlds)
    assert cost.jobs == len(jobs) == 127
    assert learned / 3 < cost.steps < 3 * learned


def study_refusal(content: dict, folder: Path) -> str:
    path = folder / "study.yaml"
    path.write_text(yaml.safe_dump(content))
    with pytest.raises(UserError) as caught:
        read_study(path)
    assert str(path) in str(caught.value) and "\n" not in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize(
    ("key", "value", "says"),
    [
        ("learning.alpha", {"values": [2]}, "unknowns.learning.alpha: 2 is not allowed; give a number > 0 and <= 1"),
        ("learning.alpha", {"options": [0.1, "a"]}, "unknowns.learning.alpha: 'a' is not allowed"),
        ("learning.alpha", {"range": [0.1, 5]}, "unknowns.learning.alpha: 5 is not allowed"),
        ("learning.nothing", {"values": [1]}, "unknowns.learning.nothing: unknown; known are episodes"),
        ("lerning.alpha", {"values": [1]}, "unknowns.lerning: unknown; known are learning"),
        ("alpha", {"values": [1]}, "unknowns: 'alpha' is not allowed; give group.key of a hyper-parameter"),
        ("learning.alpha", {"range": [0.5, 0.1]}, "range: [0.5, 0.1] is not allowed; give two numbers, the lower"),
        ("learning.alpha", {"range": [0.5]}, "range: [0.5] is not allowed; give two numbers"),
        ("learning.gamma", {"range": [0, 1], "scale": "log"}, "range: [0, 1] is not allowed; give two positive"),
        ("learning.gamma", {"range": [0.5, 1], "options": [1]}, "range: is given beside options"),
        ("learning.alpha", {"scale": "cubic"}, "scale: 'cubic' is not allowed; give one of linear, log"),
        ("learning.alpha", {"valeus": [0.1]}, "unknowns.learning.alpha.valeus: unknown; known are symbol"),
        ("learning.alpha", {"values": 0.1}, "values: 0.1 is not allowed; give a list"),
        ("learning.alpha", {"symbol": "_a"}, "unknowns.learning.alpha.symbol"),
        ("learning.alpha", {"symbol": "a\u202eb"}, "unknowns.learning.alpha.symbol"),
        ("learning.alpha", {"values": [0.1, 0.1]}, "share the name"),
    ],
)
def test_a_wrong_unknown_is_refused_in_one_line(
    content: dict, tmp_path: Path, key: str, value: dict, says: str
) -> None:
    unknowns = {**content["unknowns"], key: {"symbol": "x", **value}}
    assert says in study_refusal({**content, "unknowns": unknowns}, tmp_path)


@pytest.mark.parametrize("name", [key.name for key in keys_of(Robustness) if "<name>" not in key.name])
def test_a_missing_or_wrong_key_is_refused(content: dict, tmp_path: Path, name: str) -> None:
    group, _, last = name.rpartition(".")
    for value, says in ((None, "missing; give a whole number"), (-1, "-1 is not allowed")):
        wrong = copy.deepcopy(content)
        holder = wrong[group] if group else wrong
        holder.pop(last)
        holder.update({} if value is None else {last: value})
        assert f"configuration key {name}: {says}" in study_refusal(wrong, tmp_path)


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        (
            {"learning.episodes": {"symbol": "e", "values": [5]}},
            "learning.episodes_5: configuration key measures.window",
        ),
        (
            {"env9.start": {"symbol": "a", "values": [[1, 1]]}},
            "unknowns.env9.start: environment env9 is not in this run",
        ),
    ],
)
def test_a_setting_must_fit_the_run(content: dict, run: Configuration, changes: dict, says: str) -> None:
    study = Robustness.from_dict(content | {"unknowns": changes})
    with pytest.raises(UserError, match=re.escape(says)):
        setting_jobs(study, run, dict.fromkeys(run.environments, "0" * 16))


def test_a_setting_changes_what_it_names_and_nothing_else(jobs: dict[str, Setting], run: Configuration) -> None:
    reference, other = (jobs[f"settings/{name}.h5"] for name in ("reference_1", "subgoals.cover_radius_4"))
    expected = {name: getattr(run, name).to_dict() for name in Setting.READS}
    expected["learning"]["max_steps"] = 3_000_000
    assert reference.parameters == expected
    expected["subgoals"]["cover_radius"] = 4
    assert other.parameters == expected
    same = {"name": "reference_1", "group": REFERENCE, "changes": {}, "parameters": reference.parameters}
    assert msgspec.structs.replace(other, **same) == reference


def test_the_page_has_the_keys_of_the_study() -> None:
    wanted = section("Keys", Robustness, list(keys_of(Robustness)))
    assert wanted in (FOLDER / "README.md").read_text(), wanted


# -- start cells ------------------------------------------------------------------------------------------------


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


def test_start_cells_are_candidates(worlds: dict[str, GridWorld], content: dict) -> None:
    env3 = worlds["env3"]
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


WORLDS = {name: GridWorld.from_text(text, name) for name, text in SMALL_MAPS.items()}


@pytest.fixture(scope="module")
def small() -> Setting:
    """A job on two small maps."""
    parameters = Parameters().replace(learning__episodes=15, subgoals__trajectories=5)
    return Setting(
        root_seed=11,
        parameters={name: getattr(parameters, name).to_dict() for name in Setting.READS},
        maps={name: map_digest(world.text) for name, world in WORLDS.items()},
        code="0" * 16,
        name="reference_1",
        group=REFERENCE,
        changes={},
        tasks=dict.fromkeys(SMALL_MAPS, "AB"),
        methods=METHODS,
        seeds=3,
        step_budget=10**9,
        growth_environment="env3",
        growth_tasks=4,
        growth_runs=2,
    )


def result_of(job: Setting, folder: Path, **changes: object) -> store.Result:
    job = msgspec.structs.replace(job, **changes)
    path = folder / f"{job.name}_{job.digest}.h5"
    store.write(path, job, job.run(WORLDS), WORLDS)
    return store.read(path, job)


def evidence(job: Setting, folder: Path, **changes: object) -> SettingEvidence:
    return evidence_of(result_of(job, folder, **changes), GROUPS)


def test_a_setting_gives_the_measures_of_the_main_runs_own_code(small: Setting, tmp_path: Path) -> None:
    setting = evidence(small, tmp_path)
    assert setting.status == "complete"
    runs = []
    for name, world in WORLDS.items():
        for method in METHODS:
            lives = [
                learn_life(
                    world, tasks_of(world, "AB"), method, small.settings, 11, "robustness", small.name, name, seed
                )
                for seed in range(3)
            ]
            steps = np.array([[record.steps for record in life.records] for life in lives])
            truncated = np.array([[record.truncated.sum() for record in life.records] for life in lives])
            runs += runs_of(name, method, "AB", {"seeds": np.arange(3), "steps": steps, "truncated": truncated})
    expected = measure(runs, WORLDS, 10, 1.5)
    pd.testing.assert_frame_equal(setting.evidence.per_seed, expected.per_seed)
    for key, steps in expected.steps.items():
        assert np.array_equal(setting.evidence.steps[key], steps)
    total = sum(int(steps.sum()) for steps in expected.steps.values())
    assert verdict_frame(setting)["total_steps"].unique().tolist() == [total]


def test_equal_settings_give_equal_bytes_and_settings_share_no_random_numbers(small: Setting, tmp_path: Path) -> None:
    brief = msgspec.structs.replace(small, methods=["ptl"], seeds=1)
    one = result_of(brief, tmp_path)
    before = one.path.read_bytes()
    assert result_of(brief, tmp_path).path.read_bytes() == before
    other = result_of(brief, tmp_path, name="reference_2")
    assert not np.array_equal(one.arrays["env1/ptl/steps"], other.arrays["env1/ptl/steps"])
    with pytest.raises(UserError, match="was made with name 'reference_2', not 'reference_1'"):
        store.read(other.path, brief)


def test_a_changed_map_is_made_from_that_of_the_job(small: Setting, tmp_path: Path) -> None:
    result = result_of(small, tmp_path, changes={"env1.start": [2, 2]}, methods=["no_transfer"])
    assert result.maps["env1"] == SMALL_MAPS["env1"]
    setting = evidence_of(result, GROUPS)
    world = setting.evidence.worlds["env1"]
    assert world.cells[world.start].tolist() == [2, 2]


def test_a_setting_that_runs_out_of_steps_says_so_and_keeps_what_it_has(small: Setting, tmp_path: Path) -> None:
    setting = evidence(small, tmp_path, step_budget=1)
    assert "env1, no_transfer: given up after 1 of 3 seeds" in setting.status
    assert setting.evidence.steps["env3", "ptl", "B"].shape == (1, 15)
    frame = verdict_frame(setting)
    assert (frame["verdict"] == "undecided").all()
    assert (frame["status"] == setting.status).all()


def test_a_setting_that_fails_says_so(small: Setting, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    setting = evidence(small, tmp_path, changes={"env3.start": [0, 0]})
    assert setting.status.startswith("failed: UserError:")
    assert "Traceback" in capsys.readouterr().err
    assert verdict_frame(setting)["verdict"].tolist() == ["undecided"] * (len(claims.CLAIMS) - len(NOT_VARIED))


def test_impossible_settings_are_not_written(small: Setting, tmp_path: Path) -> None:
    arrays = small.run(WORLDS)
    missing = {name: values for name, values in arrays.items() if not name.startswith("env1/ptl/")}
    seeds = {f"env1/ptl/{name}": arrays[f"env1/ptl/{name}"][:2] for name in ("seeds", "steps", "truncated")}
    for wrong, says in (
        (missing, "some of its lives are missing"),
        (arrays | {"env1/no_transfer/seeds": np.array([0, 2, 1])}, "its seeds are not 0, 1, 2"),
        (arrays | {"env1/ptl/subgoal": np.full((3, 2), 10**6)}, "a state that is not in its map"),
        (arrays | {"env1/other/seeds": arrays["env1/ptl/seeds"]}, "missing"),
        ({name: values for name, values in arrays.items() if "env1/no_transfer" not in name}
         | {key.replace("ptl", "no_transfer"): values for key, values in seeds.items()}, "has 2 lives of 3"),
    ):  # fmt: skip
        with pytest.raises(UserError, match=says):
            store.write(tmp_path / "x.h5", small, wrong, WORLDS)


def test_verdicts_are_those_of_the_ledger(small: Setting, tmp_path: Path) -> None:
    setting = evidence(small, tmp_path, seeds=10, growth_runs=10)
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
    for setting in Robustness.from_dict(STUDY).points():
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


UNKNOWNS = Robustness.from_dict(STUDY).unknowns


def test_shares_and_what_affects_a_claim_most(verdicts: pd.DataFrame) -> None:
    table = summary.share_table(verdicts, UNKNOWNS).set_index("claim")
    assert table.loc["always", "one_at_a_time_reproduced"] == 1
    assert table.loc["always", ["most_affected_by", "flipped_by", "associated_with"]].tolist() == ["", "", ""]
    assert table.loc["on_alpha", "most_affected_by"] == "α"
    assert table.loc["on_alpha", "flipped_by"] == "α (0.2: not reproduced, 0.5: not reproduced)"
    assert table.loc["on_alpha", "one_at_a_time_not_reproduced"] == pytest.approx(2 / 4)
    assert table.loc["on_alpha", "associated_with"].startswith("α (−0.")
    assert table.loc["on_use", "most_affected_by"] == "skill use"
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


def test_every_value_makes_a_name_for_files(content: dict) -> None:
    unknowns = {
        "learning.alpha": {"symbol": "a", "values": [0.00001]},
        "env1.start": {"symbol": "b", "values": [["a/b", 1], ["../../x", -1]]},
        "env1.chain": {"symbol": "c", "values": [{"a b; touch x": 1}]},
    }
    names = [setting.name for setting in Robustness.from_dict({**content, "unknowns": unknowns}).points()]
    assert all(re.fullmatch("[a-z0-9_.]+", name) and ".." not in name for name in names)
    assert "learning.alpha_1e_05" in names


# -- the workflow ----------------------------------------------------------------------------------------------

TINY_STUDY = {
    "seeds": 1, "replicates": 2, "max_steps": 10_000, "step_budget": 10**6, "growth": {"tasks": 2, "runs": 1},
    "latin_hypercube": {"settings": 1, "seed": 1},
    "unknowns": {"learning.alpha": {"symbol": "α", "values": [0.2], "range": [0.02, 0.5]}},
}  # fmt: skip


@pytest.mark.slow
def test_the_workflow_makes_remakes_and_refuses(tmp_path: Path) -> None:
    project = Project(tmp_path)
    project.add_study("robustness")
    file = tmp_path / "studies/robustness/config/robustness.yaml"
    file.write_text(yaml.safe_dump(TINY_STUDY))
    arguments = ("--snakefile", "studies/robustness/Snakefile")
    project.make(*arguments)
    assert project.waiting(*arguments) == {}
    products = project.files("reports/robustness")
    assert "reports/robustness/heat_map.png" in products and "reports/robustness/manifest.json" in products
    assert "are whole" in project.ptl("verify", "results/robustness").stdout
    project.configure({**TINY, "learning": {"episodes": 20, "gamma": 0.9}})
    assert project.waiting(*arguments)["learn_setting"] == 4
    project.configure({**TINY, "measures": {"window": 5}})
    waiting = project.waiting(*arguments)
    assert "learn_setting" not in waiting and waiting["judge_settings"] == 3
    project.configure(TINY)
    file.write_text(yaml.safe_dump(TINY_STUDY | {"replicates": 3}))
    assert project.waiting(*arguments)["learn_setting"] == 1
    file.write_text(yaml.safe_dump(TINY_STUDY | {"replicates": 0}))
    [line] = errors_of(project.snakemake("-n", *arguments))
    assert "robustness.yaml" in line and "replicates: 0 is not allowed" in line
    file.write_text(yaml.safe_dump(TINY_STUDY))
    project.make(*arguments)
    assert project.files("reports/robustness") == products
