"""The benchmark: contestants learn the same task under the same law, and fits and summaries are right."""

from __future__ import annotations

import getpass
import json
import platform
import socket
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner
from projects import MAPS, Project

from ptl.benchmark import contestants, figure8, machine, pages, probes, run, scaling, speed, startup, surveys
from ptl.benchmark.contestants import (
    BareWalk,
    BareWalkByTwos,
    GymnasiumLoop,
    Kernel,
    KernelEveryStep,
    Mdplib,
    NumbaLoop,
    PlainLoop,
    RandomWords,
)
from ptl.benchmark.task import Task
from ptl.config import Learning
from ptl.errors import UserError
from ptl.report.figures import scaling as figure
from ptl.world.gridworld import GridWorld

ENV2 = MAPS / "env2.txt"
SMALL = GridWorld.from_text("I...\n.#..\n....\n#..A\n")


def small_task(**options: float) -> Task:
    return Task(SMALL, "A", **options)


INSTALLED = [Kernel, KernelEveryStep, PlainLoop]
INSTALLED += [GymnasiumLoop] if contestants.find_spec("gymnasium") else []
INSTALLED += [NumbaLoop] if contestants.find_spec("numba") else []


# -- contestants ---------------------------------------------------------------------------------------------


def mean_first_episode(world: GridWorld, goal: int) -> float:
    """Expected steps of a uniform random walk to the goal, from the linear system."""
    others = np.delete(np.arange(world.n_states), goal)
    walk = np.zeros((world.n_states, world.n_states))
    np.add.at(walk, (np.arange(world.n_states)[:, None], world.successors), 0.25)
    steps = np.linalg.solve(np.eye(len(others)) - walk[np.ix_(others, others)], np.ones(len(others)))
    return steps[list(others).index(world.start)]


WALKS = [BareWalk, BareWalkByTwos] if contestants.find_spec("numba") else []


@pytest.mark.parametrize("kind", INSTALLED + WALKS)
def test_first_episodes_have_the_length_of_a_random_walk(kind: type):
    expected, episodes = mean_first_episode(SMALL, SMALL.goals["A"]), 200 if kind is GymnasiumLoop else 2000
    steps = kind(small_task(alpha=0.0), 3).run(episodes)
    expected += kind is BareWalkByTwos and 0.5  # half of all walks would reach the goal by the first of two steps
    # the length's standard deviation is about its mean; the seed is fixed, so this holds always or never
    assert steps / episodes == pytest.approx(expected, abs=4 * expected / episodes**0.5)


@pytest.mark.skipif(not WALKS, reason="needs numba")
def test_a_bare_walk_never_goes_round_in_a_circle():
    """One word, used over and over, would push one wall for ever."""
    walk = BareWalk(small_task(), 3)
    *places, words = walk._arguments
    walk._arguments = (*places, np.zeros_like(words[:1]))
    assert walk.run(5) > 0


@pytest.mark.parametrize("kind", INSTALLED)
def test_all_learn_the_same_values(kind: type):
    contestant = kind(small_task(alpha=0.5, epsilon=1.0), 5)  # random steps come everywhere
    contestant.run(100)
    q, task = contestant.q, small_task()
    optimum = np.zeros(SMALL.n_states)
    for _ in range(100):
        optimum = np.where(task.successors == task.goal, 1.0, task.gamma * optimum[task.successors]).max(axis=1)
        optimum[task.goal] = 0.0
    assert q.shape == (SMALL.n_states, 4)
    assert not q[task.goal].any()
    assert np.delete(q.max(axis=1), task.goal) == pytest.approx(np.delete(optimum, task.goal), abs=0.02)


@pytest.mark.parametrize("kind", INSTALLED)
def test_a_given_q_is_the_beginning(kind: type):
    known = np.zeros((SMALL.n_states, 4))
    for state in range(SMALL.n_states):
        known[state, SMALL.transitions.shortest_path_policy(SMALL.goals["A"])[state]] = 0.5
    known[SMALL.goals["A"]] = 0
    task = small_task(alpha=0.0, epsilon=0.0)
    assert kind(task, 0, known).run(7) == 7 * SMALL.shortest_path_length(task.start, task.goal)


