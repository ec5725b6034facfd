"""Estimates: worked examples, properties of the intervals, and independence of the rest of a run."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from scipy import stats

from ptl.errors import UserError
from ptl.measures import statistics
from ptl.measures.coverage import coverage
from ptl.measures.run_files import read_per_seed
from ptl.measures.statistics import Resampling, named_generator, summarise

HOW = Resampling(confidence=0.95, resamples=500)
COUNTS = arrays.arrays(np.int64, st.integers(5, 20), elements=st.integers(1, 10_000))


def generator(*names):
    return named_generator("test", *names)


def per_seed(methods, task="B", environment="tiny", thresholds=None):
    """Frame of first episodes and totals, paired with no_transfer; asymptotic is the total over 100."""
    base_first, base_total = (np.array(values) for values in methods["no_transfer"])
    frames = []
    for method, (first, total) in methods.items():
        first, total = np.array(first), np.array(total)
        reached = (thresholds or {}).get(method, [20.0] * len(first))
        frames.append(
            pd.DataFrame(
                {
                    "environment": environment,
                    "task": task,
                    "method": method,
                    "seed": range(len(first)),
                    "first_episode": first,
                    "asymptotic": total / 100,
                    "threshold_episode": reached,
                    "total_steps": total,
                    "jump_start": base_first - first,
                    "transfer_ratio": (base_total - total) / base_total,
                    "truncated": 0,
                }
            )
        )
    return pd.concat(frames, ignore_index=True)


RUN = {
    "no_transfer": ([100, 120, 90, 130], [1000, 1200, 900, 1300]),
    "ptl": ([20, 30, 10, 25], [100, 300, 250, 200]),
}


def pick(metrics, method, metric):
    row = metrics[(metrics["method"] == method) & (metrics["metric"] == metric)]
    assert len(row) == 1
    return row.iloc[0]


# -- single estimates ----------------------------------------------------------------------------------------


@given(COUNTS)
@settings(max_examples=50, deadline=None)
def test_interval_contains_the_mean_and_stays_in_the_range(values):
    found = statistics.mean(values, HOW, generator())
    slack = 1e-9 * values.max()
    assert found.value == pytest.approx(values.mean())
    assert values.min() - slack <= found.low <= found.value + slack
    assert found.value - slack <= found.high <= values.max() + slack


def test_interval_of_a_normal_sample_is_near_the_known_one():
    values = np.random.default_rng(1).normal(50, 10, 400)
    found = statistics.mean(values, Resampling(0.95, 4000), generator())
    half = 1.96 * values.std(ddof=1) / 20
    assert found.low == pytest.approx(values.mean() - half, abs=0.1)
    assert found.high == pytest.approx(values.mean() + half, abs=0.1)


def test_higher_confidence_gives_a_wider_interval():
    values = np.array([3, 8, 1, 9, 12, 5, 7])
    narrow = statistics.mean(values, Resampling(0.5, 2000), generator())
    wide = statistics.mean(values, Resampling(0.99, 2000), generator())
    assert wide.low < narrow.low < narrow.high < wide.high


def test_equal_values_have_an_interval_of_no_width():
    found = statistics.mean(np.full(5, 7), HOW, generator())
    assert (found.value, found.low, found.high) == (7, 7, 7)


@pytest.mark.parametrize("values", [[7], [7, 7], [6, 8], [1, 9, 4, 14]])
def test_fewer_than_five_values_have_no_interval(values):
    values = np.array(values)
    for found in (
        statistics.mean(values, HOW, generator()),
        statistics.ratio_of_means(values, values + 1, HOW, generator()),
        statistics.probability_of_improvement(values, np.arange(30), "lower", HOW, generator()),
        statistics.share(1, len(values), HOW),
    ):
        assert np.isfinite(found.value)
        assert np.isnan([found.low, found.high]).all()
    five = statistics.mean(np.array([1, 9, 4, 14, 2]), HOW, generator())
    assert five.low < five.value < five.high


def test_no_value_has_nothing():
    assert np.isnan(statistics.mean(np.array([]), HOW, generator()).value)


def test_where_bca_is_undefined_the_interval_is_still_finite():
    # Leaving one value out never moves the middle half, so BCa's acceleration is 0 / 0.
    values = np.array([1] + [5] * 10 + [9])
    found = statistics.interquartile_mean(values, HOW, generator())
    assert found.value == 5
    assert np.isfinite([found.low, found.high]).all()
    assert found.low <= 5 <= found.high


@pytest.mark.parametrize("at_once", [1, 100, 10**9])
def test_resampling_in_parts_moves_no_bit(at_once: int, monkeypatch):
    values = generator().exponential(size=(2, 23)) ** 3
    expected = [
        statistics.mean(values[0], HOW, generator()),
        statistics.ratio_of_means(values[0], values[1], HOW, generator()),
        statistics.probability_of_improvement(values[0], values[1], "lower", HOW, generator()),
    ]
    monkeypatch.setattr(statistics, "VALUES_AT_ONCE", at_once)
    assert expected == [
        statistics.mean(values[0], HOW, generator()),
        statistics.ratio_of_means(values[0], values[1], HOW, generator()),
        statistics.probability_of_improvement(values[0], values[1], "lower", HOW, generator()),
    ]


@pytest.mark.parametrize("number", [1, 4, 7, 30, 101])
def test_interquartile_mean_is_that_of_scipy_to_the_bit(number: int):
    values = generator().exponential(size=(20, number)) ** 3
    found = statistics._interquartile_mean(values)
    assert found.tolist() == stats.trim_mean(values, statistics.TRIMMED_SHARE, axis=-1).tolist()
    assert statistics._interquartile_mean(values.T, axis=0).tolist() == found.tolist()


def test_interquartile_mean_leaves_out_a_quarter_at_either_end():
    found = statistics.interquartile_mean(np.array([1000, 2, 3, 4, 5, 6, 7, -500]), HOW, generator())
    assert found.value == 4.5


def test_pairing_narrows_a_difference():
    base = np.array([10, 200, 3000, 40, 5000, 60])
    found = statistics.mean_difference(base - 5, base, HOW, generator())
    assert (found.value, found.low, found.high) == (-5, -5, -5)


def test_ratio_of_means_is_not_the_mean_of_ratios():
    saved, base = np.array([90, -10]), np.array([100, 10])
    assert np.mean(saved / base) == pytest.approx(-0.05)
    assert statistics.ratio_of_means(saved, base, HOW, generator()).value == pytest.approx(80 / 110)


def test_ratio_of_means_is_paired():
    base = np.array([10.0, 200, 3000, 40, 5000, 60])
    found = statistics.ratio_of_means(base * 0.25, base, HOW, generator())
    assert (found.low, found.high) == pytest.approx((0.25, 0.25))


def test_probability_of_improvement_by_hand():
    # Cross pairs (1 < 2), (1 < 3), (2 = 2), (2 < 3): three wins and one tie of four.
    own, base = np.array([1, 2]), np.array([2, 3])
    assert statistics.probability_of_improvement(own, base, "lower", HOW, generator()).value == 3.5 / 4
    assert statistics.probability_of_improvement(own, base, "higher", HOW, generator()).value == 0.5 / 4


def test_probability_of_improvement_of_the_same_values_is_one_half():
    values = np.array([4, 8, 15, 16, 23, 42])
    found = statistics.probability_of_improvement(values, values, "lower", HOW, generator())
    assert found.value == 0.5
    assert found.low < 0.5 < found.high


def test_probability_of_improvement_takes_infinity_as_the_worst_value():
    own, base = np.array([50, np.inf]), np.array([np.inf, np.inf])
    assert statistics.probability_of_improvement(own, base, "lower", HOW, generator()).value == 0.75


@given(COUNTS, COUNTS)
@settings(max_examples=30, deadline=None)
def test_the_two_directions_add_up_to_one(own, base):
    lower = statistics.probability_of_improvement(own, base, "lower", HOW, generator())
    higher = statistics.probability_of_improvement(own, base, "higher", HOW, generator())
    assert lower.value + higher.value == pytest.approx(1)
    assert 0 <= lower.low <= lower.value <= lower.high <= 1


def test_share_has_the_wilson_interval():
    # Wilson for 18 of 30 and z = 1.959964, computed by hand.
    z = 1.959964
    centre, half = (18 + z * z / 2) / (30 + z * z), z / (30 + z * z) * np.sqrt(18 * 12 / 30 + z * z / 4)
    found = statistics.share(18, 30, HOW)
    assert (found.value, found.low, found.high) == pytest.approx((0.6, centre - half, centre + half), abs=1e-6)


@pytest.mark.parametrize(("confidence", "resamples"), [(0, 10), (1, 10), (95, 10), (0.95, -1)])
def test_impossible_settings_are_refused(confidence, resamples):
    with pytest.raises(UserError, match=r"statistics\."):
        Resampling(confidence, resamples)


# -- all estimates -------------------------------------------------------------------------------------------


def test_summary_of_the_worked_example():
    metrics = summarise(per_seed(RUN), HOW)
    assert tuple(metrics.columns) == statistics.COLUMNS
    total = pick(metrics, "ptl", "total_steps")
    assert total["mean"] == 212.5
    assert total["std"] == pytest.approx(np.std([100, 300, 250, 200], ddof=1))
    assert (total["n"], total["seeds"]) == (4, 4)
    assert total["improvement"] == 1
    assert pick(metrics, "ptl", "jump_start")["mean"] == np.mean([80, 90, 80, 105])
    assert pick(metrics, "ptl", "jump_start_percent")["mean"] == pytest.approx(100 * 355 / 440)
    ratios = [0.9, 0.75, 1 - 250 / 900, 1 - 200 / 1300]
    assert pick(metrics, "ptl", "transfer_ratio")["mean"] == pytest.approx(np.mean(ratios))
    assert pick(metrics, "ptl", "transfer_ratio_of_means")["mean"] == pytest.approx(1 - 850 / 4400)


def test_probability_of_jump_start_compares_first_episodes():
    run = {"no_transfer": ([100, 10], [200, 200]), "ptl": ([50, 5], [200, 200])}
    metrics = summarise(per_seed(run), HOW)
    # Every seed improves on its own pair, but of the cross pairs only 50 < 100, 5 < 100 and 5 < 10 do.
    assert pick(metrics, "ptl", "jump_start")["improvement"] == 0.75
    assert pick(metrics, "ptl", "transfer_ratio")["improvement"] == 0.5


def test_threshold_is_never_averaged_in_silence():
    thresholds = {"no_transfer": [np.nan] * 4, "ptl": [30.0, np.nan, 50.0, np.nan]}
    metrics = summarise(per_seed(RUN, thresholds=thresholds), HOW)
    some, none = pick(metrics, "ptl", "threshold_episode"), pick(metrics, "no_transfer", "threshold_episode")
    assert (some["mean"], some["n"], some["seeds"], some["reached"]) == (40, 2, 4, 0.5)
    assert np.isnan(none["mean"])
    assert (none["n"], none["reached"]) == (0, 0)
    assert some["improvement"] == 0.75
    others = metrics[metrics["metric"] != "threshold_episode"]
    assert others["reached"].isna().all()


def test_another_method_task_or_environment_changes_no_number():
    alone = summarise(per_seed(RUN), HOW)
    more = per_seed(RUN | {"full_transfer": ([500, 10, 30, 40], [5000, 600, 700, 800])})
    other = per_seed(RUN, task="C"), per_seed(RUN, environment="huge")
    together = summarise(pd.concat([*other, more], ignore_index=True), HOW)
    kept = (together["environment"] == "tiny") & (together["task"] == "B")
    kept &= together["method"] != "full_transfer"
    pd.testing.assert_frame_equal(together[kept].reset_index(drop=True), alone)


def test_summary_is_deterministic_and_names_have_streams_of_their_own():
    pd.testing.assert_frame_equal(summarise(per_seed(RUN), HOW), summarise(per_seed(RUN), HOW))
    assert generator("a").random() == generator("a").random()
    assert generator("a").random() != generator("b").random()


def test_base_is_not_compared_with_itself():
    metrics = summarise(per_seed(RUN), HOW)
    base = metrics[metrics["method"] == "no_transfer"]
    assert base["improvement"].isna().all()
    ratio = pick(metrics, "no_transfer", "transfer_ratio_of_means")
    assert ratio["mean"] == 0


def test_without_the_base_comparisons_are_empty():
    frame = per_seed(RUN)
    frame = frame[frame["method"] == "ptl"].assign(jump_start=np.nan, transfer_ratio=np.nan)
    metrics = summarise(frame, HOW)
    assert metrics["improvement"].isna().all()
    for metric in ("jump_start", "jump_start_percent", "transfer_ratio", "transfer_ratio_of_means"):
        row = pick(metrics, "ptl", metric)
        assert np.isnan(row["mean"])
        assert row["n"] == 0
    assert pick(metrics, "ptl", "total_steps")["mean"] == 212.5


def test_seed_without_its_base_is_refused():
    frame = per_seed(RUN)
    with pytest.raises(UserError, match="method ptl, seed 2 has no run of no_transfer"):
        summarise(frame[~((frame["method"] == "no_transfer") & (frame["seed"] == 2))], HOW)


def test_row_that_is_there_twice_is_refused():
    frame = per_seed(RUN)
    with pytest.raises(UserError, match="seed 3 is there twice"):
        summarise(pd.concat([frame, frame.tail(1)]), HOW)


def test_missing_column_is_refused():
    with pytest.raises(UserError, match="asymptotic"):
        summarise(per_seed(RUN).drop(columns="asymptotic"), HOW)


def test_per_seed_table_survives_the_file(tmp_path):
    thresholds = {"no_transfer": [np.nan] * 4, "ptl": [30.0, np.nan, 50.0, 60.0]}
    frame = per_seed(RUN, environment="NA", thresholds=thresholds)
    frame.to_csv(tmp_path / "per_seed.csv", index=False)
    read = read_per_seed(tmp_path / "per_seed.csv")
    pd.testing.assert_frame_equal(summarise(read, HOW), summarise(frame, HOW))


def test_rows_keep_their_order():
    assert list(dict.fromkeys(summarise(per_seed(RUN), HOW)["metric"])) == [
        "first_episode", "jump_start", "asymptotic", "threshold_episode", "total_steps", "transfer_ratio",
        "jump_start_percent", "transfer_ratio_of_means", "truncated",
    ]  # fmt: skip


def test_missing_per_seed_table_is_named(tmp_path):
    with pytest.raises(UserError, match=r"nowhere\.csv"):
        read_per_seed(tmp_path / "nowhere.csv")


def test_probability_of_improvement_counts_every_pair_once():
    """Against all pairs written out, for samples of different sizes and in each resample of a batch."""
    random = np.random.default_rng(4)
    lower, upper = random.integers(0, 6, (3, 5, 9)), random.integers(0, 6, (3, 5, 4))
    left, right = lower[..., :, np.newaxis], upper[..., np.newaxis, :]
    expected = ((left < right) + 0.5 * (left == right)).mean(axis=(-2, -1))
    np.testing.assert_allclose(statistics._probability_of_being_lower(lower, upper), expected)
    moved = statistics._probability_of_being_lower(np.moveaxis(lower, -1, 0), np.moveaxis(upper, -1, 0), axis=0)
    np.testing.assert_allclose(moved, expected)


# -- large samples -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["mean", "ratio", "probability"])
def test_large_sample_intervals_are_those_of_resampling(kind: str) -> None:
    random = np.random.default_rng(5)
    one, other = random.gamma(2, 10, 2000), random.gamma(2, 12, 2000)
    estimates = []
    for how in (Resampling(0.95, 4000), Resampling(0.95, 0, normal=True)):
        generator = np.random.default_rng(1)
        if kind == "mean":
            estimates.append(statistics.mean(one, how, generator))
        elif kind == "ratio":
            estimates.append(statistics.ratio_of_means(one, other, how, generator))
        else:
            estimates.append(statistics.probability_of_improvement(one.round(), other.round(), "lower", how, generator))
    resampled, normal = estimates
    assert normal.value == resampled.value
    assert normal.high - normal.low == pytest.approx(resampled.high - resampled.low, rel=0.08)
    assert normal.low == pytest.approx(resampled.low, abs=0.1 * (normal.high - normal.low))


def test_without_resamples_an_interval_is_its_estimate() -> None:
    values = np.arange(5.0)
    assert statistics.mean(values, Resampling(0.95, 0), np.random.default_rng(1)) == statistics.Estimate(2, 2, 2)
    assert statistics.share(1, 4, Resampling(0.95, 0)) == statistics.Estimate(0.25, 0.25, 0.25)


def test_intervals_of_many_samples_are_those_of_each():
    samples = np.random.default_rng(3).lognormal(size=(7, 12))
    how = Resampling(0.9, 200)
    low, high = statistics.mean_intervals(samples, how, np.random.default_rng(5))
    for sample, *ends in zip(samples, low, high, strict=True):
        own = statistics.mean(sample, how, np.random.default_rng(5))
        np.testing.assert_allclose([own.low, own.high], ends)
    low, high = statistics.mean_intervals(np.full((2, 12), 4.0), how, np.random.default_rng(5))
    assert {*low, *high} == {4.0}


def test_coverage_is_near_its_level_for_normal_values_and_falls_with_rare_large_ones():
    random = np.random.default_rng(1)
    usual = random.normal(20, 1, 2000)
    rare = np.where(random.random(2000) < 0.01, 5000.0, usual)
    assert coverage(usual, 30, 0.95, random) == pytest.approx(0.94, abs=0.03)
    # a sample of 30 has none of the rare values with probability 0.99^30
    share = np.mean(rare == 5000.0)
    assert coverage(rare, 30, 0.95, random) <= 1 - (1 - share) ** 30 + 0.07
