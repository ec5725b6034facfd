"""Readings: several tasks added up, tolerance of a place, and significance at the article's number of runs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_up_run import BASE, PTL, MadeUpRun
from scipy import stats

from ptl import claims
from ptl.claims import comparisons
from ptl.claims.evidence import MissingEvidence
from ptl.claims.reading import ARTICLE_RUNS, DEFAULT, TRANSFER_TASKS, Reading, readings, tasks_text
from ptl.claims.verdict import Outcome
from ptl.measures.statistics import Resampling, mean_of_fewer

CLAIMS = {claim.id: claim for claim in claims.CLAIMS}


@pytest.fixture(scope="module")
def evidence():
    return MadeUpRun().evidence()


def test_tasks_are_added_up_seed_by_seed(evidence):
    for metric in ("total_steps", "first_episode", "jump_start", "asymptotic", "threshold_episode"):
        single = [evidence.values("env2", task, PTL, metric) for task in TRANSFER_TASKS]
        np.testing.assert_allclose(evidence.values("env2", TRANSFER_TASKS, PTL, metric), np.sum(single, axis=0))


def test_the_transfer_ratio_of_several_tasks_is_that_of_their_totals(evidence):
    own, base = evidence.pair(("env1", "BC", PTL), ("env1", "BC", BASE), "total_steps")
    np.testing.assert_allclose(evidence.values("env1", "BC", PTL, "transfer_ratio"), (base - own) / base)


def test_episodes_of_several_tasks_are_their_mean_and_a_miss_counts_with_all(evidence):
    per_seed = evidence.per_seed.copy()
    own = (per_seed["environment"] == "env1") & (per_seed["method"] == PTL) & (per_seed["task"] == "B")
    per_seed.loc[own, "threshold_episode"] = np.nan
    changed = replace(evidence, per_seed=per_seed)
    rest = np.mean([evidence.values("env1", task, PTL, "threshold_episode") for task in "CDEF"], axis=0)
    episodes = changed.length("env1", PTL, "B")
    np.testing.assert_allclose(
        comparisons.episodes_to_threshold(changed, "env1", TRANSFER_TASKS, PTL), (4 * rest + episodes) / 5
    )
    assert np.isnan(changed.values("env1", TRANSFER_TASKS, PTL, "threshold_episode")).all()


def test_tasks_with_different_seeds_cannot_be_added_up(evidence):
    per_seed = evidence.per_seed
    lost = (per_seed["task"] == "C") & (per_seed["method"] == PTL) & (per_seed["seed"] == 3)
    with pytest.raises(MissingEvidence, match="different seeds"):
        replace(evidence, per_seed=per_seed[~lost]).values("env1", TRANSFER_TASKS, PTL, "total_steps")


@pytest.mark.parametrize("id", [id for id, claim in CLAIMS.items() if "tasks" in claim.open_to])
def test_a_claim_that_names_no_task_is_judged_on_the_tasks_of_the_reading(evidence, id):
    for tasks in ("C", TRANSFER_TASKS):
        judgement = CLAIMS[id].judge(replace(evidence, reading=DEFAULT._replace(tasks=tasks)))
        assert judgement.parts
        assert not any("task F" in part.text for part in judgement.parts)
        assert any(tasks_text(tasks) in part.text for part in judgement.parts) or id in ("E1-jump", "E1-total")


@pytest.mark.parametrize("id", [id for id, claim in CLAIMS.items() if "tolerance" in claim.open_to])
def test_a_smaller_tolerance_never_finds_more_places(evidence, id):
    shares = []
    for tolerance in (0, 1, 2):
        parts = CLAIMS[id].judge(replace(evidence, reading=DEFAULT._replace(tolerance=tolerance))).parts
        shares.append([part.estimate.value for part in parts if "minus" not in part.text])
    assert (np.diff(np.array(shares), axis=0) >= 0).all()


def test_significance_of_fewer_runs_is_students_test():
    values = np.random.default_rng(1).normal(0.3, 1.0, size=ARTICLE_RUNS)
    estimate = mean_of_fewer(values, ARTICLE_RUNS, Resampling(0.95, 0))
    assert (estimate.low > 0) == (stats.ttest_1samp(values, 0, alternative="greater").pvalue < 0.025)
    assert mean_of_fewer(np.tile(values, 50), ARTICLE_RUNS, Resampling(0.95, 0)).low == pytest.approx(
        estimate.low, abs=0.01
    )


def test_not_significant_holds_at_few_runs_and_fails_in_the_limit(evidence):
    per_seed = evidence.per_seed.copy()
    own = (per_seed["environment"] == "env3") & (per_seed["method"] == PTL) & (per_seed["task"] == "F")
    noise = np.random.default_rng(2).normal(0, 400, size=own.sum())
    per_seed["jump_start"] = per_seed["jump_start"].astype(float)
    per_seed.loc[own, "jump_start"] = 100 + noise - noise.mean()
    changed = replace(evidence, per_seed=per_seed, how=Resampling(0.95, 0))
    outcomes = {
        runs: comparisons.jump_start_not_significant(
            replace(changed, reading=DEFAULT._replace(runs=runs)), "env3", "F", PTL
        ).outcome
        for runs in (ARTICLE_RUNS, None)
    }
    assert outcomes == {ARTICLE_RUNS: Outcome.HOLDS, None: Outcome.FAILS}


def test_readings_are_all_combinations_of_what_a_claim_leaves_open():
    assert list(readings(())) == [DEFAULT]
    found = list(CLAIMS["E3-jump"].readings())
    assert len(found) == len(set(found)) == 12
    assert DEFAULT in found
    assert Reading("C", 1, ARTICLE_RUNS) in found
