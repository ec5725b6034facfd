"""Per-seed measures: worked examples, and reading learning files one at a time."""

from __future__ import annotations

from contextlib import contextmanager
from types import SimpleNamespace

import h5py
import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from ptl import measures
from ptl.commands.measure import command
from ptl.errors import UserError
from ptl.gridworld import GridWorld
from ptl.learning import learn_life, tasks_of
from ptl.parameters import Parameters
from ptl.provenance import code_digest
from ptl.store import write_learning

BASE = np.array([[100, 50, 10, 10], [200, 30, 20, 10]])
METHOD = np.array([[60, 20, 10, 10], [230, 60, 10, 40]])
CORRIDOR = "I...A\n#.###\n#B.C#\n"
STEPS = arrays.arrays(np.int64, (3, 12), elements=st.integers(1, 1000))


def test_worked_example():
    assert measures.first_episode(METHOD).tolist() == [60, 230]
    assert measures.jump_start(METHOD, BASE).tolist() == [40, -30]
    assert measures.asymptotic(METHOD, window=2).tolist() == [10, 25]
    assert measures.total_steps(METHOD).tolist() == [100, 340]


def test_jump_start_percent_is_of_the_mean_of_the_base():
    assert measures.jump_start_percent(METHOD, BASE) == pytest.approx(100 * 5 / 150)


def test_transfer_ratio_is_positive_for_fewer_steps():
    assert measures.transfer_ratio(METHOD, BASE).tolist() == pytest.approx([70 / 170, -80 / 260])


@given(STEPS)
def test_a_method_equal_to_its_base_transfers_nothing(steps):
    assert not measures.jump_start(steps, steps).any()
    assert not measures.transfer_ratio(steps, steps).any()


def test_threshold_episode_counts_the_episode_that_completes_the_window():
    # Shortest path 4, factor 1.5: the mean of two episodes must be at most 6.
    steps = np.array([[9, 8, 6, 6, 9], [6, 6, 9, 9, 9], [9, 3, 9, 9, 9], [9, 9, 9, 9, 9]])
    found = measures.threshold_episode(steps, shortest_path=4, window=2, factor=1.5)
    assert found[:3].tolist() == [4, 2, 2]
    assert np.isnan(found[3])


def test_threshold_is_reached_by_exactly_the_threshold_and_not_above_it():
    steps = np.array([[15] * 10, [15] * 9 + [16]])
    found = measures.threshold_episode(steps, shortest_path=10, window=10, factor=1.5)
    assert found[0] == 10
    assert np.isnan(found[1])


@given(STEPS, st.integers(1, 12), st.integers(1, 500))
def test_threshold_episode_against_a_plain_loop(steps, window, shortest):
    expected = []
    for row in steps:
        ends = [e for e in range(window, len(row) + 1) if np.mean(row[e - window : e]) <= 1.5 * shortest]
        expected.append(ends[0] if ends else np.nan)
    found = measures.threshold_episode(steps, shortest, window, 1.5)
    np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize("window", [0, 5])
def test_window_longer_than_a_task_is_refused(window):
    with pytest.raises(UserError, match=r"measures\.window"):
        measures.asymptotic(BASE, window)
    with pytest.raises(UserError, match=r"measures\.window"):
        measures.threshold_episode(BASE, 4, window, 1.5)


# -- learning files ------------------------------------------------------------------------------------------


class Shelf:
    """Learning files in memory, which fails if two are open together."""

    def __init__(self):
        self.files = {}
        self.open = 0

    def put(self, method, seed, steps, environment="tiny", text=CORRIDOR, task="A", library=None, **details):
        world = GridWorld.from_text(text)
        steps = np.asarray(steps)
        view = {
            "steps": steps,
            "truncated": steps == 99,
            "start": world.start,
            "goal": world.goals[task],
            "subgoal": -1,
            "novelty": 0.0,
            "incremental": np.zeros(world.n_states),
            "original": np.zeros(world.n_states),
            "reason": "no rest",
        }
        name = f"{environment}-{method}-{seed}-{task}-{len(self.files)}"
        self.files[name] = SimpleNamespace(
            environment=environment, method=method, seed=seed, world=world, library=library,
            tasks={task: SimpleNamespace(**view | details)},
        )  # fmt: skip
        return name

    @contextmanager
    def opener(self, path):
        self.open += 1
        assert self.open == 1, "two learning files open at once"
        yield self.files[str(path)]
        self.open -= 1


