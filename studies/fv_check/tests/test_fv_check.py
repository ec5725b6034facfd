"""Fernandez and Veloso's experiment: gains, the library's policies, files, table and figure."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner
from projects import MAPS

from ptl import methods
from ptl.cli.fv import command
from ptl.errors import UserError
from ptl.measures.statistics import Resampling
from ptl.methods._base import BaseMethod
from ptl.report.figures import policy_reuse_experiment as figure
from ptl.report.table import to_html, to_markdown
from ptl.text import number
from ptl.world.gridworld import GridWorld
from studies.fv_check import experiment as fv
from studies.fv_check.page import agreement, gain_frame, gain_table

CORRIDOR = GridWorld.from_text("#####\n#I.F#\n#####\n")


class Walker(BaseMethod):
    """Always goes east."""

    def run_episode(self, learner) -> list[int]:
        learner.follow(np.full(self.world.n_states, 3, dtype=np.int8), self.world.goal("F"))
        return []


def test_gain_is_the_discounted_return_of_a_trial() -> None:
    starts = fv.random_starts(CORRIDOR, 2, 50, np.random.default_rng(0))
    assert set(starts) == {0, 1}, "never the goal itself"
    gains, learner = fv.learn_gains(CORRIDOR, 2, Walker(CORRIDOR, fv.PARAMETERS, None), 40, ("a", 1), 3)
    q = learner.q
    assert set(np.round(gains, 12)) == {1.0, 0.95}, "one step and two steps from the goal"
    assert q[1, 3] > 0


def test_a_trial_ends_after_a_hundred_steps_without_gain() -> None:
    class Stander(Walker):
        def run_episode(self, learner) -> list[int]:
            learner.follow(np.zeros(3, dtype=np.int8), 2)
            assert learner.truncated
            assert learner.steps == 100
            return []

    gains, _ = fv.learn_gains(CORRIDOR, 2, Stander(CORRIDOR, fv.PARAMETERS, None), 3, ("b",), 3)
    assert not gains.any()


def test_quality_of_a_policy(env3: GridWorld) -> None:
    goal = env3.goal("A")
    best = env3.transitions.shortest_path_policy(goal)
    assert fv.policy_quality(env3, best, goal) == pytest.approx(1.0)
    assert fv.policy_quality(env3, np.full(env3.n_states, -1, dtype=np.int8), goal) == 0.0
    assert fv.policy_quality(CORRIDOR, np.array([-1, 3, 0]), 2) == pytest.approx(1 / 1.95)


def test_the_learner_is_that_of_the_main_comparison(env3: GridWorld, monkeypatch: pytest.MonkeyPatch) -> None:
    reuse = methods.load("policy_reuse")
    sizes = []
    original = reuse.run_episode

    def spy(self, learner) -> list[int]:
        sizes.append(len(self.past_policies))
        return original(self, learner)

    monkeypatch.setattr(reuse, "run_episode", spy)
    gains, quality = fv.learn_arm(env3, fv.ARMS["library_234"], 0, 1, trials=20, library_trials=50)
    assert sizes == [3] * 20
    assert gains.shape == (20,)
    assert quality.shape == (3,)


def test_a_past_policy_does_not_depend_on_the_library_it_is_in(env3: GridWorld) -> None:
    _, three = fv.learn_arm(env3, fv.ARMS["library_234"], 4, 1, trials=2, library_trials=400)
    _, four = fv.learn_arm(env3, fv.ARMS["library_1234"], 4, 1, trials=2, library_trials=400)
    _, other = fv.learn_arm(env3, fv.ARMS["library_234"], 5, 1, trials=2, library_trials=400)
    assert three.tolist() == four[1:].tolist()
    assert three.tolist() != other.tolist()


def test_a_good_library_beats_plain_q_learning(env3: GridWorld) -> None:
    """Task 5 lies beside the new task, so its policy helps from the first hundred trials on (source: FV)."""

    def mean(arm: str) -> float:
        return float(np.mean([fv.learn_arm(env3, fv.ARMS[arm], seed, 7, 800, 20_000)[0].mean() for seed in (0, 1)]))

    assert mean("library_2345") > 1.3 * mean("q_learning")


def run(folder: Path, arm: str, seeds: int = 5) -> Path:
    path = folder / f"{arm}.h5"
    result = CliRunner().invoke(
        command,
        ["--map", str(MAPS / "env3.txt"), "--library", arm, "--seeds", str(seeds), "--root-seed", "5",
         "--trials", "60", "--library-trials", "100", "--output", str(path)],
        catch_exceptions=False,
    )  # fmt: skip
    assert result.exit_code == 0
    return path


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    folder = tmp_path_factory.mktemp("fv")
    return [run(folder, arm) for arm in reversed(fv.ARMS)]


def test_equal_jobs_give_equal_bytes(files: list[Path], tmp_path: Path) -> None:
    again = run(tmp_path, files[0].stem)
    assert again.read_bytes() == files[0].read_bytes()


def test_read_in_the_order_of_the_arms_whatever_the_order_of_files(files: list[Path]) -> None:
    gains = fv.read_gains(files)
    assert [item.arm.name for item in gains] == list(fv.ARMS)
    assert all(item.gain.shape == (5, 60) for item in gains)
    item = gains[0]
    assert item.mean_gain[:, -1] == pytest.approx(item.gain.mean(axis=1))


def test_table_says_what_the_files_say(files: list[Path]) -> None:
    gains = fv.read_gains(files)
    frame = gain_frame(gains, Resampling(0.95, 200))
    table = frame.set_index("arm")
    for item in gains:
        row = table.loc[item.arm.name]
        assert row["gain"] == pytest.approx(item.gain.mean())
        assert row["ci_low"] <= row["gain"] <= row["ci_high"]
    assert table.loc["library_1234", "published"] == 0.25
    assert table.loc["library_1234", "difference"] == pytest.approx(table.loc["library_1234", "gain"] - 0.25)
    assert np.isnan(table.loc["q_learning", "published"])
    page = gain_table(frame, 0.95)
    for text in (to_markdown(page), to_html(page)):
        assert "position" in text, "the known difference is stated"
        assert "0.275" in text
        assert number(table.loc["library_234", "gain"]) in text


def test_figure_numbers(files: list[Path]) -> None:
    frame = figure.gain_frame(fv.read_gains(files), Resampling(0.95, 200))
    last = frame[frame["trials"] == 60].set_index("arm")
    assert last.loc["library_2345", "gain"] == pytest.approx(fv.read_gains(files)[-1].gain.mean())
    assert last["published"].tolist()[1:] == [0.07, 0.25, 0.275]
    assert frame.loc[frame["trials"] < 60, "published"].isna().all()


def test_bad_files_are_refused_in_one_line(files: list[Path], tmp_path: Path, env3: GridWorld) -> None:
    damaged = tmp_path / "damaged.h5"
    damaged.write_bytes(files[0].read_bytes())
    with h5py.File(damaged, "r+") as file:
        file["gain"][0, 0] = 0.123
    other = tmp_path / "other.h5"
    fv.run_job(env3, "q_learning", [0], 1, 7, 1, other)
    for paths, words in (
        ([damaged], "checksum"),
        ([tmp_path / "none.h5"], "no such file"),
        ([files[0], files[0]], "given twice"),
        ([files[0], other], "7 and 60 trials"),
    ):
        with pytest.raises(UserError, match=words) as caught:
            fv.read_gains(paths)
        assert "\n" not in str(caught.value)
    with pytest.raises(UserError, match="unknown; known are q_learning"):
        fv.run_job(env3, "library_9", [0], 1, 7, 1, other)


@pytest.mark.parametrize(
    ("limits", "words"),
    [
        ((0.2, 0.3), ("2 of 2 published values lie in our interval", "least is the same.")),
        ((0.27, 0.3), ("1 of 2 published values", "does not show that our policy reuse behaves as its authors'")),
        ((np.nan, np.nan), ("fewer than 5 seeds there is no interval", "does not show")),
    ],
)
def test_the_sentence_on_agreement_follows_from_the_numbers(limits, words):
    frame = pd.DataFrame({"library": ["one", "two"], "gain": [0.25, 0.29], "published": [0.21, 0.28]})
    sentence = agreement(frame.assign(ci_low=limits[0], ci_high=limits[1]))
    assert all(word in sentence for word in words)
    assert ("does not show" in sentence) == any("does not show" in word for word in words)
