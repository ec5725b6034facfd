"""Per-seed measures: worked examples, tables of runs, and learning files."""

from __future__ import annotations

import weakref

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from lives import read_lives, write_life

from ptl.errors import UserError
from ptl.jobs.learn import tasks_in
from ptl.learning.discoveries import SubgoalRow, subgoal_row
from ptl.measures import measures, statistics
from ptl.measures.measures import MEASURES, Curves, Runs
from ptl.measures.run_files import measure_files, read_steps, write_steps
from ptl.world.gridworld import GridWorld

BASE = np.array([[100, 50, 10, 10], [200, 30, 20, 10]])
METHOD = np.array([[60, 20, 10, 10], [230, 60, 10, 40]])
CORRIDOR = GridWorld.from_text("I...A\n#.###\n#B.C#\n", "tiny")
STEPS = arrays.arrays(np.int64, (3, 12), elements=st.integers(1, 1000))


def curves(steps, base=None, optimum=4, window=2, factor=1.5):
    steps = np.asarray(steps)
    return Curves(
        steps=steps, base=base, truncated=np.zeros(len(steps), dtype=int), optimum=optimum, window=window,
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
    found = measures.threshold_episode(curves([[15] * 10, [15] * 9 + [16]], optimum=10, window=10))
    assert found[0] == 10
    assert np.isnan(found[1])


@given(STEPS, st.integers(1, 12), st.integers(1, 500))
def test_threshold_episode_against_a_plain_loop(steps, window, shortest):
    expected = []
    for row in steps:
        ends = [e for e in range(window, len(row) + 1) if np.mean(row[e - window : e]) <= 1.5 * shortest]
        expected.append(ends[0] if ends else np.nan)
    found = measures.threshold_episode(curves(steps, optimum=shortest, window=window))
    np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize("window", [0, 5])
def test_window_longer_than_a_task_is_refused(window):
    with pytest.raises(UserError, match=r"measures\.window"):
        curves(BASE, window=window)


# -- the registry --------------------------------------------------------------------------------------------


def test_whole_measures_are_stored_as_whole_numbers():
    frame = measured(runs("no_transfer", [100, 50, 4])).per_seed
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


def test_one_entry_adds_a_measure_to_both_tables(monkeypatch):
    longest = measures.Measure(
        "longest", "Longest episode", "steps", "lower", lambda curves: curves.steps.max(axis=1), "total", whole=True
    )
    monkeypatch.setattr(measures, "PER_SEED", (*measures.PER_SEED, longest))
    monkeypatch.setattr(statistics, "SUMMARISED", (*statistics.SUMMARISED, longest))
    base = runs("no_transfer", *([100, 50, 4 + seed] for seed in range(3)))
    frame = measured(base, runs("ptl", *([40 + seed, 10, 8] for seed in range(3)))).per_seed
    assert frame["longest"].tolist() == [100, 100, 100, 40, 41, 42]
    metrics = statistics.summarise(frame, statistics.Resampling(0.95, 100)).set_index(["method", "metric"])
    assert metrics.loc[("ptl", "longest"), "mean"] == 41


# -- tables of runs ------------------------------------------------------------------------------------------


def runs(method, *steps, task="A", first_seed=0, kept=None):
    """Runs of consecutive seeds on the corridor; 99 steps are the limit."""
    steps, seeds = np.array(steps), np.arange(first_seed, first_seed + len(steps))
    if kept is not None:
        kept = {name: np.repeat(value, len(steps)) for name, value in kept._asdict().items()}
    return Runs("tiny", method, task, seeds, steps, (steps == 99).sum(axis=1), kept)


def measured(*all_runs):
    return measures.measure(all_runs, {"tiny": CORRIDOR}, 2, 1.5)


@pytest.mark.parametrize(("slip", "reached"), [(0.0, False), (0.2, True)])
def test_threshold_is_a_multiple_of_the_least_expected_steps(slip, reached):
    # One step that slips has its direction with probability 1 - 3/4 slip, so it takes 1.18 steps on average.
    world = GridWorld.from_text("IA\n", "tiny", slip)
    frame = measures.measure([runs("ptl", [2, 1, 2, 1, 2])], {"tiny": world}, 5, 1.5).per_seed
    assert frame["threshold_episode"].notna().tolist() == [reached]


NOTHING = SubgoalRow(-1, 0.0, 0.0, "no rest", -1, -1)


def test_frame_pairs_each_seed_with_its_base():
    base = runs("no_transfer", [100, 99, 99], [200, 20, 20], [300, 20, 20])
    frame = measured(runs("ptl", [70, 5, 5], [60, 10, 8], first_seed=1), base).per_seed
    assert tuple(frame.columns) == measures.PER_SEED_COLUMNS
    assert frame[["method", "seed"]].to_numpy().tolist() == [
        ["ptl", 1], ["ptl", 2], ["no_transfer", 0], ["no_transfer", 1], ["no_transfer", 2],
    ]  # fmt: skip
    assert frame["jump_start"].tolist() == [130, 240, 0, 0, 0]
    assert frame["transfer_ratio"].tolist() == pytest.approx([1 - 80 / 240, 1 - 78 / 340, 0, 0, 0])
    assert frame["truncated"].tolist() == [0, 0, 2, 0, 0]
    # A is 4 steps away: a mean of 5 passes, a mean of 9 does not.
    assert frame["threshold_episode"].isna().tolist() == [False, True, True, True, True]
    assert frame["threshold_episode"][0] == 3


def test_tasks_keep_the_order_in_which_they_were_learned():
    found = measured(
        *(runs("no_transfer", [9, 9, 9], [9, 9, 9], task=task) for task in "CAB"),
        *(runs("ptl", [9, 9, 9], [9, 9, 9], task=task, kept=NOTHING) for task in "CAB"),
    )
    assert found.per_seed["task"].unique().tolist() == ["C", "A", "B"]
    assert found.subgoals[["seed", "task"]].to_numpy().tolist() == [[seed, task] for seed in (0, 1) for task in "CAB"]


@pytest.mark.parametrize(
    "base", [[], [runs("no_transfer", [9, 9, 9])], [runs("no_transfer", [9, 9, 9], [9, 9, 9], task="B")]]
)
def test_without_a_base_of_every_seed_comparisons_are_empty(base):
    frame = measured(runs("ptl", [40, 10, 8], [41, 10, 8]), *base).per_seed.query("method == 'ptl'")
    assert frame["jump_start"].isna().all()
    assert frame["transfer_ratio"].isna().all()
    assert frame["total_steps"].tolist() == [58, 59]


def test_another_method_changes_no_number():
    given = runs("no_transfer", [100, 50, 4]), runs("ptl", [40, 10, 8])
    after = measured(*given, runs("full_transfer", [900, 100, 100])).per_seed
    kept = after[after["method"] != "full_transfer"].reset_index(drop=True)
    pd.testing.assert_frame_equal(measured(*given).per_seed, kept)


def test_subgoals_only_of_methods_with_a_library():
    door = CORRIDOR.state_at(1, 1)
    incremental, original = np.zeros((2, CORRIDOR.n_states))
    incremental[door], original[2] = 0.7, 0.1
    frame = measured(
        runs("no_transfer", [9, 9, 9]),
        runs("ptl", [9, 9, 9], kept=subgoal_row(door, "new", 3.5, incremental, original)),
        runs("ptl_supervised", [9, 9, 9], kept=subgoal_row(-1, "no rest", 0.0, 0 * incremental, 0 * original)),
    ).subgoals
    assert tuple(frame.columns) == measures.SUBGOAL_COLUMNS
    assert frame["method"].tolist() == ["ptl", "ptl_supervised"]
    assert frame.loc[0, ["row", "column", "novelty", "metric_value"]].tolist() == [1, 1, 3.5, 0.7]
    assert frame["subgoal"].tolist() == [door, -1]
    assert frame["incremental_peak"].tolist() == [door, -1]
    assert frame["original_peak"].tolist() == [2, -1]
    assert pd.isna(frame.loc[1, "row"])


def test_what_is_not_there_gives_empty_tables():
    assert tuple(measured(runs("no_transfer", [9, 9, 9])).subgoals.columns) == measures.SUBGOAL_COLUMNS
    assert measured(runs("no_transfer", [9, 9, 9])).subgoals.empty
    assert tuple(measured().per_seed.columns) == measures.PER_SEED_COLUMNS
    assert measured().per_seed.empty


# -- learning files ------------------------------------------------------------------------------------------


def test_learning_files_give_the_measures_of_their_lives(tmp_path):
    paths = [
        write_life(tmp_path, method, seed, world=CORRIDOR, tasks="CA")
        for method in ("no_transfer", "ptl")
        for seed in (0, 1)
    ]
    lives = {(file.job.method, file.job.seed): tasks_in(file) for file in read_lives(*paths)}
    measurements = measure_files(read_lives(*paths), 3, 1.5)
    frame = measurements.per_seed
    assert len(frame) == 2 * 2 * 2 and frame["task"].unique().tolist() == ["C", "A"]
    for row in frame.itertuples():
        steps, base = (lives[method, row.seed][row.task].steps for method in (row.method, "no_transfer"))
        assert (row.first_episode, row.total_steps) == (steps[0], steps.sum())
        assert row.transfer_ratio == pytest.approx(1 - steps.sum() / base.sum())
    assert set(measurements.subgoals["method"]) == {"ptl"}
    for row in measurements.subgoals.itertuples():
        task = lives["ptl", row.seed][row.task]
        assert (row.subgoal, row.reason, row.novelty) == (task.subgoal, task.reason, task.novelty)
    write_steps(tmp_path / "steps.h5", measurements.steps)
    stored = read_steps(tmp_path / "steps.h5")
    assert {*stored} == {("tiny", method, task) for method in ("no_transfer", "ptl") for task in "CA"}
    np.testing.assert_array_equal(stored["tiny", "ptl", "C"], [lives["ptl", seed]["C"].steps for seed in (0, 1)])


def test_files_are_in_memory_one_at_a_time(tmp_path):
    path, tables = write_life(tmp_path, "ptl", world=CORRIDOR), []

    def files():
        for _ in range(4):
            [file] = read_lives(path)
            assert sum(table() is not None for table in tables) <= 1, "more than the one before is kept"
            tables.append(weakref.ref(file.arrays["tasks/A/q"]))
            yield file
            del file

    measure_files(files(), 3, 1.5)


def test_no_file_at_all_is_refused():
    with pytest.raises(UserError, match="at least one"):
        measure_files([], 2, 1.5)