@pytest.fixture
def shelf(monkeypatch):
    shelf = Shelf()
    monkeypatch.setattr(measures, "open_learning", shelf.opener)
    return shelf


def measure(shelf, **options):
    return measures.measure_files(shelf.files, **{"window": 2, "threshold_factor": 1.5} | options)


def test_frame_pairs_each_seed_with_its_base(shelf):
    shelf.put("ptl", 1, [70, 5, 5])
    shelf.put("no_transfer", 0, [100, 99, 99])
    shelf.put("no_transfer", 1, [200, 20, 20])
    shelf.put("ptl", 0, [40, 10, 8])
    frame = measure(shelf).per_seed
    assert tuple(frame.columns) == measures.PER_SEED_COLUMNS
    assert frame[["method", "seed"]].to_numpy().tolist() == [
        ["ptl", 0], ["ptl", 1], ["no_transfer", 0], ["no_transfer", 1],
    ]  # fmt: skip
    assert frame["jump_start"].tolist() == [60, 130, 0, 0]
    assert frame["transfer_ratio"].tolist() == pytest.approx([1 - 58 / 298, 1 - 80 / 240, 0, 0])
    assert frame["truncated"].tolist() == [0, 0, 2, 0]
    # A is 4 steps away: a mean of 5 passes, a mean of 9 does not.
    assert frame["threshold_episode"].isna().tolist() == [True, False, True, True]
    assert frame["threshold_episode"][1] == 3


def test_without_the_base_comparisons_are_empty(shelf):
    shelf.put("ptl", 0, [40, 10, 8])
    frame = measure(shelf).per_seed
    assert frame["jump_start"].isna().all()
    assert frame["transfer_ratio"].isna().all()
    assert frame["total_steps"].tolist() == [58]


def test_another_method_changes_no_number(shelf):
    shelf.put("no_transfer", 0, [100, 50, 4])
    shelf.put("ptl", 0, [40, 10, 8])
    before = measure(shelf).per_seed
    shelf.put("full_transfer", 0, [900, 100, 100])
    after = measure(shelf).per_seed
    kept = after[after["method"] != "full_transfer"].reset_index(drop=True)
    pd.testing.assert_frame_equal(before, kept)


def test_subgoals_only_of_methods_with_a_library(shelf):
    world = GridWorld.from_text(CORRIDOR)
    door = world.state_at(1, 1)
    metric = np.zeros(world.n_states)
    metric[door] = 0.7
    whole = np.zeros(world.n_states)
    whole[2] = 0.1
    details = {"subgoal": door, "novelty": 3.5, "incremental": metric, "original": whole, "reason": "new"}
    shelf.put("no_transfer", 0, [9, 9, 9])
    shelf.put("ptl", 0, [9, 9, 9], library=[], **details)
    shelf.put("ptl_supervised", 0, [9, 9, 9], library=[])
    frame = measure(shelf).subgoals
    assert tuple(frame.columns) == measures.SUBGOAL_COLUMNS
    assert frame["method"].tolist() == ["ptl", "ptl_supervised"]
    assert frame.loc[0, ["row", "column", "novelty", "metric_value"]].tolist() == [1, 1, 3.5, 0.7]
    assert frame["subgoal"].tolist() == [door, -1]
    assert frame["incremental_peak"].tolist() == [door, -1]
    assert frame["original_peak"].tolist() == [2, -1]
    assert pd.isna(frame.loc[1, "row"])


