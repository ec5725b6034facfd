"""The estimate before a run: close to measured runs, and a limit against unintended ones."""

from __future__ import annotations

import re

import pandas as pd
import pytest
from projects import ROOT

from ptl.errors import UserError
from ptl.files.configuration import completed, read_yaml
from ptl.measures.cost import MAX_JOBS, Cost, check_cost, cost_of, together
from ptl.world.map_files import load_map


@pytest.fixture
def published(monkeypatch):
    monkeypatch.chdir(ROOT)
    return completed(read_yaml("config/config.yaml"))


def estimate(run) -> Cost:
    return cost_of(run, {name: load_map(entry.map) for name, entry in run.environments.items()})


def test_the_published_run_costs_about_what_it_took(published):
    cost = estimate(published)
    learned = sum(entry["mean"] for entry in totals()) * published.seeds
    assert learned / 5 < estimate(undecided(published)).steps < learned * 5
    assert cost.jobs == 3 * 6 * 30 + 30 + 3 * 8
    assert 0.02 < cost.hours < 0.5  # docs/performance.md
    assert cost.memory < 10**9


def undecided(run):
    """The run with hardly any lives but those of its tables."""
    return run.replace(decision__looks=[1], growth__runs=1)


def totals():
    """Mean total steps of every task and method in the published run."""
    metrics = pd.read_csv(ROOT / "reports/published/tables/metrics.csv")
    return metrics[metrics.metric == "total_steps"].to_dict("records")


def test_jobs_of_a_study_cost_what_those_of_a_run_do(published):
    cost = estimate(undecided(published).replace(subgoal_frequencies__trajectories=1))
    same = together(cost.jobs, 3 * 6 * (30 + 1), cost.steps)
    assert same.jobs == cost.jobs and same.hours == pytest.approx(cost.hours, rel=0.1)


def test_short_times_are_minutes() -> None:
    times = [Cost(1, 1.0, minutes / 60, 1.0).time for minutes in (0.1, 2.8, 119.6, 125)]
    assert times == ["1 CPU minute", "3 CPU minutes", "120 CPU minutes", "2.1 CPU hours"]


@pytest.mark.parametrize("key", ["seeds", "learning__episodes", "growth__runs"])
def test_more_work_costs_more(published, key):
    group, _, name = key.rpartition("__")
    before = getattr(getattr(published, group) if group else published, name)
    assert estimate(published.replace(**{key: 3 * before})).hours > estimate(published).hours


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"seeds": 100_000}, "more than 40,000 learning jobs"),
        ({"decision__looks": [100_000], "learning__episodes": 10**6}, "more than 500 CPU hours"),
        (
            {"seeds": 1000, "learning__episodes": 10**5, "decision__looks": [1]},
            "more than 8,000,000,000 bytes of memory",
        ),
    ],
)
def test_what_nobody_means_is_refused_with_the_way_to_split_it(published, changes, says):
    cost = estimate(published.replace(**changes))
    with pytest.raises(UserError, match=re.escape(says)) as caught:
        check_cost(cost, allowed=False)
    assert "split it" in str(caught.value) and "PTL_LARGE_RUN=1" in str(caught.value)
    check_cost(cost, allowed=True)


def test_the_limit_itself_is_allowed():
    check_cost(Cost(MAX_JOBS, 1.0, 1.0, 1.0), allowed=False)