@pytest.mark.skipif(not contestants.find_spec("mdp"), reason="needs mdplib")
def test_mdplib_learns_the_values_of_the_task_that_goes_on(monkeypatch):
    monkeypatch.setattr(Mdplib, "STEPS", 20_000)
    task = small_task(alpha=0.5)
    contestant = Mdplib(task, 1)
    assert contestant.run(1) == 20_000
    after = task.successors.copy()
    after[task.goal] = task.start
    optimum = np.zeros(SMALL.n_states)
    for _ in range(1000):
        optimum = ((after == task.goal) + task.gamma * optimum[after]).max(axis=1)
    assert contestant.values == pytest.approx(optimum, abs=0.02)


@pytest.mark.skipif(not contestants.find_spec("numba"), reason="needs numba")
def test_random_words_are_those_of_the_generator(monkeypatch):
    monkeypatch.setattr(RandomWords, "WORDS", 5)
    words = RandomWords(small_task(), 3)
    assert words.run(1) == 5
    assert words._draw(*words._arguments, 2) == np.bitwise_xor.reduce(np.random.SFC64(3).random_raw(7)[5:])


def test_missing_libraries_are_one_line(monkeypatch):
    monkeypatch.setattr(contestants, "find_spec", lambda name: None)
    with pytest.raises(UserError, match=r"gymnasium is not installed; run 'make benchmark'"):
        contestants.check_installed()


# -- speed ---------------------------------------------------------------------------------------------------

CHEAP = [
    speed.Entry(speed.BASE, PlainLoop),
    speed.Entry("kernel", Kernel),
    speed.Entry("cold", Kernel, "cold"),
    speed.Entry("sampled", PlainLoop, "sampled"),
]


def test_all_entries_run_in_every_round():
    measured = speed.measure(small_task(), 2, CHEAP, episodes=40, least_seconds=0.001)
    assert measured["entry"].tolist() == 2 * [entry.label for entry in CHEAP]
    assert (measured["steps"] > 0).all() and (measured["seconds"] >= 0.001).all()


def test_stages_are_the_task_as_it_is_learned():
    stages = speed.stages_of(small_task(), episodes=60)
    assert len(stages) == 3
    assert not stages[0].any()
    assert (stages[1] <= stages[2]).all() and stages[1].any()


def test_a_ratio_compares_a_round_with_itself():
    measured = pd.DataFrame(
        [
            {"round": 0, "entry": "base", "steps": 100, "seconds": 1.0},
            {"round": 0, "entry": "fast", "steps": 1000, "seconds": 1.0},
            {"round": 1, "entry": "base", "steps": 100, "seconds": 2.0},
            {"round": 1, "entry": "fast", "steps": 1000, "seconds": 2.0},
            {"round": 2, "entry": "base", "steps": 100, "seconds": 1.0},
            {"round": 2, "entry": "fast", "steps": 1000, "seconds": 0.5},
        ]
    )
    summary = speed.summarise(measured, base="base").set_index(["item", "quantity"])
    assert summary.loc[("fast", "ratio to plain Python"), ["value", "low", "high"]].tolist() == [10, 10, 20]
    assert summary.loc[("fast", "steps per CPU second"), ["value", "low", "high"]].tolist() == [1000, 500, 2000]
    assert summary.loc[("base", "ratio to plain Python"), "repeats"] == 3


def test_a_kernel_is_held_against_its_limit():
    measured = pd.DataFrame(
        [
            {
                "round": number,
                "entry": entry.label,
                "steps": 100 * (1 + (entry in speed.LIMITS)),
                "seconds": 1.0 + number,
            }
            for number in range(2)
            for entry in speed.ENTRIES + speed.LIMITS
        ]
    )
    limits = speed.summarise_limits(measured).set_index(["item", "quantity"])
    assert limits.loc[(speed.LIMITS[2].label, "per CPU second"), ["low", "high"]].tolist() == [100, 200]
    shares = limits[limits.index.get_level_values("quantity").str.startswith("share of bare random walk")]
    assert len(shares) == 4 and (shares["value"] == 0.5).all()
    assert not set(speed.summarise(measured)["item"]) & {entry.label for entry in speed.LIMITS}


