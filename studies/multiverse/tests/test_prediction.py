"""Predictions from made-up settings: mixtures by hand, errors of few runs, weights with ties."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner
from projects import ROOT
from scipy import stats

from ptl.claims.degrees import PLAIN, STRICT
from ptl.cli.score import command
from ptl.errors import UserError
from ptl.measures.scoring import CELL, CONDITIONAL, LEVELS, PRIOR, QUANTILES, read_predictions
from studies.multiverse.judging import ESTIMATE_COLUMNS, JUDGED, LIMIT, SHOWN, VERDICT_COLUMNS
from studies.multiverse.prediction import (
    POINTS,
    cells,
    conditional_weights,
    deviation_points,
    mean_points,
    predict,
    prior_weights,
    write_predictions,
)
from studies.multiverse.shares import reading_of

ENVIRONMENTS = ("env1", "env2", "env3")
METHODS = ("no_transfer", "full_transfer", "policy_reuse", "ptl", "ptl_supervised", "ptl_unknown_goal")
ONE, TWO = ("env2",), ("no_transfer", "ptl")
"""Environments and methods of the tests that look at one cell."""

TASKS = (*"ABCDEF", "BCDEF")
COMPARED = ("jump_start", "transfer_ratio")


def setting(place: int) -> str:
    return f"setting_{place:04d}"


def estimates_of(settings: dict[str, tuple[float, float, int]], methods: Iterable[str] = METHODS) -> pd.DataFrame:
    """The same mean, deviation and runs in every cell of a setting; a transfer ratio a 10,000th of it."""
    unit = dict.fromkeys(SHOWN, 1.0) | {"transfer_ratio": 1e-4}
    rows = [
        (name, environment, tasks, method, measure, mean * unit[measure], sd * unit[measure], seeds)
        for name, (mean, sd, seeds) in settings.items()
        for environment in ENVIRONMENTS
        for tasks in TASKS
        for method in methods
        for measure in SHOWN
        if not (method == "no_transfer" and measure in COMPARED)
    ]
    return pd.DataFrame(rows, columns=list(ESTIMATE_COLUMNS))


def verdicts_of(shares: dict[str, float], claims: int = 4) -> pd.DataFrame:
    """Verdicts in which these shares of the first claims hold as they are read here, the opposite otherwise."""
    rows = []
    for name, share in shares.items():
        for place, claim in enumerate(JUDGED[:claims]):
            holds = float(place < share * claims)
            for words in (STRICT, PLAIN):
                for reading in claim.readings():
                    runs = LIMIT if reading.runs is None else str(reading.runs)
                    value = holds if words == STRICT and reading == reading_of(claim, "F") else 1 - holds
                    rows.append((name, claim.id, words, reading.tasks, reading.tolerance, runs, value, 1, int(value)))
    return pd.DataFrame(rows, columns=list(VERDICT_COLUMNS))


def quantiles_of(predictions: pd.DataFrame, distribution: str, statistic: str, measure: str) -> np.ndarray:
    rows = predictions.query("environment == 'env2' and task == 'D' and method == 'ptl' and measure == @measure")
    own = rows[(rows["distribution"] == distribution) & (rows["statistic"] == statistic)]
    return own[list(QUANTILES)].to_numpy(dtype=float)[0]


# -- cells


def test_cells_are_those_of_six_tables():
    own = list(cells(ENVIRONMENTS, METHODS))
    assert len(own) == len(set(own)) == 3 * 5 * (6 * 4 + 5 * 4)
    assert {(cell.table, cell.environment) for cell in own} == {(n, f"env{(n + 1) // 2}") for n in range(1, 7)}
    by_table = {table: {cell.measure for cell in own if cell.table == table} for table in (3, 4)}
    assert by_table[3] == {"first_episode", "jump_start", "jump_start_percent", "asymptotic", "threshold_episode"}
    assert by_table[4] == {"total_steps", "transfer_ratio", "transfer_ratio_of_means"}
    assert {cell.measure for cell in own if cell.method == "no_transfer" and cell.table == 3} == {
        "first_episode", "asymptotic", "threshold_episode",
    }  # fmt: skip
    assert {cell.task for cell in own} == set("BCDEF")


# -- weights


def test_named_settings_are_left_out_of_the_prior():
    weights = prior_weights(estimates_of({"reference": (1, 1, 40), setting(0): (1, 1, 40), setting(1): (2, 1, 40)}))
    assert weights.to_dict() == {setting(0): 0.5, setting(1): 0.5}


def test_conditional_weights_without_ties():
    shares = {setting(place): place / 8 for place in range(8)} | {"reference": 1.0}
    weights = conditional_weights(verdicts_of(shares, claims=8))
    assert {name: weight for name, weight in weights.items() if weight} == {setting(6): 0.5, setting(7): 0.5}


def test_conditional_weights_with_ties():
    """Of eight settings the best two count: one leads, three share the second place."""
    shares = dict(zip(map(setting, range(8)), (0.5, 1, 0.75, 0, 0.75, 0.25, 0.75, 0), strict=True))
    weights = conditional_weights(verdicts_of(shares))
    assert weights[setting(1)] == pytest.approx(1 / 2)
    assert weights[[setting(2), setting(4), setting(6)]].to_numpy() == pytest.approx(1 / 6)
    assert weights[[setting(0), setting(3), setting(5), setting(7)]].to_numpy() == pytest.approx(0)


@pytest.mark.parametrize("number", [1, 2, 5, 7])
def test_conditional_weights_add_up(number: int):
    """A quarter of few settings is less than one; all equal, they have equal weights."""
    weights = conditional_weights(verdicts_of({setting(place): 0.5 for place in range(number)}))
    assert weights.to_numpy() == pytest.approx(1 / number)


def test_undecided_claims_do_not_count():
    verdicts = verdicts_of({setting(0): 0.5, setting(1): 0.75, setting(2): 0.5, setting(3): 0.5})
    undecided = (verdicts["setting"] == setting(0)) & verdicts["claim"].isin([claim.id for claim in JUDGED[2:4]])
    verdicts.loc[undecided, "holds"] = np.nan
    assert conditional_weights(verdicts)[setting(0)] == 1


# -- errors of few runs


def test_points_of_a_mean_are_those_of_student():
    runs, deviations = np.array([10, 40]), np.array([12.0, 6.0])
    points = mean_points("jump_start", np.array([100.0, -50.0]), deviations, runs)
    levels = (np.arange(POINTS) + 0.5) / POINTS
    for place, middle in enumerate((100, -50)):
        scale = deviations[place] * np.sqrt(1 / 30 + 1 / runs[place])
        np.testing.assert_allclose(points[place], stats.t.ppf(levels, runs[place] - 1, middle, scale))


def test_points_of_positive_and_bounded_measures_stay_within():
    few, wide = np.array([10]), np.array([300.0])
    steps = mean_points("total_steps", np.array([100.0]), wide, few)
    assert steps.min() > 0 and np.median(steps) == pytest.approx(100, rel=0.1)
    ratio = mean_points("transfer_ratio", np.array([0.9]), wide / 1000, few)
    assert ratio.max() < 1 and np.median(ratio) == pytest.approx(0.9, abs=0.01)
    # of small errors the scale makes no difference
    for measure, middle in (("total_steps", 100.0), ("transfer_ratio", 0.5)):
        narrow = np.array([middle * 1e-4])
        exact = np.sort(mean_points("jump_start", np.array([middle]), narrow, few))
        np.testing.assert_allclose(np.sort(mean_points(measure, np.array([middle]), narrow, few)), exact, rtol=1e-6)


def coverage_of(points: np.ndarray, printed: np.ndarray, level: float) -> float:
    low, high = np.quantile(points, [(1 - level) / 2, (1 + level) / 2], axis=1)
    return float(((low <= printed) & (printed <= high)).mean())


@pytest.mark.parametrize("runs", [10, 40])
@pytest.mark.parametrize("level", [0.5, 0.9])
def test_few_runs_of_a_setting_predict_thirty_with_nominal_coverage(runs: int, level: float):
    """Means of normal values and deviations of exponential ones, many times over."""
    random = np.random.default_rng(4)
    number, shape = np.full(4000, runs), (4000, runs + 30)
    normal, exponential = random.normal(5, 2, shape), random.exponential(2, shape)
    own, later = np.split(normal, [runs], axis=1)
    points = mean_points("jump_start", own.mean(axis=1), own.std(axis=1, ddof=1), number)
    assert coverage_of(points, later.mean(axis=1), level) == pytest.approx(level, abs=0.03)
    own, later = np.split(exponential, [runs], axis=1)
    points = deviation_points(own.std(axis=1, ddof=1), number)
    assert coverage_of(points, later.std(axis=1, ddof=1), level) == pytest.approx(level, abs=0.1)
    own, later = np.split(normal, [runs], axis=1)
    points = deviation_points(own.std(axis=1, ddof=1), number)
    assert coverage_of(points, later.std(axis=1, ddof=1), level) > level + 0.05  # too wide without tails


# -- mixtures


def test_two_settings_without_spread_give_hand_computed_quantiles():
    """Each of the two has half of the weight; a quarter of two is less than one, the better one."""
    settings = {setting(0): (100.0, 0.0, 40), setting(1): (300.0, 0.0, 40), "reference": (9.0, 0.0, 40)}
    predictions = predict(
        estimates_of(settings), verdicts_of({setting(0): 0.25, setting(1): 1, "reference": 1}), ONE, TWO
    )
    expected = np.where(LEVELS < 0.505, 100.0, 300.0)
    np.testing.assert_allclose(quantiles_of(predictions, PRIOR, "mean", "total_steps"), expected)
    np.testing.assert_allclose(quantiles_of(predictions, CONDITIONAL, "mean", "total_steps"), 300)
    np.testing.assert_allclose(quantiles_of(predictions, PRIOR, "sd", "total_steps"), 0)
    np.testing.assert_allclose(quantiles_of(predictions, PRIOR, "mean", "transfer_ratio"), expected / 10_000)
    np.testing.assert_allclose(quantiles_of(predictions, PRIOR, "mean", "transfer_ratio_of_means"), 0)
    assert not (predictions["statistic"] == "sd")[predictions["measure"] == "jump_start_percent"].any()
    settings_of = predictions.groupby("distribution")["settings"].unique()
    assert (settings_of[PRIOR].tolist(), settings_of[CONDITIONAL].tolist()) == ([2], [1])


def test_two_settings_with_spread_give_the_quantiles_of_the_mixture():
    settings = {setting(0): (-20.0, 30.0, 10), setting(1): (40.0, 60.0, 40)}
    shares = {setting(0): 0.5, setting(1): 0.5}
    predictions = predict(estimates_of(settings), verdicts_of(shares), ONE, TWO)
    spread = [sd * np.sqrt(1 / 30 + 1 / runs) for _, sd, runs in settings.values()]

    def share_below(value: np.ndarray) -> np.ndarray:
        return (stats.t.cdf(value, 9, -20, spread[0]) + stats.t.cdf(value, 39, 40, spread[1])) / 2

    for distribution in (PRIOR, CONDITIONAL):
        own = quantiles_of(predictions, distribution, "mean", "jump_start")
        np.testing.assert_allclose(share_below(own), LEVELS, atol=1 / POINTS)

    def share_of_deviations(value: np.ndarray) -> np.ndarray:
        return (stats.f.cdf((value / 30) ** 2, 29 / 4, 9 / 4) + stats.f.cdf((value / 60) ** 2, 29 / 4, 39 / 4)) / 2

    own = quantiles_of(predictions, PRIOR, "sd", "jump_start")
    np.testing.assert_allclose(share_of_deviations(own), LEVELS, atol=1 / POINTS)


def test_ratios_of_means_are_those_of_two_independent_means():
    settings = dict.fromkeys(map(setting, range(100)), (1000.0, 100.0, 40))  # for many pairs
    predictions = predict(estimates_of(settings), verdicts_of(dict.fromkeys(settings, 0.5)), ONE, TWO)
    own = quantiles_of(predictions, PRIOR, "mean", "jump_start_percent")
    spread = 100 * 0.1 * np.sqrt(1 / 30 + 1 / 40) * np.sqrt(2)
    assert own[49] == pytest.approx(0, abs=0.2)
    assert (own[74] - own[24]) / (2 * stats.norm.ppf(0.75) * spread) == pytest.approx(1, abs=0.05)


def test_values_drawn_from_a_mixture_have_nominal_coverage():
    random = np.random.default_rng(5)
    settings = {setting(place): (random.normal(0, 50), random.uniform(5, 100), 20) for place in range(50)}
    shares = {setting(place): 0.5 for place in range(50)}
    own = quantiles_of(predict(estimates_of(settings), verdicts_of(shares), ONE, TWO), PRIOR, "mean", "jump_start")
    means, deviations, _ = (np.array(column) for column in zip(*settings.values(), strict=True))
    chosen = random.integers(50, size=20_000)
    drawn = means[chosen] + deviations[chosen] * np.sqrt(1 / 30 + 1 / 20) * random.standard_t(19, size=20_000)
    for level, (low, high) in {0.5: (24, 74), 0.9: (4, 94)}.items():
        assert ((own[low] <= drawn) & (drawn <= own[high])).mean() == pytest.approx(level, abs=0.02)


def test_methods_learned_in_some_settings_are_predicted_from_these():
    estimates = pd.concat(
        [
            estimates_of({setting(0): (100.0, 0.0, 40)}),
            estimates_of({setting(1): (300.0, 0.0, 40)}, ["no_transfer"]),
        ]
    )
    shares = {setting(0): 0.5, setting(1): 0.5}
    predictions = predict(estimates, verdicts_of(shares), ONE, TWO)
    np.testing.assert_allclose(quantiles_of(predictions, PRIOR, "mean", "total_steps"), 100)
    assert predictions.groupby("method")["settings"].unique().map(list).to_dict() == {
        name: [1 if name == "ptl" else 2] for name in TWO
    }
    with pytest.raises(UserError, match="learned in no setting"):
        predict(estimates[estimates["method"] != "ptl"], verdicts_of(shares), ONE, TWO)


# -- files


def some_settings(methods: Iterable[str] = METHODS) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Estimates and verdicts of eight settings."""
    random = np.random.default_rng(6)
    settings = {setting(place): (random.uniform(50, 900), random.uniform(1, 90), 20) for place in range(8)}
    return estimates_of(settings, methods), verdicts_of({name: random.uniform() for name in settings}, claims=20)


