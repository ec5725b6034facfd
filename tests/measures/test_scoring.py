"""Scores of printed values: exact CRPS and ranks, coverage, and the sentences."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from predictions import normal_predictions
from scipy import stats

from ptl.errors import UserError
from ptl.files.csv import write_csv
from ptl.measures.scoring import (
    CELL,
    CONDITIONAL,
    LEVELS,
    PRIOR,
    coverage,
    crps,
    ranks,
    read_predictions,
    score,
    sentences,
)

MANY = 4000
CELLS = [("1", "env1", "B", "ptl", f"m{place}") for place in range(MANY)]


def printed_of(mean: np.ndarray, sd: np.ndarray | float = np.nan) -> pd.DataFrame:
    return pd.DataFrame(CELLS[: len(mean)], columns=list(CELL)).assign(mean=mean, sd=sd)


def normal_crps(value: np.ndarray, middle: float, spread: float) -> np.ndarray:
    """Closed form (Gneiting and Raftery, JASA 102, 2007, equation 21)."""
    z = (value - middle) / spread
    return spread * (z * (2 * stats.norm.cdf(z) - 1) + 2 * stats.norm.pdf(z) - 1 / np.sqrt(np.pi))


def test_crps_of_a_normal_distribution_is_the_closed_form():
    values = np.linspace(-50, 70, 241)
    quantiles = np.tile(7 + 12 * stats.norm.ppf(LEVELS), (len(values), 1))
    np.testing.assert_allclose(crps(quantiles, values), normal_crps(values, 7, 12), atol=0.012 * 12)
    inside = np.abs(values - 7) < 2 * 12
    np.testing.assert_allclose(crps(quantiles, values)[inside], normal_crps(values, 7, 12)[inside], atol=0.005 * 12)


def test_crps_of_a_uniform_distribution_is_the_closed_form():
    values = np.linspace(-1, 2, 61)
    within = np.clip(values, 0, 1)
    exact = (within**3 + (1 - within) ** 3) / 3 + np.abs(values - within)
    np.testing.assert_allclose(crps(np.tile(LEVELS, (61, 1)), values), exact, atol=0.002)


def test_crps_of_a_certain_prediction_is_the_absolute_error():
    np.testing.assert_allclose(crps(np.full((3, 99), 5.0), np.array([2.0, 5.0, 9.5])), [3, 0, 4.5])


def test_ranks():
    quantiles = np.tile(LEVELS, (4, 1))
    np.testing.assert_allclose(ranks(quantiles, np.array([-1, 0.304, 0.5, 2])), [0.005, 0.305, 0.5, 0.995])
    steps = np.repeat([1.0, 3.0], [50, 49])[np.newaxis]
    np.testing.assert_allclose(ranks(steps, np.array([1.0])), [0.255])
    np.testing.assert_allclose(ranks(steps, np.array([2.0])), [0.505])
    np.testing.assert_allclose(ranks(np.full((1, 99), 3.0), np.array([3.0])), [0.5])


def test_values_drawn_from_the_predictions_have_the_nominal_coverage():
    random = np.random.default_rng(1)
    middle, spread = random.normal(size=MANY), random.uniform(1, 2, size=MANY)
    predictions = normal_predictions(CELLS, middle, spread)
    scores = score(printed_of(random.normal(middle, spread), random.normal(middle, spread)), predictions)
    covered = coverage(scores)
    assert len(covered) == 8 and set(covered["cells"]) == {MANY}
    np.testing.assert_allclose(covered["coverage"], covered["nominal"], atol=4 * np.sqrt(0.25 / MANY))
    assert stats.kstest(scores["rank"], "uniform").statistic < 0.03
    expected = spread.mean() / np.sqrt(np.pi)  # of the closed form
    np.testing.assert_allclose(scores["crps"].mean(), expected, rtol=0.05)
    assert "about as many as it should" in sentences(scores)[0]


@pytest.mark.parametrize(("factor", "words"), [(3, "fewer than it should"), (0.3, "more than it should")])
def test_sentences_follow_the_numbers(factor: float, words: str):
    random = np.random.default_rng(2)
    predictions = normal_predictions(CELLS[:200], np.zeros(200), np.ones(200))
    scores = score(printed_of(factor * random.normal(size=200)), predictions)
    first, second = sentences(scores)
    assert words in first and f"{len(scores) // 2} printed means" in first
    assert "predict 0 of 200 printed means better" in second  # both predictions are the same
    above = (scores["printed"] > 0).sum() // 2
    assert f"{above} of 200 are above their median, 100 would be even" in second


def test_the_sharper_of_two_right_predictions_is_better():
    predictions = normal_predictions(CELLS[:50], np.zeros(50), np.ones(50))
    sharper = predictions["distribution"] == CONDITIONAL
    predictions.loc[sharper, predictions.columns[8:]] *= 0.5
    scores = score(printed_of(np.zeros(50)), predictions)
    assert "predict 50 of 50 printed means better" in sentences(scores)[1]


def test_only_printed_numbers_are_scored():
    predictions = normal_predictions(CELLS[:3], np.array([1.0, 2.0, 3.0]), np.ones(3))
    scores = score(printed_of(np.array([1.5, np.nan]), np.array([np.nan, 30.0])), predictions)
    assert scores[["measure", "statistic", "distribution"]].to_numpy().tolist() == [
        ["m0", "mean", PRIOR], ["m0", "mean", CONDITIONAL], ["m1", "sd", PRIOR], ["m1", "sd", CONDITIONAL],
    ]  # fmt: skip
    assert scores["inside_50"].tolist() == [1, 1, 0, 0] and scores["inside_90"].tolist() == [1, 1, 0, 0]
    np.testing.assert_allclose(scores["median"], [1, 1, 2, 2])
    np.testing.assert_allclose(scores["high_90"], scores["median"] + stats.norm.ppf(0.95))
    assert "too few values to judge the settings by" in sentences(scores)[0]
    deviations = sentences(score(printed_of(np.full(1, np.nan), 4.0), predictions))
    assert "printed standard deviations" in deviations[0]


def test_predictions_are_read_as_they_were_written_and_checked(tmp_path):
    path = tmp_path / "predictions.csv"
    good = normal_predictions(CELLS[:3], np.array([100.0, 200.0, 300.0]), np.ones(3))
    write_csv(good, path)
    pd.testing.assert_frame_equal(read_predictions(path), good, rtol=1e-5)
    for damaged, words in (
        (good.drop(columns="q50"), "no column 'q50'"),
        (good.assign(q50=1000.0), "row 1 has quantiles that do not rise"),
        (good.assign(q50="much"), "row 1: q50 'much' is not allowed"),
        (good.replace({"distribution": {PRIOR: "later"}}), "row 1 has a distribution other than prior and conditional"),
        (pd.concat([good, good.tail(1)]), "row 13 repeats an earlier row"),
        (good.head(0), "has no prediction"),
    ):
        write_csv(damaged, path)
        with pytest.raises(UserError, match=words):
            read_predictions(path)