def test_run_without_any_library_has_an_empty_subgoal_table(shelf):
    shelf.put("no_transfer", 0, [9, 9, 9])
    frame = measure(shelf).subgoals
    assert frame.empty
    assert tuple(frame.columns) == measures.SUBGOAL_COLUMNS


@pytest.mark.parametrize(
    ("put", "message"),
    [
        ({"method": "no_transfer", "seed": 0, "steps": [9, 9, 9]}, "given twice"),
        ({"method": "ptl", "seed": 0, "steps": [9, 9, 9]}, "seed 1 is missing"),
        ({"method": "no_transfer", "seed": 2, "steps": [9, 9]}, "2 and 3 episodes"),
        ({"method": "no_transfer", "seed": 2, "steps": [9] * 3, "text": "I.A\n"}, "another map"),
    ],
)
def test_files_that_do_not_fit_together_are_refused(shelf, put, message):
    shelf.put("no_transfer", 0, [9, 9, 9])
    shelf.put("no_transfer", 1, [9, 9, 9])
    shelf.put(**put)
    with pytest.raises(UserError, match=message):
        measure(shelf)


def test_base_that_lacks_a_task_is_refused(shelf):
    shelf.put("no_transfer", 0, [9, 9, 9])
    shelf.put("ptl", 0, [9, 9, 9], task="B")
    with pytest.raises(UserError, match="no_transfer has no task B"):
        measure(shelf)


def test_no_file_at_all_is_refused():
    with pytest.raises(UserError, match="at least one"):
        measures.measure_files([], 2, 1.5)


# -- the command on real files -------------------------------------------------------------------------------


def test_command_measures_learning_files(tmp_path):
    world = GridWorld.from_text(CORRIDOR)
    parameters = Parameters.from_dict({"learning": {"episodes": 12}, "subgoals": {"trajectories": 5}})
    lives = {}
    for method in ("no_transfer", "ptl"):
        for seed in (0, 1):
            life = learn_life(world, tasks_of(world, "AC"), method, parameters, 7, "tiny", seed)
            origin = {"environment": "tiny", "method": method, "seed": seed, "root_seed": 7}
            origin |= {"parameters": parameters.to_dict(), "code": code_digest("ptl.learning", f"ptl.methods.{method}")}
            write_learning(tmp_path / method / f"seed_{seed:03d}.h5", life, world, origin)
            lives[method, seed] = life
    ranges = [str(tmp_path / method / "seed_[0-1].h5") for method in ("no_transfer", "ptl")]
    out = {name: str(tmp_path / name) for name in ("per_seed.csv", "steps.h5", "subgoals.csv")}
    result = CliRunner().invoke(
        command,
        [*ranges, "--output-per-seed", out["per_seed.csv"],
         "--output-steps", out["steps.h5"], "--output-subgoals", out["subgoals.csv"],
         "--window", "3", "--threshold-factor", "1.5"],
        catch_exceptions=False,
    )  # fmt: skip
    assert result.exit_code == 0, result.output
    frame = pd.read_csv(out["per_seed.csv"])
    assert len(frame) == 2 * 2 * 2
    for row in frame.itertuples():
        record = lives[row.method, row.seed].records["AC".index(row.task)]
        assert row.first_episode == record.steps[0]
        assert row.total_steps == record.steps.sum()
        base = lives["no_transfer", row.seed].records["AC".index(row.task)].steps
        assert row.transfer_ratio == pytest.approx(1 - record.steps.sum() / base.sum(), abs=1e-5)
    with h5py.File(out["steps.h5"]) as file:
        assert file.attrs["seeds"].tolist() == [0, 1]
        assert file["tiny/ptl/C"].dtype == np.int64
        np.testing.assert_array_equal(file["tiny/ptl/C"][1], lives["ptl", 1].records[1].steps)
    assert set(pd.read_csv(out["subgoals.csv"])["method"]) == {"ptl"}
