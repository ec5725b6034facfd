"""The learners of the benchmark learn the same task alike; measurements are summarised and shown correctly."""

from __future__ import annotations

import getpass
import json
import socket
from functools import partial
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from benchmarks import __main__ as program
from benchmarks import jobs, pages, scaling, speed, surveys
from benchmarks.learners import GymnasiumLoop, Kernel, Mdplib, PlainLoop, Problem
from ptl.files.csv import write_csv
from ptl.report import readme
from ptl.world.gridworld import GridWorld

SMALL = GridWorld.from_text("I...\n.#..\n....\n#..A\n")
EVERY_STEP = partial(Kernel, shortcut=False)


def jax_loop(*arguments):
    pytest.importorskip("jax")
    from benchmarks.jax_loop import JaxLoop

    return JaxLoop(*arguments)


def numba_loop(*arguments):
    pytest.importorskip("numba")
    from benchmarks.numba_loops import NumbaLoop

    return NumbaLoop(*arguments)


def bare_walk(*arguments):
    pytest.importorskip("numba")
    from benchmarks.numba_loops import BareWalk

    return BareWalk(*arguments)


LEARNERS = [Kernel, EVERY_STEP, PlainLoop, GymnasiumLoop, numba_loop, jax_loop]


def small_task(**options: float) -> Problem:
    return Problem(SMALL, "A", **options)


def optimal_values(successors: np.ndarray, goal: int, gamma: float, goes_on: bool = False) -> np.ndarray:
    values = np.zeros(len(successors))
    for _ in range(1000):
        values = np.where(successors == goal, 1.0 + gamma * values[goal], gamma * values[successors]).max(axis=1)
        values[goal] *= goes_on
    return values


# -- learners ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("make", [*LEARNERS, bare_walk])
def test_first_episodes_are_random_walks(make):
    goal, n = SMALL.goals["A"], SMALL.n_states
    walk, others = np.zeros((n, n)), np.delete(np.arange(n), goal)
    np.add.at(walk, (np.arange(n)[:, None], SMALL.successors), 0.25)
    lengths = np.linalg.solve(np.eye(n - 1) - walk[np.ix_(others, others)], np.ones(n - 1))
    expected, episodes = lengths[list(others).index(SMALL.start)], 200 if make is GymnasiumLoop else 2000
    steps = make(small_task(alpha=0.0), 3).run(episodes)
    # the standard deviation of a length is about its mean; the seed is fixed, so this holds always or never
    assert steps / episodes == pytest.approx(expected, abs=4 * expected / episodes**0.5)


@pytest.mark.parametrize("make", LEARNERS)
def test_learners_learn_the_optimal_values(make):
    task = small_task(alpha=0.5, epsilon=1.0)  # random steps come everywhere
    learner = make(task, 5)
    learner.run(100)
    q = np.array(learner.q)
    assert q.max(axis=1) == pytest.approx(optimal_values(task.successors, task.goal, task.gamma), abs=0.02)


@pytest.mark.parametrize("make", LEARNERS)
def test_learners_take_the_best_action(make):
    learner = make(small_task(alpha=0.5), 1)
    learner.run(100)
    shortest = SMALL.shortest_path_length(SMALL.start, SMALL.goals["A"])
    assert shortest <= learner.run(100) / 100 < 1.5 * shortest  # epsilon is 0.1


def test_mdplib_learns_the_values_of_the_task_that_goes_on(monkeypatch):
    pytest.importorskip("mdp")
    monkeypatch.setattr(Mdplib, "STEPS", 20_000)
    task = small_task(alpha=0.5)
    learner, after = Mdplib(task, 1), task.successors.copy()
    assert learner.run(1) == 20_000
    after[task.goal] = task.start
    assert learner.values == pytest.approx(optimal_values(after, task.goal, task.gamma, goes_on=True), abs=0.02)


# -- measurements --------------------------------------------------------------------------------------------


def test_ratios_and_shares_compare_rates_of_one_round():
    entries = [
        speed.Entry("kernel", Kernel, limit="walk"),
        speed.Entry(speed.BASE, PlainLoop),
        speed.Entry("sampled", GymnasiumLoop, "sampled"),
        speed.Entry("walk", EVERY_STEP, "cold"),
    ]
    measured = speed.measure(small_task(), entries, 1, episodes=40, min_seconds=0.001)
    values = measured.set_index(["item", "quantity"])["value"]
    rate = values[:, "steps per CPU second"]
    assert set(rate.index) == {"kernel", speed.BASE, "sampled"} and (rate > 0).all()
    assert values["kernel", "ratio to plain Python"] == rate["kernel"] / rate[speed.BASE]
    assert values["kernel", "share of walk"] == rate["kernel"] / values["walk", "per CPU second"]