# -- figure 8 by two methods ---------------------------------------------------------------------------------


def test_batches_hold_every_pair_once_by_both_methods():
    groups = [group for batch in range(3) for group in surveys.batch_of(SMALL, batch, 3)]
    pairs = [(state, other) for state, others in groups for other in others.tolist()]
    assert len(set(pairs)) == len(pairs) == SMALL.n_states * (SMALL.n_states - 1)
    for method in surveys.METHODS:
        taken = surveys.costs(SMALL, method, groups, 3, Learning())
        assert taken.shape == (SMALL.n_states, 3) and (taken[:, 1:] > 0).all()
        assert taken[:, 2].sum() == len(pairs)


def test_a_survey_with_trees_takes_fewer_steps(env2: GridWorld):
    groups = surveys.batch_of(env2, 0, 100)
    every_step, trees = (surveys.costs(env2, method, groups, 5, Learning())[:, 1].sum() for method in surveys.METHODS)
    assert trees < every_step / 2


def test_the_survey_has_a_row_for_each_method(tmp_path):
    path = tmp_path / "small.txt"
    path.write_text(SMALL.text)
    said: list[str] = []
    measured = figure8.measure({"small": path}, 2, '{"learning": {"alpha": 0.1}}', batches=2, say=said.append)
    assert len(said) == 4 and "survey, with trees: small, batch 2 of 2" in said
    summary = figure8.summarise(measured)
    assert summary["item"].unique().tolist() == ["survey, every step simulated", "survey, with trees"]
    values = summary.set_index(["item", "quantity"])["value"]
    for method in surveys.METHODS:
        assert values[method].index.tolist() == [
            f"{quantity}{ending}" for ending in ("", ", small") for quantity in ("core seconds", "steps", "pairs")
        ]
        assert values[method, "pairs"] == values[method, "pairs, small"] == SMALL.n_states * (SMALL.n_states - 1)
        assert values[method, "core seconds"] > 0 and values[method, "steps"] > values[method, "pairs"]


# -- start-up ------------------------------------------------------------------------------------------------


def test_the_timed_job_does_what_ptl_learn_does(tmp_path):
    from ptl.cli.learn import command as learn

    ours, theirs = tmp_path / "ours.h5", tmp_path / "theirs.h5"
    report = startup.run_job(ENV2, "no_transfer", ours)
    arguments = ["--map", str(ENV2), "--environment", "benchmark", "--tasks", "ABCDEF", "--method", "no_transfer"]
    done = CliRunner().invoke(learn, [*arguments, "--seed", "0", "--root-seed", "0", "--output", str(theirs)])
    assert done.exit_code == 0, done.output
    assert ours.read_bytes() == theirs.read_bytes()
    assert set(report) == {*startup.PHASES, "all", "peak"}
    assert sum(report[phase] for phase in startup.PHASES) == pytest.approx(report["all"], abs=0.05)
    assert 10 < report["peak"] < 1000


# -- a whole run ---------------------------------------------------------------------------------------------


def write_records(folder: Path, *products: tuple[str, str, float, float]) -> Path:
    """Records of products as Snakemake keeps them, named by numbers."""
    for place, (rule, log, start, end) in enumerate(products):
        path = folder / "deep" / str(place)
        path.parent.mkdir(exist_ok=True)
        path.write_text(json.dumps({"rule": rule, "log": [log], "starttime": start, "endtime": end}))
    return folder


def test_products_of_one_job_are_one_job(tmp_path):
    records = [("learn", "a.log", 3.0, 5.5), ("learn", "b.log", 4.0, 6.0), ("tabulate", "t.log", 6.0, 7.0),
               ("tabulate", "t.log", 6.5, 9.0)]  # fmt: skip
    jobs = run.read_jobs(write_records(tmp_path, *records))
    assert jobs[["rule", "start", "seconds"]].to_numpy().tolist() == [
        ["learn", 3.0, 2.5], ["learn", 4.0, 2.0], ["tabulate", 6.0, 3.0]
    ]  # fmt: skip


