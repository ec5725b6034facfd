"""Total steps relative to no transfer."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from ptl.measures.relative_steps import COLUMNS, relative_steps, saved_percent, saved_text
from ptl.measures.statistics import Resampling

HOW = Resampling(0.95, 500)
SEEDS = 20


def per_seed(methods=("no_transfer", "ptl"), tasks="ABC", seeds=SEEDS) -> pd.DataFrame:
    random = np.random.default_rng(5)
    rows = [
        (
            "env",
            task,
            method,
            seed,
            int(random.integers(900, 1100)) * (1 + "ABC".index(task)) // (1 + (method == "ptl")),
        )
        for method in methods
        for task in tasks
        for seed in range(seeds)
    ]
    return pd.DataFrame(rows, columns=["environment", "task", "method", "seed", "total_steps"])


def test_all_later_tasks_come_first_and_steps_are_added_up():
    found = relative_steps(per_seed(), {"env": "ABC"}, HOW)
    assert tuple(found.columns) == COLUMNS
    assert found["tasks"].tolist() == ["BC", "B", "C"]
    assert found["ratio"].tolist() == pytest.approx([0.5] * 3, rel=0.05)
    totals = per_seed().query("task != 'A'").groupby("method")["total_steps"].sum()
    assert found["ratio"][0] == pytest.approx(totals["ptl"] / totals["no_transfer"])
    assert (found["low"] < found["ratio"]).all() and (found["ratio"] < found["high"]).all()


def test_runs_are_not_paired_by_their_seeds():
    """The runs of a method in another order are the same runs."""
    frame = per_seed()
    turned = frame.assign(seed=frame["seed"].where(frame["method"] != "ptl", SEEDS - 1 - frame["seed"]))
    one, other = (relative_steps(own, {"env": "AB"}, HOW) for own in (frame, turned))
    assert other["ratio"].tolist() == pytest.approx(one["ratio"].tolist())
    assert other["low"].tolist() == pytest.approx(one["low"].tolist(), rel=0.02)


def test_an_interval_holds_its_level():
    """Lognormal totals of heavy tails, whose ratio of means is known."""
    random = np.random.default_rng(9)
    hits = []
    for _ in range(150):
        values = random.lognormal(5, 0.6, size=(2, 30))
        frame = pd.DataFrame(
            {
                "environment": "env", "task": "B", "method": np.repeat(["no_transfer", "ptl"], 30),
                "seed": np.tile(np.arange(30), 2), "total_steps": values.ravel() * np.repeat([2.0, 1.0], 30),
            }
        )  # fmt: skip
        [row] = relative_steps(frame, {"env": "AB"}, Resampling(0.95, 200)).to_dict("records")
        hits.append(row["low"] <= 0.5 <= row["high"])
    assert np.mean(hits) >= 0.86


def test_what_cannot_be_compared_is_left_out():
    assert relative_steps(per_seed(), {"env": "A"}, HOW).empty
    assert relative_steps(per_seed(("ptl",)), {"env": "ABC"}, HOW).empty
    frame = per_seed(("no_transfer", "ptl", "other"))
    frame = frame[(frame["method"] != "other") | (frame["task"] != "C")]
    found = relative_steps(frame, {"env": "ABC"}, HOW)
    assert found[found["method"] == "other"]["tasks"].tolist() == ["B"]


def test_few_runs_have_no_interval():
    found = relative_steps(per_seed(seeds=3), {"env": "AB"}, HOW)
    assert found["ratio"].notna().all() and found["low"].isna().all()


def test_saved_percent_turns_the_interval_round():
    assert saved_percent({"ratio": 0.25, "low": 0.2, "high": 1.5}) == pytest.approx((75, -50, 80))


@pytest.mark.parametrize(
    ("row", "says"),
    [
        ((0.25, 0.2, 0.3), "75% [70, 80]"),
        ((1.003, 0.95, 1.06), "0% [−6, 5]"),
        ((11.51, 11.0, 12.1), "11.5 [11, 12.1] times as many"),
    ],
)
def test_more_than_twice_the_steps_are_no_share_saved(row, says):
    assert saved_text(dict(zip(("ratio", "low", "high"), row, strict=True))) == says