def test_files_are_the_same_bytes_again(tmp_path: Path):
    estimates, verdicts = some_settings(TWO)
    for name in ("one", "other"):
        write_predictions(predict(estimates, verdicts, ONE, TWO), verdicts, tmp_path / name)
    content = (tmp_path / "one/predictions.csv").read_bytes()
    assert content == (tmp_path / "other/predictions.csv").read_bytes()
    page = (tmp_path / "one/README.md").read_text()
    assert hashlib.sha256(content).hexdigest() in page and page == (tmp_path / "other/README.md").read_text()


def test_predictions_of_all_cells_are_read_and_scored(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    estimates, verdicts = some_settings()
    write_predictions(predict(estimates, verdicts, ENVIRONMENTS, METHODS), verdicts, tmp_path / "one")
    page = (tmp_path / "one/README.md").read_text()
    read = read_predictions(tmp_path / "one/predictions.csv")
    assert f"{len(read[list(CELL)].drop_duplicates())} cells: mean" in page and "8 settings a cell" in page
    monkeypatch.chdir(tmp_path)
    arguments = (str(ROOT / "examples/score/made_up.csv"), "--predictions", "one/predictions.csv")
    done = CliRunner().invoke(command, [*arguments, "--output", "scores.png"], catch_exceptions=False)
    assert done.exit_code == 0 and len(pd.read_csv("scores.csv")) == 420 * 2 * 2