def whole_run() -> pd.DataFrame:
    jobs = pd.DataFrame({"rule": ["learn", "learn", "manifest"], "seconds": [4.0, 6.0, 0.5]})
    return run.summarise(run.Run(cores=2, wall=10.5, cpu=12.0, until_first_job=3.0, jobs=jobs))


def test_shares_are_of_the_time_of_all_cores():
    summary = whole_run().set_index(["item", "quantity"])["value"]
    assert summary[("learn", "jobs")] == 2
    assert summary[("learn", "share of core time")] == pytest.approx(10 / 21)
    assert summary[("whole run", "share of core time without a job")] == pytest.approx(10.5 / 21)


@pytest.mark.slow
def test_a_run_is_made_and_measured(tmp_path):
    project = Project(tmp_path)
    measured = run.measure(project.folder, project.config)
    jobs = measured.jobs.groupby("rule").size()
    assert jobs["learn"] == 6 and jobs["grow"] == 2 and jobs["manifest"] == 1
    assert 0 < measured.until_first_job < measured.wall
    assert (measured.jobs["seconds"] > 0).all() and measured.jobs["seconds"].sum() < measured.cores * measured.wall
    assert 1 < measured.cpu < measured.cores * measured.wall
    assert not (project.folder / "results").exists()


# -- growth --------------------------------------------------------------------------------------------------


def test_a_power_law_is_found_again():
    sizes = np.array([100.0, 1000, 10_000, 100_000])
    exponent, low, high = scaling.power_law(sizes, 3e-6 * sizes**1.5)
    assert (exponent, low, high) == pytest.approx((1.5, 1.5, 1.5))
    noise = np.exp([0.1, -0.1, -0.1, 0.1])
    exponent, low, high = scaling.power_law(sizes, 3e-6 * sizes * noise)
    assert low < exponent < high and exponent == pytest.approx(1.0)
    # the textbook's t interval of a slope, worked out by hand
    x = np.log(sizes) - np.log(sizes).mean()
    error = np.sqrt((np.log(noise) ** 2).sum() / 2 / (x**2).sum())
    assert high - exponent == pytest.approx(4.30265 * error, rel=1e-4)
    assert np.isnan(scaling.power_law(sizes[:2], sizes[:2])[1])


def test_exponents_are_fitted_to_large_sizes_only():
    sizes = [100, 1000, 10_000, 100_000]
    rows = [{"part": "states", "kind": "chain", "size": n, "quantity": "x, s", "value": max(n, 1000)} for n in sizes]
    rows.append({"part": "large", "kind": "rooms", "size": 300, "quantity": "x, s", "value": 1.0})
    frame = scaling.with_exponents(pd.DataFrame(rows), scaling.Plan())
    assert frame.loc[frame["part"] == "states", "exponent"].to_numpy() == pytest.approx([1.0] * 4)
    assert frame.loc[frame["part"] == "states", "fitted_from"].tolist() == [1000] * 4
    assert frame.loc[frame["part"] == "large", "exponent"].isna().all()


@pytest.mark.parametrize("kind", ["chain", "rooms", "maze"])
@pytest.mark.parametrize("states", [300, 3000, 30_000])
def test_a_world_has_about_the_states_asked_for(kind: str, states: int):
    world = probes.world_of(kind, states)
    assert world.n_states == pytest.approx(states, rel=0.15)
    assert probes.world_of(kind, states).text == world.text
    assert (world.distances_to(world.start) >= 0).all()


def test_a_ring_is_one_closed_corridor():
    world = probes.world_of("ring", 40)
    assert world.n_states == 40
    others = world.successors != np.arange(40)[:, None]
    assert (others.sum(axis=1) == 2).all() and (world.distances_to(0) >= 0).all()


