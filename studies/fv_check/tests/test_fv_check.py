"""Fernandez and Veloso's experiment: gains, the library's policies, files, table and figure."""

from __future__ import annotations

from pathlib import Path

import msgspec
import numpy as np
import pandas as pd
import pytest
import yaml
from projects import ROOT, Project, errors_of

from ptl import methods
from ptl.errors import UserError
from ptl.files import store
from ptl.files.csv import read_csv
from ptl.measures.statistics import Resampling
from ptl.methods._base import BaseMethod
from ptl.report.table import to_html, to_markdown
from ptl.text import number
from ptl.world.gridworld import GridWorld, map_digest
from ptl.world.map_files import load_map
from studies.fv_check import experiment as fv
from studies.fv_check import figure
from studies.fv_check.jobs import MAP, FvCheck, Gains, gains_of, trials_jobs
from studies.fv_check.page import agreement, gain_frame, gain_table

CORRIDOR = GridWorld.from_text("#####\n#I.F#\n#####\n")
ENV3 = load_map(ROOT / "config/environments/env3.txt")
CONFIG = ROOT / "studies/fv_check/config/fv_check.yaml"


class Walker(BaseMethod):
    """Always goes east."""

    def run_episode(self, learner) -> list[int]:
        learner.follow(np.full(self.world.n_states, 3, dtype=np.int8), self.world.goal("F"))
        return []


# -- the experiment -----------------------------------------------------------------------------------------------


def test_gain_is_the_discounted_return_of_a_trial() -> None:
    starts = fv.random_starts(CORRIDOR, 2, 50, np.random.default_rng(0))
    assert set(starts) == {0, 1}, "never the goal itself"
    walker = Walker(CORRIDOR, fv.PARAMETERS, None)
    gains, learner = fv.learn_gains(CORRIDOR, 2, walker, fv.PARAMETERS, 40, ("a", 1), 3)
    assert set(np.round(gains, 12)) == {1.0, 0.95}, "one step and two steps from the goal"
    assert learner.q[1, 3] > 0


def test_a_trial_ends_after_a_hundred_steps_without_gain() -> None:
    class Stander(Walker):
        def run_episode(self, learner) -> list[int]:
            learner.follow(np.zeros(3, dtype=np.int8), 2)
            assert learner.truncated
            assert learner.steps == 100
            return []

    gains, _ = fv.learn_gains(CORRIDOR, 2, Stander(CORRIDOR, fv.PARAMETERS, None), fv.PARAMETERS, 3, ("b",), 3)
    assert not gains.any()


def test_quality_of_a_policy() -> None:
    goal = ENV3.goal("A")
    best = ENV3.transitions.shortest_path_policy(goal)
    undefined = np.full(ENV3.n_states, -1, dtype=np.int8)
    assert fv.policy_quality(ENV3, best, goal, fv.PARAMETERS) == pytest.approx(1.0)
    assert fv.policy_quality(ENV3, undefined, goal, fv.PARAMETERS) == 0.0
    assert fv.policy_quality(CORRIDOR, np.array([-1, 3, 0]), 2, fv.PARAMETERS) == pytest.approx(1 / 1.95)


def learned(tasks: str, seed: int, trials: int, library_trials: int) -> tuple[np.ndarray, np.ndarray]:
    return fv.learn_library(ENV3, tasks, fv.PARAMETERS, 1, seed, trials, library_trials)


def test_the_learner_is_that_of_the_main_comparison(monkeypatch: pytest.MonkeyPatch) -> None:
    reuse = methods.load("policy_reuse")
    sizes = []
    original = reuse.run_episode

    def spy(self, learner) -> list[int]:
        sizes.append(len(self.past_policies))
        return original(self, learner)

    monkeypatch.setattr(reuse, "run_episode", spy)
    gains, quality = learned("234", 0, 20, 50)
    assert sizes == [3] * 20
    assert (gains.shape, quality.shape) == ((20,), (3,))


def test_a_past_policy_does_not_depend_on_the_library_it_is_in() -> None:
    (_, three), (_, four), (_, other) = (learned(*values, 2, 400) for values in (("234", 4), ("1234", 4), ("234", 5)))
    assert three.tolist() == four[1:].tolist()
    assert three.tolist() != other.tolist()


def test_a_good_library_beats_plain_q_learning() -> None:
    """Task 5 is next to the new task, so its policy helps from the first hundred trials on (source: FV)."""
    good, plain = (np.mean([learned(tasks, seed, 800, 20_000)[0].mean() for seed in (0, 1)]) for tasks in ("2345", ""))
    assert good > 1.3 * plain


# -- files, table and figure --------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def jobs() -> list:
    given = yaml.safe_load(CONFIG.read_text()) | {"seeds": 5, "trials": 60, "library_trials": 100}
    return list(trials_jobs(FvCheck.from_dict(given), map_digest(ENV3.text)).values())


