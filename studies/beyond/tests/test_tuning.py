"""What was tuned on the tuning band is what the methods have."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from ptl.learning.life import learn_life, tasks_of
from ptl.methods import load
from ptl.world.gridworld import GridWorld
from ptl.world.mazes import FAMILIES, GOALS
from studies.beyond import tuning
from studies.beyond.maps import checked_map
from studies.beyond.methods import reference
from studies.beyond.methods.policy_reuse_tuned import TUNED
from studies.beyond.population import read_population

WORLD = GridWorld.from_text("I..A\n")


@pytest.fixture(scope="module")
def table() -> pd.DataFrame:
    return pd.read_csv(tuning.TABLE)


def test_the_table_has_every_setting_once_and_the_cheapest_is_chosen(table):
    settings = [(method, tuning.shown(setting)) for method in tuning.GRIDS for setting in tuning.settings(method)]
    assert list(zip(table["method"], table["setting"], strict=True)) == settings
    np.testing.assert_allclose(np.exp(np.log(table[list(FAMILIES)]).mean(axis=1)), table["cost"], rtol=1e-4)
    for _, rows in table.groupby("method"):
        assert rows["cost"][rows["chosen"]].tolist() == [rows["cost"].min()]


def test_the_tuned_methods_have_the_chosen_settings(table):
    chosen = table[table["chosen"]].set_index("method")["setting"]
    assert chosen["policy_reuse"] == tuning.shown(TUNED)
    method = load(reference("policy_reuse_tuned"))(WORLD, tuning.Parameters(), np.random.default_rng(1))
    reuse = method.parameters.policy_reuse
    assert (reuse.psi_decay, reuse.temperature_step) == tuple(TUNED.values())
    # the best learning rate of optimism is that of the sibling that the study has already
    fast = load(reference("optimistic_fast"))(WORLD, tuning.Parameters(), np.random.default_rng(1))
    assert chosen["optimistic"] == f"learning.alpha={fast.parameters.learning.alpha:g}"


def test_the_cost_of_a_setting_is_that_of_its_lives(monkeypatch):
    monkeypatch.setattr(tuning, "MAPS", 1)
    monkeypatch.setattr(tuning, "LIVES", 1)
    monkeypatch.setattr(tuning, "FAMILIES", ("cave",))
    [entry] = [
        row for row in read_population() if (row.band, row.family, row.size, row.seed) == ("tuning", "cave", 300, 1000)
    ]
    world = checked_map("cave", 300, 1000, entry.hash, "increasing")
    parameters = tuning.Parameters(alpha=1.0)
    records = learn_life(
        world, tasks_of(world, GOALS), load(reference("optimistic")), parameters, 15, "cave", 1000, 0
    ).records
    steps = sum(record.steps.sum() for record in records[1:])
    optimum = 200 * sum(world.shortest_path_length(world.start, world.goal(letter)) for letter in GOALS[1:])
    assert tuning.costs("optimistic", {"learning__alpha": 1.0}) == {"cave": pytest.approx(steps / optimum)}