def test_surveys_take_every_pair_once_and_trees_fewer_steps(tmp_path: Path):
    path = tmp_path / "small.txt"
    path.write_text(SMALL.text)
    values = surveys.measure({"small": str(path)}, 5, batches=2).set_index(["item", "quantity"])["value"]
    for method in surveys.METHODS:
        assert values[method, "pairs"] == values[method, "pairs, small"] == SMALL.n_states * (SMALL.n_states - 1)
        assert values[method, "core seconds"] > 0
    assert values[surveys.TREES, "steps"] < values[surveys.EVERY_STEP, "steps"]
    groups = [group for batch in range(3) for group in surveys.all_pairs(SMALL, batch, 3)]
    assert (
        len({(state, other) for state, others in groups for other in others.tolist()})
        == values["survey, with trees", "pairs"]
    )


def test_products_of_one_job_are_one_job(tmp_path: Path):
    products = [
        ("learn", "a", 3.0, 5.5),
        ("learn", "b", 4.0, 6.0),
        ("tables", "t", 6.0, 7.0),
        ("tables", "t", 6.5, 9.0),
    ]
    for place, (rule, log, start, end) in enumerate(products):
        record = {"rule": rule, "log": [log], "starttime": start, "endtime": end}
        (tmp_path / str(place)).write_text(json.dumps(record))
    assert jobs.read_jobs(tmp_path).to_numpy().tolist() == [["learn", 2.5], ["learn", 2.0], ["tables", 3.0]]


def test_a_power_law_is_recovered_with_the_textbook_interval():
    sizes, noise = np.array([100.0, 1000, 10_000, 100_000]), np.exp([0.1, -0.1, -0.1, 0.1])
    assert scaling.power_law(sizes, 3e-6 * sizes**1.5) == pytest.approx((1.5, 1.5, 1.5))
    exponent, low, high = scaling.power_law(sizes, 3e-6 * sizes * noise)
    x = np.log(sizes) - np.log(sizes).mean()
    error = np.sqrt((np.log(noise) ** 2).sum() / 2 / (x**2).sum())
    assert (low, high) == pytest.approx((exponent - 4.30265 * error, exponent + 4.30265 * error), rel=1e-4)
    assert np.isnan(scaling.power_law(sizes[:2], sizes[:2])[1]) and np.isnan(scaling.power_law(sizes[:1], sizes[:1])[0])


def test_growth_is_measured_drawn_and_written_down():
    growth = scaling.measure(scaling.QUICK)
    assert (growth["value"] >= 0).all()
    assert growth.groupby(["part", "kind"])["size"].nunique().to_dict() == {
        ("states", "rooms"): 2, ("states", "maze"): 2, ("skills", "rooms"): 2, ("tasks", "rooms"): 2,
        ("episodes", "rooms"): 2,
    }  # fmt: skip
    assert all(axes.lines for axes in scaling.draw(growth).axes)
    text = pages.scaling_page({}, growth)
    assert all(f"| {quantity} |" in text for quantity in growth["quantity"])


# -- pages ---------------------------------------------------------------------------------------------------


def test_published_rates_are_marked_in_page_table_and_readme(tmp_path: Path):
    computer = {"processor": "some chip", "cores": "2", "memory": "1 GiB"}
    rows = [("steps per CPU second", 2e6), ("steps per CPU second", 4e6), ("ratio to plain Python", 3.0)]
    measured = pd.DataFrame(rows, columns=["quantity", "value"]).assign(part="speed", item="kernel")
    summary = pages.summarise(pd.concat([measured, speed.published()]))
    page = pages.benchmark_page(computer, summary, "env9", "Z")
    assert "Q-learning of env9, task Z," in page and "| kernel | 3,000,000 (2,000,000 to 4,000,000) | 3 |" in page
    assert "Not measured here" in page and "| QTAccel, a pipeline on an FPGA | 180,000,000 |" in page
    write_csv(pages.benchmark_csv(computer, summary), tmp_path / "benchmark.csv")
    text = readme.speed(tmp_path)
    assert (
        "| kernel | 3 | 3 |" in text
        and "| QTAccel, a pipeline on an FPGA (published, not measured here) | 180 | – |" in text
    )
    assert "arXiv:2407.19396" in text and text.count("\n* ") == len(speed.PUBLISHED)


def test_missing_libraries_are_one_line(monkeypatch):
    monkeypatch.setattr(program, "find_spec", lambda name: None)
    with pytest.raises(SystemExit, match="gymnasium, jax, mdplib, numba not installed; run 'make benchmark'"):
        program.main([])


@pytest.mark.slow
@pytest.mark.skipif(not all(map(find_spec, program.PEERS)), reason="needs the libraries of `make benchmark`")
def test_the_program_writes_its_products(tmp_path: Path):
    program.main(["--quick", "--output", str(tmp_path)])
    assert {path.name for path in tmp_path.iterdir()} == {
        "benchmark.md", "benchmark.csv", "scaling.md", "scaling.csv", "scaling.png", "scaling.svg"
    }  # fmt: skip
    table = pd.read_csv(tmp_path / "benchmark.csv")
    assert set(table["part"]) == {"machine", *pages.PARTS}
    assert {"JAX, one loop", "Numba, one loop", "Gymnasium and numpy"} <= set(table["item"])
    assert (
        socket.gethostname() not in table.to_csv()
        and getpass.getuser() not in table[table["part"] == "machine"].to_csv()
    )
