"""Per-seed measures: worked examples, and reading learning files one at a time."""

from __future__ import annotations

from contextlib import contextmanager
from types import SimpleNamespace

import h5py
import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from ptl.config import Parameters
from ptl.errors import UserError
from ptl.files.results import write_learning
from ptl.learning.life import learn_life, tasks_of
from ptl.measures import measures, statistics
from ptl.measures.measures import MEASURES, Curves
from ptl.world.gridworld import GridWorld

BASE = np.array([[100, 50, 10, 10], [200, 30, 20, 10]])
METHOD = np.array([[60, 20, 10, 10], [230, 60, 10, 40]])
CORRIDOR = "I...A\n#.###\n#B.C#\n"
STEPS = arrays.arrays(np.int64, (3, 12), elements=st.integers(1, 1000))


def curves(steps, base=None, shortest_path=4, window=2, factor=1.5):
    steps = np.asarray(steps)
    return Curves(
        steps=steps, base=base, truncated=np.zeros(len(steps), dtype=int), shortest_path=shortest_path, window=window,
        threshold_factor=factor,
    )  # fmt: skip


def test_worked_example():
    both = curves(METHOD, BASE)
    assert measures.first_episode(both).tolist() == [60, 230]
    assert measures.jump_start(both).tolist() == [40, -30]
    assert measures.asymptotic(both).tolist() == [10, 25]
    assert measures.total_steps(both).tolist() == [100, 340]


def test_transfer_ratio_is_positive_for_fewer_steps():
    assert measures.transfer_ratio(curves(METHOD, BASE)).tolist() == pytest.approx([70 / 170, -80 / 260])


@given(STEPS)
def test_a_method_equal_to_its_base_transfers_nothing(steps):
    assert not measures.jump_start(curves(steps, steps)).any()
    assert not measures.transfer_ratio(curves(steps, steps)).any()


def test_threshold_episode_counts_the_episode_that_completes_the_window():
    # Shortest path 4, factor 1.5: the mean of two episodes must be at most 6.
    found = measures.threshold_episode(curves([[9, 8, 6, 6, 9], [6, 6, 9, 9, 9], [9, 3, 9, 9, 9], [9, 9, 9, 9, 9]]))
    assert found[:3].tolist() == [4, 2, 2]
    assert np.isnan(found[3])


def test_threshold_is_reached_by_exactly_the_threshold_and_not_above_it():
    found = measures.threshold_episode(curves([[15] * 10, [15] * 9 + [16]], shortest_path=10, window=10))
    assert found[0] == 10
    assert np.isnan(found[1])


@given(STEPS, st.integers(1, 12), st.integers(1, 500))
def test_threshold_episode_against_a_plain_loop(steps, window, shortest):
    expected = []
    for row in steps:
        ends = [e for e in range(window, len(row) + 1) if np.mean(row[e - window : e]) <= 1.5 * shortest]
        expected.append(ends[0] if ends else np.nan)
    found = measures.threshold_episode(curves(steps, shortest_path=shortest, window=window))
    np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize("window", [0, 5])
def test_window_longer_than_a_task_is_refused(window):
    with pytest.raises(UserError, match=r"measures\.window"):
        curves(BASE, window=window)


# -- the registry --------------------------------------------------------------------------------------------


def test_whole_measures_are_stored_as_whole_numbers(shelf):
    shelf.put("no_transfer", 0, [100, 50, 4])
    frame = measure(shelf).per_seed
    for name in measures.PER_SEED_COLUMNS[4:]:
        assert frame[name].dtype == ("Int64" if measures.BY_NAME[name].whole else "float64")


def test_columns_keep_their_order():
    assert measures.PER_SEED_COLUMNS == (
        "environment", "task", "method", "seed", "first_episode", "asymptotic", "threshold_episode", "total_steps",
        "jump_start", "transfer_ratio", "truncated",
    )  # fmt: skip


@pytest.mark.parametrize("measure", MEASURES, ids=lambda measure: measure.name)
def test_a_definition_is_complete(measure):
    assert measures.BY_NAME[measure.name] is measure, "the name is its own"
    assert measure.function or measure.saves, "neither a function nor a saving that a ratio of means could express"
    assert measures.BY_NAME[measure.compared_by].function
    if measure.function:
        column = measure.column(curves(METHOD, BASE))
        assert column.shape == (2,)
        if measure.whole:
            np.testing.assert_array_equal(column[np.isfinite(column)], np.round(column[np.isfinite(column)]))


