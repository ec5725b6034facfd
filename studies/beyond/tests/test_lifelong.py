"""Measures of lifelong learning, worked out by hand."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from ptl.config import Parameters
from ptl.learning.life import learn_life, tasks_of
from ptl.measures.statistics import Resampling
from ptl.methods import load
from ptl.world.gridworld import GridWorld
from studies.beyond import lifelong
from studies.beyond.collect import TASK_COLUMNS
from studies.beyond.figures import Look
from studies.beyond.lives import lives_on_maps
from studies.beyond.maps import RETURNING
from studies.beyond.methods import reference
from studies.beyond.page import EVERY

HOW = Resampling(0.95, 500)
LOOKS = {name: Look(name, "#000000") for name in ("no_transfer", "ptl", "rmax_memory")}
CORRIDOR = GridWorld.from_text("I..A...B\n")


def rows(method, sequence, steps, first, last, family="rooms", places=("4000", "4001")):
    """Rows of one life on each map; the life on the second map takes twice the steps of the first."""
    made = []
    for scale, place in enumerate(places, 1):
        for task, values in enumerate(zip(steps, first, last, strict=True), 1):
            row = dict.fromkeys(TASK_COLUMNS, 0) | {
                "family": family, "map": place, "sequence": sequence, "change": "none", "method": method, "task": task,
            }  # fmt: skip
            made.append(
                row | dict(zip(("steps", "first_episode", "last_episodes"), scale * np.array(values), strict=True))
            )
    return pd.DataFrame(made, columns=list(TASK_COLUMNS))


@pytest.fixture(scope="module")
def found():
    tasks = [
        rows("no_transfer", "increasing", (1000, 2000, 4000), (100, 200, 400), (10, 20, 40)),
        rows("ptl", "increasing", (1000, 1000, 1000), (100, 50, 25), (10, 20, 40)),
        rows("unasked", "increasing", (1000, 1000, 1000), (100, 50, 25), (10, 20, 40)),
        rows("no_transfer", RETURNING, (1000, 2000, 4000, 1000), (100, 200, 400, 80), (10, 20, 40, 10)),
        rows("ptl", RETURNING, (1000, 1000, 1000, 250), (100, 50, 25, 40), (8, 20, 40, 10)),
        rows("rmax_memory", RETURNING, (500, 500, 500, 400), (100, 50, 25, 10), (10, 20, 40, 10)),
    ]
    return lifelong.measures(pd.concat(tasks), ["rooms"], HOW)


def test_each_measure_is_the_ratio_that_its_definition_says(found):
    assert set(found["method"]) == {"no_transfer", "ptl", "rmax_memory"}, "those that were sent back"
    values = found[found["family"] == "rooms"].pivot(index="measure", columns="method", values="value")
    expected = {
        "backward_transfer": (10 / 80, 8 / 40, 1.0),
        "relearning": (1.0, 4.0, 1.25),
        "jump_start": (0.0, 1 - np.sqrt(50 / 200 * 25 / 400), np.nan),
        "transfer_ratio": (0.0, 1 - 2000 / 6000, np.nan),
        "relative_performance": (1.0, (1 * 2 * 4) ** (1 / 3), np.nan),
    }
    for measure, wanted in expected.items():
        np.testing.assert_allclose(values.loc[measure, list(LOOKS)].astype(float), wanted, err_msg=measure)
    # the second map doubles all steps, of the expert too: no ratio varies
    np.testing.assert_allclose(found["low"], found["value"])
    np.testing.assert_allclose(found["high"], found["value"])


def test_the_mean_over_families_gives_each_the_same_weight_and_the_ends_are_in_order():
    tasks = [
        rows(method, sequence, steps, first, (10, 10), family, places)
        for family, factor, places in (("cave", 1, ("1", "2", "3")), ("maze", 4, ("1",)), ("env1", 64, ("1",)))
        for method, sequence, steps, first in (
            ("no_transfer", "increasing", (100, 100), (50, 50)),
            ("no_transfer", RETURNING, (100, 100), (50, 10 * factor)),
            ("ptl", "increasing", (100, 100 / factor), (50, 50 / factor)),
            ("ptl", RETURNING, (100, 100), (50, 10 * factor)),
        )
    ]
    tasks = pd.concat(tasks)
    tasks.loc[(tasks["method"] == "ptl") & (tasks["map"] == "2"), ["steps", "first_episode"]] *= 3
    found = lifelong.measures(tasks, ["cave", "maze"], HOW).set_index(["family", "measure", "method"]).sort_index()
    back = found.loc[EVERY, "backward_transfer"]["value"]
    assert back["no_transfer"] == pytest.approx(np.sqrt(1 * 1 / 4))
    per_family = found.xs(("relative_performance", "ptl"), level=("measure", "method"))["value"]
    assert per_family["maze"] == pytest.approx(2), "the mean of 1 and 4"
    assert per_family[EVERY] == pytest.approx(np.sqrt(per_family["cave"] * per_family["maze"]))
    assert (found["low"].dropna() <= found["value"][found["low"].notna()]).all()
    assert (found["high"].dropna() >= found["value"][found["high"].notna()]).all()
    cave = found.loc["cave", "relative_performance", "ptl"]
    assert cave["low"] == pytest.approx(1 / 3) and cave["high"] == pytest.approx(1)


def test_the_sentence_follows_from_the_numbers(found):
    text = lifelong.sentence(found, LOOKS)
    assert "not clearly worse than when they left it: “rmax_memory”;" in text
    assert "PTL’s first episode there takes 5 " in text and "an expert that learns each from nothing takes 2 " in text
    assert lifelong.sentence(found[found["method"] != "ptl"], LOOKS) == ""
    cells = {row.label: [cell.text for cell in row.cells] for row in lifelong.table(found, LOOKS).groups[0].rows}
    assert cells["ptl"] == ["0.875", "0.667", "0.2", "4", "2"]
    assert cells["rmax_memory"][2:4] == ["1", "1.25"]


@pytest.mark.parametrize("method", ["ptl", "policy_reuse", "plpr", "maxqinit", "free_space_memory"])
def test_a_task_may_come_again_and_does_not_change_those_before(method):
    kind, parameters = load(reference(method)), Parameters(episodes=20)
    made = lives_on_maps([("corridor", CORRIDOR)], "ABA", kind, parameters, 15, 2, "names")
    for seed in range(2):
        before = learn_life(CORRIDOR, tasks_of(CORRIDOR, "AB"), kind, parameters, 15, "names", "corridor", seed)
        assert made["steps"][0, seed, :2].tolist() == [record.steps.sum() for record in before.records]
        last = [record.steps[-2:].sum() for record in before.records]
        assert made["last"][0, seed, :2].tolist() == last
    assert made["shortest"].tolist() == [[3, 7, 3]]


def test_a_plan_that_keeps_its_walls_loses_nothing():
    kind = load(reference("free_space_memory"))
    made = lives_on_maps([("corridor", CORRIDOR)], "ABA", kind, Parameters(episodes=20), 15, 1, "names")
    assert made["first"][0, 0].tolist() == [3, 7, 3] and made["last"][0, 0].tolist() == [6, 14, 6]
