"""What was tuned on the tuning band is what the methods have."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from ptl.learning.life import learn_life, tasks_of
from ptl.methods import load
from ptl.world.gridworld import GridWorld
from ptl.world.mazes import FAMILIES, GOALS
from ptl.world.optimum import optimal_steps
from studies.beyond import tuning
from studies.beyond.design import read_study
from studies.beyond.maps import checked_map
from studies.beyond.methods import reference
from studies.beyond.methods._tuned import OPTIMISTIC, POLICY_REUSE, tuned_at
from studies.beyond.population import read_population

WORLD = GridWorld.from_text("I..A\n")


@pytest.fixture(scope="module")
def table() -> pd.DataFrame:
    return pd.read_csv(tuning.TABLE)


def test_the_table_has_every_setting_once_and_the_cheapest_is_chosen(table):
    slips = [0.0, *read_study(tuning.CONFIG / "beyond.yaml").harder.slips]
    assert slips == [0.0, 0.1, 0.2]
    settings = [
        (method, slip, tuning.shown(setting))
        for method in tuning.GRIDS
        for slip in slips
        for setting in tuning.settings(method)
    ]
    assert list(zip(table["method"], table["slip"], table["setting"], strict=True)) == settings
    np.testing.assert_allclose(np.exp(np.log(table[list(FAMILIES)]).mean(axis=1)), table["cost"], rtol=1e-4)
    for _, rows in table.groupby(["method", "slip"]):
        assert rows["cost"][rows["chosen"]].tolist() == [rows["cost"].min()]


def test_the_tuned_methods_have_the_settings_chosen_at_each_slip(table):
    chosen = table[table["chosen"]].set_index(["method", "slip"])["setting"]
    for name, tuned in (("policy_reuse", POLICY_REUSE), ("optimistic", OPTIMISTIC)):
        assert {slip: tuning.shown(setting) for slip, setting in tuned.items()} == chosen[name].to_dict()


@pytest.mark.parametrize(
    ("slip", "nearest"), [(0.0, 0.0), (0.1, 0.1), (0.2, 0.2), (0.04, 0.0), (0.05, 0.0), (0.9, 0.2)]
)
def test_a_method_takes_what_was_tuned_at_the_nearest_slip(slip, nearest):
    world, parameters = WORLD.with_slip(slip), tuning.Parameters()
    reuse, fast = (
        load(reference(name))(world, parameters, np.random.default_rng(1)).parameters
        for name in ("policy_reuse_tuned", "optimistic_fast")
    )
    assert reuse == parameters.replace(**POLICY_REUSE[nearest])
    assert fast == parameters.replace(**OPTIMISTIC[nearest])
    assert tuned_at({0.2: {"x": 1.0}, 0.0: {"x": 2.0}}, 0.1) == {"x": 2.0}, "the lower of two equally near"


@pytest.mark.parametrize("slip", [0.0, 0.2])
def test_the_cost_of_a_setting_is_that_of_its_lives(monkeypatch, slip):
    monkeypatch.setattr(tuning, "MAPS", 1)
    monkeypatch.setattr(tuning, "LIVES", 1)
    monkeypatch.setattr(tuning, "FAMILIES", ("cave",))
    [entry] = [
        row for row in read_population() if (row.band, row.family, row.size, row.seed) == ("tuning", "cave", 300, 1000)
    ]
    world = checked_map("cave", 300, 1000, entry.hash, "increasing").with_slip(slip)
    parameters = tuning.Parameters(alpha=1.0)
    records = learn_life(
        world, tasks_of(world, GOALS), load(reference("optimistic")), parameters, 15, "cave", 1000, 0
    ).records
    steps = sum(record.steps.sum() for record in records[1:])
    optimum = 200 * sum(optimal_steps(world, world.goal(letter))[world.start] for letter in GOALS[1:])
    assert tuning.costs("optimistic", {"learning__alpha": 1.0}, slip) == {"cave": pytest.approx(steps / optimum)}