def test_one_entry_adds_a_measure_to_both_tables(monkeypatch, shelf):
    longest = measures.Measure(
        "longest", "Longest episode", "steps", "lower", lambda curves: curves.steps.max(axis=1), "total", whole=True
    )
    monkeypatch.setattr(measures, "PER_SEED", (*measures.PER_SEED, longest))
    monkeypatch.setattr(statistics, "SUMMARISED", (*statistics.SUMMARISED, longest))
    for seed in range(3):
        shelf.put("no_transfer", seed, [100, 50, 4 + seed])
        shelf.put("ptl", seed, [40 + seed, 10, 8])
    frame = measure(shelf).per_seed
    assert frame["longest"].tolist() == [100, 100, 100, 40, 41, 42]
    metrics = statistics.summarise(frame, statistics.Resampling(0.95, 100)).set_index(["method", "metric"])
    assert metrics.loc[("ptl", "longest"), "mean"] == 41


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


def test_tasks_keep_the_order_in_which_they_were_learned(shelf):
    for seed in (0, 1):
        for task in "CAB":
            shelf.put("no_transfer", seed, [9, 9, 9], task=task)
            shelf.put("ptl", seed, [9, 9, 9], task=task, library=[])
    found = measure(shelf)
    assert found.per_seed["task"].unique().tolist() == ["C", "A", "B"]
    assert found.subgoals[["seed", "task"]].to_numpy().tolist() == [[seed, task] for seed in (0, 1) for task in "CAB"]


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


def test_a_seed_without_its_base_is_compared_with_nothing():
    """As in a setting of the robustness study in which the base was given up."""
    world = GridWorld.from_text(CORRIDOR)

    def runs(method, seeds):
        steps = np.array([[9 + seed, 9, 9] for seed in range(seeds)])
        return measures.Runs("tiny", method, "A", np.arange(seeds), steps, np.zeros(seeds, dtype=int))

    for base, ptl, compared in ((1, 2, False), (2, 1, True)):
        found = measures.measure([runs("no_transfer", base), runs("ptl", ptl)], {"tiny": world}, 2, 1.5)
        assert found.per_seed.query("method == 'ptl'")["jump_start"].notna().all() == compared


def test_no_runs_give_empty_tables():
    found = measures.measure([], {}, 2, 1.5)
    assert found.per_seed.empty
    assert tuple(found.per_seed.columns) == measures.PER_SEED_COLUMNS


def test_no_file_at_all_is_refused():
    with pytest.raises(UserError, match="at least one"):
        measures.measure_files([], 2, 1.5)


# -- real files -------------------------------------------------------------------------------


def test_learning_files_give_the_measures_of_their_lives(tmp_path):
    world = GridWorld.from_text(CORRIDOR)
    parameters = Parameters.from_dict({"learning": {"episodes": 12}, "subgoals": {"trajectories": 5}})
    lives, paths = {}, []
    for method in ("no_transfer", "ptl"):
        for seed in (0, 1):
            life = learn_life(world, tasks_of(world, "CA"), method, parameters, 7, "tiny", seed)
            origin = {"environment": "tiny", "method": method, "seed": seed, "root_seed": 7, "code": "0" * 16}
            paths.append(tmp_path / f"{method}_{seed}.h5")
            write_learning(paths[-1], life, world, origin | {"parameters": parameters.to_dict()})
            lives[method, seed] = life
    found = measures.measure_files(paths, 3, 1.5)
    assert len(found.per_seed) == 2 * 2 * 2
    assert found.per_seed["task"].unique().tolist() == ["C", "A"]
    for row in found.per_seed.itertuples():
        record = lives[row.method, row.seed].records["CA".index(row.task)]
        assert row.first_episode == record.steps[0]
        assert row.total_steps == record.steps.sum()
        base = lives["no_transfer", row.seed].records["CA".index(row.task)].steps
        assert row.transfer_ratio == pytest.approx(1 - record.steps.sum() / base.sum())
    assert set(found.subgoals["method"]) == {"ptl"}
    measures.write_steps(tmp_path / "steps.h5", found)
    with h5py.File(tmp_path / "steps.h5") as file:
        assert file.attrs["seeds"].tolist() == [0, 1]
        assert file["tiny/ptl/C"].dtype == np.int64
        np.testing.assert_array_equal(file["tiny/ptl/C"][1], lives["ptl", 1].records[0].steps)