def test_searches_are_counted(env2: GridWorld):
    assert probes.searches_of(lambda: env2.transitions.steps_to(0)) == 1
    assert probes.searches_of(lambda: [env2.distances_to(goal) for goal in (1, 2, 3)]) == 3


PLAN = scaling.Plan((100, 300), (100, 200), (1, 5), 4, 20, 100, (30, 60), 90, 180, 1, 100, 30, 1, 1)


@pytest.fixture(scope="module")
def growth() -> pd.DataFrame:
    monkeypatch = pytest.MonkeyPatch()
    monkeypatch.setattr(probes, "STEPS", 2 * probes.STEPS_FROM_A_START)

    def probe(kind: str, *arguments: str) -> list[dict]:
        return probes.records_of([kind, *arguments])

    monkeypatch.setattr(scaling, "probe", probe)
    yield scaling.measure(ENV2, PLAN)
    monkeypatch.undo()


def test_every_part_of_the_growth_is_measured(growth: pd.DataFrame):
    assert growth["part"].unique().tolist() == [
        "states",
        "diameter",
        "library",
        "tasks",
        "large",
        "survey",
        "life",
    ]
    assert growth.columns.tolist() == scaling.COLUMNS
    assert (growth["value"] >= 0).all()
    positive = growth[growth["quantity"].str.endswith(", s") & (growth["part"] != "large")]
    assert (positive["value"] > 0).all()
    searches = growth[(growth["part"] == "diameter") & (growth["quantity"] == "searches of the graph, count")]
    assert searches["value"].tolist() == [100, 200]
    stored = growth[growth["quantity"] == "policies, bytes"]
    assert stored["value"].iloc[1] == 5 * stored["value"].iloc[0]
    tasks = growth[(growth["part"] == "tasks") & (growth["quantity"] == "one task, s")]
    assert tasks["size"].tolist() == [1, 2, 4]


def test_growth_is_drawn_and_written_down(growth: pd.DataFrame, tmp_path):
    picture = figure.draw(growth)
    assert [axes.get_title(loc="left") for axes in picture.axes] == [
        "Work around the episodes",
        "One step of learning",
        "Library",
        "One life of many tasks",
        "Subgoals of all pairs on larger maps",
        "A life of ten tasks on larger maps",
    ]
    assert all(axes.get_xscale() == axes.get_yscale() == "log" for axes in picture.axes)
    text = pages.scaling_markdown({"processor": "some chip"}, growth)
    assert "some chip" in text and "A map of 20 × 20 cells" in text
    for quantity in growth.loc[growth["part"].isin(pages.SIZES), "quantity"].unique():
        assert f"| {quantity} |" in text


def test_larger_worlds_are_measured_by_both_methods(growth: pd.DataFrame):
    survey = growth[growth["part"] == "survey"].set_index(["kind", "size", "quantity"])["value"].sort_index()
    for kind in ("rooms", "maze"):
        for size in survey[kind].index.unique("size"):
            value = survey[kind, size]
            assert value["survey, every step simulated, steps"] > value["survey, with trees, steps"]
            assert value["survey, with trees, pairs timed, count"] == min(3 + 3 * (size < 45), size) * (size - 1)
            assert value["survey, every step simulated, pairs timed, count"] == 5 * 3
    life = growth[(growth["part"] == "life") & growth["quantity"].str.endswith(", s")]
    assert len(life) == 4 and life["exponent"].notna().all()
    text = pages.scaling_markdown({}, growth)
    assert text.count("| extrapolated |") == 6
    assert "| rooms, " in text and "| maze, " in text


def test_the_size_of_ten_minutes_is_between_sizes_or_extrapolated():
    rows = [
        {"part": "life", "kind": "maze", "size": n, "quantity": "x, s", "value": n**2 / 1e4} for n in (300, 1000, 3000)
    ]
    curve = scaling.with_exponents(pd.DataFrame(rows), scaling.Plan())
    size, within = scaling.size_at(curve, 400.0)
    assert size == pytest.approx(2000) and within
    size, within = scaling.size_at(curve, 1e4)
    assert size == pytest.approx(10_000) and not within
    size, within = scaling.size_at(curve, 1.0)
    assert size == pytest.approx(100) and not within


