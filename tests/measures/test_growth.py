"""Growth of the library: its table, the line of two slopes, and the numbers of figure 14."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from lives import QUICK, ROOMS

from ptl.errors import UserError
from ptl.files import store
from ptl.files.csv import write_csv
from ptl.jobs.grow import Grow
from ptl.measures.growth import TwoSlopes, best_bend, fit_saturation, fit_two_slopes, squared_error
from ptl.measures.run_files import library_sizes, read_sizes
from ptl.report.figures.bands import mean_band
from ptl.report.figures.growth import growth_frame
from ptl.world.gridworld import map_digest

TASKS = np.arange(31)


def test_table_of_growth_files(tmp_path: Path) -> None:
    worlds, maps, expected, results = {"rooms": ROOMS}, {"rooms": map_digest(ROOMS.text)}, [], []
    for seed in (0, 1):
        groups = {name: QUICK.to_dict()[name] for name in Grow.READS}
        job = Grow(root_seed=7, parameters=groups, maps=maps, code="0" * 16, environment="rooms", tasks=4, seed=seed)
        store.write(tmp_path / job.place, job, job.run(worlds), worlds)
        results.append(store.read(tmp_path / job.place, job))
        after = results[-1].arrays["library/learned_after"]
        expected.append([np.count_nonzero(after < task) for task in range(5)])
    write_csv(library_sizes(results), tmp_path / "growth.csv")
    np.testing.assert_array_equal(read_sizes(tmp_path / "growth.csv"), expected)
    assert np.max(expected) > 0


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("run,tasks\n0,0\n", "no column 'library_size'"),
        ("run,tasks,library_size\n0,0,0\n0,1,1\n1,0,0\n", "different numbers of tasks"),
        ("run,tasks,library_size\n0,0,0\n0,1,1\n0,1,2\n", "different numbers of tasks"),
        ("run,tasks,library_size\n", "different numbers of tasks, or none"),
        ("", "cannot be read as CSV"),
    ],
)
def test_a_bad_table_is_refused(text: str, words: str, tmp_path: Path) -> None:
    (tmp_path / "growth.csv").write_text(text)
    with pytest.raises(UserError, match=words):
        read_sizes(tmp_path / "growth.csv")


@pytest.mark.parametrize(("before", "after"), [(0.6, 0.1), (0.1, 0.8), (0.3, 0.3)])
def test_fit_recovers_known_slopes_in_noise(before: float, after: float) -> None:
    truth = TwoSlopes(7, 0.2, before, after)(TASKS)
    noise = np.random.default_rng(3).normal(0, 0.1, size=31)
    fit = fit_two_slopes(np.array([truth, truth + noise]), 7)
    assert (fit.intercept[0], fit.before[0], fit.after[0]) == pytest.approx((0.2, before, after))
    assert (fit.before[1], fit.after[1]) == pytest.approx((before, after), abs=0.05)


@pytest.mark.parametrize("bend", [0, 30, 31])
def test_a_bend_without_points_on_both_sides_is_refused(bend: int) -> None:
    with pytest.raises(UserError, match=rf"growth\.breakpoint: {bend} "):
        fit_two_slopes(np.zeros((2, 31)), bend)


def test_slope_intervals_cover_the_slopes() -> None:
    random = np.random.default_rng(5)
    sizes = np.array([TwoSlopes(7, 0, random.normal(0.6, 0.1), random.normal(0.2, 0.05))(TASKS) for _ in range(40)])
    frame = growth_frame(sizes, 7, 0.95, 2000)
    np.testing.assert_allclose(frame["mean"], sizes.mean(axis=0))
    row = frame.iloc[0]
    assert row["slope_before_low"] < row["slope_before"] < row["slope_before_high"]
    assert row["slope_before_high"] - row["slope_before_low"] == pytest.approx(2 * 1.96 * 0.1 / np.sqrt(40), rel=0.4)
    assert row["slope_after_low"] < row["slope_after"] < row["slope_after_high"]


def test_one_run_has_no_interval() -> None:
    frame = growth_frame(np.arange(11.0)[np.newaxis], 7, 0.95, 100)
    limits = [f"{name}_{end}" for name in ("ci", "slope_before", "slope_after") for end in ("low", "high")]
    assert frame[limits].isna().all(axis=None)
    assert frame["slope_after"].iloc[0] == pytest.approx(1)


def test_confidence_and_resamples_act_on_bands_and_slopes() -> None:
    sizes = np.random.default_rng(2).poisson(5, size=(30, 11)).astype(float)
    narrow, wide, coarse = (growth_frame(sizes, 7, *how) for how in ((0.5, 2000), (0.99, 2000), (0.5, 20)))
    for low, high in (("ci_low", "ci_high"), ("slope_before_low", "slope_before_high")):
        assert ((wide[high] - wide[low]) > (narrow[high] - narrow[low])).all()
        assert not np.allclose(coarse[low], narrow[low])


def test_band_is_the_normal_interval_for_many_runs() -> None:
    values = np.random.default_rng(1).normal(5, 2, size=(400, 3))
    mean, low, high = mean_band(values, 0.95, 2000)
    np.testing.assert_allclose(mean, values.mean(axis=0))
    np.testing.assert_allclose(high - low, 2 * 1.96 * values.std(axis=0) / 20, rtol=0.1)


def test_the_best_bend_is_found() -> None:
    line = np.interp(np.arange(31.0), [0, 9.5, 30], [0, 8, 11])
    assert best_bend(line) == 9.5


def test_a_saturating_curve_fits_what_has_no_bend() -> None:
    tasks = np.arange(31.0)
    smooth, bent = 12 * tasks / (tasks + 5), np.interp(tasks, [0, 7, 30], [0, 7, 9])
    assert squared_error(smooth, fit_saturation(smooth)) < 1e-6 < squared_error(smooth, fit_two_slopes(smooth, 7))
    assert squared_error(bent, fit_saturation(bent)) > 1 > squared_error(bent, fit_two_slopes(bent, 7))


def test_too_short_a_curve_has_no_bend() -> None:
    with pytest.raises(UserError, match="give 4 or more"):
        best_bend(np.arange(4.0))