@pytest.fixture(scope="module")
def gains(jobs: list, tmp_path_factory: pytest.TempPathFactory) -> list[Gains]:
    folder, worlds = tmp_path_factory.mktemp("trials"), {MAP: ENV3}
    results = []
    for job in jobs:
        path = folder / Path(job.place).name
        store.write(path, job, job.run(worlds), worlds)
        results.append(store.read(path, job))
    return gains_of(results)


def test_a_result_of_another_job_is_refused(jobs: list, tmp_path: Path) -> None:
    job, worlds = msgspec.structs.replace(jobs[1], seeds=1, library_trials=5), {MAP: ENV3}
    store.write(tmp_path / "x.h5", job, job.run(worlds), worlds)
    with pytest.raises(UserError, match="library_trials 5, not 100"):
        store.read(tmp_path / "x.h5", msgspec.structs.replace(job, library_trials=100))
    with pytest.raises(UserError, match="its seeds are not 0, 1, 2"):
        store.write(tmp_path / "y.h5", job, job.run(worlds) | {"seeds": np.array([1])}, worlds)


def test_table_and_figure_say_what_the_files_say(gains: list[Gains]) -> None:
    how = Resampling(0.95, 200)
    frame, curves = gain_frame(gains, how), figure.gain_frame(gains, how)
    rows, last = frame.set_index("name"), curves[curves["trials"] == 60].set_index("name")
    for item in gains:
        assert item.mean_gain[:, -1] == pytest.approx(item.gain.mean(axis=1))
        row = rows.loc[item.library.name]
        assert row["gain"] == pytest.approx(item.gain.mean())
        assert row["ci_low"] <= row["gain"] <= row["ci_high"]
        assert last.loc[item.library.name, "gain"] == pytest.approx(item.gain.mean())
    assert rows.loc["library_1234", "difference"] == pytest.approx(rows.loc["library_1234", "gain"] - 0.25)
    assert np.isnan(rows.loc["q_learning", "published"])
    assert last["published"].tolist()[1:] == [0.07, 0.25, 0.275]
    assert curves.loc[curves["trials"] < 60, "published"].isna().all()
    table = gain_table(frame, 0.95, 100)
    for text in (to_markdown(table), to_html(table)):
        assert "noise on its position" in text, "the known difference is stated"
        assert "over 100 trials" in text
        assert number(rows.loc["library_234", "gain"]) in text


@pytest.mark.parametrize(
    ("limits", "words"),
    [
        ((0.2, 0.3), ("2 of 2 published values lie in our interval", "least is the same.")),
        ((0.27, 0.3), ("1 of 2 published values", "does not show that our policy reuse behaves as its authors'")),
        ((np.nan, np.nan), ("fewer than 5 seeds there is no interval", "does not show")),
    ],
)
def test_the_sentence_on_agreement_follows_from_the_numbers(limits, words) -> None:
    frame = pd.DataFrame({"library": ["one", "two"], "gain": [0.25, 0.29], "published": [0.21, 0.28]})
    sentence = agreement(frame.assign(ci_low=limits[0], ci_high=limits[1]))
    assert all(word in sentence for word in words)
    assert ("does not show" in sentence) == any("does not show" in word for word in words)


def test_the_page_of_the_study_tells_the_published_numbers() -> None:
    published = read_csv(ROOT / "reports/fv_check/table.csv").dropna(subset=["published"])
    text = " ".join((ROOT / "studies/fv_check/README.md").read_text().split())
    ours = [f"{gain:.2f}" for gain in published["gain"]]
    assert f"{ours[0]}, {ours[1]} and {ours[2]} here, 0.07, 0.25 and 0.275 there" in text


# -- the workflow -------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_the_workflow_makes_remakes_and_refuses(tmp_path: Path) -> None:
    project = Project(tmp_path, None)
    project.add_study("fv_check")
    config = tmp_path / "studies/fv_check/config/fv_check.yaml"
    brief = yaml.safe_load(config.read_text()) | {"seeds": 2, "trials": 20, "library_trials": 20}
    config.write_text(yaml.safe_dump(brief))
    arguments = ("--snakefile", "studies/fv_check/Snakefile")
    project.make(*arguments)
    assert project.waiting(*arguments) == {}
    assert "are whole" in project.ptl("verify", "results/fv_check").stdout
    products = project.files("reports/fv_check")
    assert len(products) == 7
    (tmp_path / "reports/fv_check/table.csv").write_text("edited\n")
    assert "report_gains" in project.waiting(*arguments)
    config.write_text(yaml.safe_dump(brief | {"root_seed": 7}))
    assert project.waiting(*arguments)["learn_trials"] == 4
    config.write_text(yaml.safe_dump(brief | {"trials": 0}))
    [line] = errors_of(project.snakemake("-n", *arguments))
    assert "trials" in line
    config.write_text(yaml.safe_dump(brief))
    project.make(*arguments)
    assert project.files("reports/fv_check") == products