def test_a_probe_runs_in_a_process_of_its_own():
    records = scaling.probe("diameter", "ring", "40")
    assert records[0] == {"quantity": "states", "value": 40}


# -- pages ---------------------------------------------------------------------------------------------------


def summaries() -> dict[str, pd.DataFrame]:
    rates = pd.DataFrame(
        [
            {"round": 0, "entry": entry.label, "steps": 3_000_000, "seconds": 2.0 - (entry in speed.LIMITS)}
            for entry in speed.ENTRIES + speed.LIMITS
        ]
    )
    batches = [
        {"item": method, "map": name, "core seconds": seconds, "steps": 5e9 * seconds, "pairs": 600.0}
        for method, seconds in zip(surveys.METHODS, (20.0, 2.0), strict=True)
        for name in ("env8", "env9")
    ]
    phases = dict.fromkeys(startup.PHASES, 0.01)
    jobs = [{"round": n, "method": "ptl", **phases, "all": 0.06 + 0.01 * n, "peak": 50.0} for n in range(3)]
    return {
        "speed": speed.summarise(rates),
        "limit": speed.summarise_limits(rates),
        "survey": figure8.summarise(pd.DataFrame(batches)),
        "startup": startup.summarise(pd.DataFrame(jobs)),
        "run": whole_run(),
    }


def test_the_page_says_what_was_measured():
    text = pages.benchmark_markdown({"processor": "some chip"}, **summaries(), place="env9", letter="Z")
    assert "Q-learning of env9, task Z," in text and "All tasks of env9," in text
    assert "| kernel, every step simulated | 1,500 | 1,500 to 1,500 | 1 | 1 to 1 |" in text
    assert "| bare random walk, one step a look-up | 3 | 3 to 3 |" in text
    assert "simulated: share of bare random walk, one step a look-up | 50% | 50% to 50% |" in text
    assert "| all maps | 1,200 | 40 | 4 | 10 | 200 | 20 |" in text
    assert "| env8 | 600 | 20 | 2 | 10 | 100 | 10 |" in text
    assert "| PTL | 10 | 10 | 10 | 10 | 10 | 10 | 0.07 | 0.06 to 0.08 | 50 |" in text
    assert "| learn | 2 | 10 | 5 | 47.62% |" in text
    assert "cores: 2; wall seconds: 10.5; CPU seconds: 12; wall seconds before the first job: 3." in text
    assert run.NOTE in text


def test_the_table_holds_all_numbers():
    parts = summaries()
    table = pages.benchmark_csv({"processor": "some chip"}, **parts)
    assert table.columns.tolist() == pages.CSV_COLUMNS
    assert len(table) == 1 + sum(map(len, parts.values()))
    assert table["part"].unique().tolist() == ["machine", *parts]
    assert table.loc[table["part"] != "machine", "value"].notna().all()
    survey = table[table["item"].isin(["survey, every step simulated", "survey, with trees"])]
    assert {"core seconds", "steps", "pairs"} <= set(survey["quantity"]) and len(survey) == 18


@pytest.mark.parametrize(
    ("value", "quantity", "text"),
    [
        (2.5e-9, "one step, s", "2.5 ns"),
        (0.0421, "x, s", "42.1 ms"),
        (12.0, "x, s", "12 s"),
        (123456789.0, "steps, count", "123,456,789"),
        (786.67, "first episode, steps", "786.7"),
        (66.42, "memory, MiB", "66.42 MiB"),
    ],
)
def test_values_carry_a_fitting_unit(value: float, quantity: str, text: str):
    assert pages.quantity_text(value, quantity) == text


def test_the_machine_is_described_without_names():
    described = machine.describe()
    assert described["Python"].endswith(platform.python_version())
    assert int(described["cores"]) >= 1
    words = " ".join(described.values()).split()
    assert socket.gethostname() not in words and getpass.getuser() not in words
