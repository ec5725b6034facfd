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

from ptl.benchmark import contestants, machine, pages, probes, run, scaling, speed, startup
from ptl.benchmark.contestants import GymnasiumLoop, Kernel, KernelEveryStep, NumbaLoop, PlainLoop
from ptl.benchmark.task import Task
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


@pytest.mark.parametrize("kind", INSTALLED)
def test_first_episodes_have_the_length_of_a_random_walk(kind: type):
    expected, episodes = mean_first_episode(SMALL, SMALL.goals["A"]), 200 if kind is GymnasiumLoop else 2000
    steps = kind(small_task(alpha=0.0), 3).run(episodes)
    # the length's standard deviation is about its mean; the seed is fixed, so this holds always or never
    assert steps / episodes == pytest.approx(expected, abs=4 * expected / episodes**0.5)


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


@pytest.mark.parametrize("kind", ["chain", "rooms"])
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


def test_searches_are_counted_and_the_counter_is_taken_off(env2: GridWorld):
    from ptl.world import transitions

    search = transitions.breadth_first
    assert probes.searches_of(lambda: env2.transitions.steps_to(0)) == 1
    with pytest.raises(ZeroDivisionError):
        probes.searches_of(lambda: 1 / 0)
    assert transitions.breadth_first is search


PLAN = scaling.Plan((100, 300), (100, 200), (1, 5), 4, 20, 100, 100, 1, 1)


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
    assert growth["part"].unique().tolist() == ["states", "diameter", "library", "tasks", "large"]
    assert growth.columns.tolist() == scaling.COLUMNS
    assert (growth["value"] >= 0).all()
    positive = growth[growth["quantity"].str.endswith(", s") & (growth["part"] != "large")]
    assert (positive["value"] > 0).all()
    searches = growth[(growth["part"] == "diameter") & (growth["quantity"] == "searches of the graph, count")]
    assert searches["value"].tolist() == [101, 201]
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
    ]
    assert all(axes.get_xscale() == axes.get_yscale() == "log" for axes in picture.axes)
    text = pages.scaling_markdown({"processor": "some chip"}, growth)
    assert "some chip" in text and "A map of 20 × 20 cells" in text
    for quantity in growth.loc[growth["part"] != "large", "quantity"].unique():
        assert f"| {quantity} |" in text


def test_a_probe_runs_in_a_process_of_its_own():
    records = scaling.probe("diameter", "ring", "40")
    assert records[0] == {"quantity": "states", "value": 40}


# -- pages ---------------------------------------------------------------------------------------------------


def summaries() -> tuple[pd.DataFrame, pd.DataFrame]:
    rates = [{"round": 0, "entry": entry.label, "steps": 3_000_000, "seconds": 2.0} for entry in speed.ENTRIES]
    phases = dict.fromkeys(startup.PHASES, 0.01)
    jobs = [{"round": n, "method": "ptl", **phases, "all": 0.06 + 0.01 * n, "peak": 50.0} for n in range(3)]
    return speed.summarise(pd.DataFrame(rates)), startup.summarise(pd.DataFrame(jobs))


def test_the_page_says_what_was_measured():
    text = pages.benchmark_markdown({"processor": "some chip"}, *summaries(), whole_run(), place="env9", letter="Z")
    assert "Q-learning of env9, task Z," in text and "All tasks of env9," in text
    assert "| kernel, every step simulated | 1,500 | 1,500 to 1,500 | 1 | 1 to 1 |" in text
    assert "| PTL | 10 | 10 | 10 | 10 | 10 | 10 | 0.07 | 0.06 to 0.08 | 50 |" in text
    assert "| learn | 2 | 10 | 5 | 47.62% |" in text
    assert "cores: 2; wall seconds: 10.5; CPU seconds: 12; wall seconds before the first job: 3." in text


def test_the_table_holds_all_numbers():
    rates, jobs = summaries()
    rules = whole_run()
    table = pages.benchmark_csv({"processor": "some chip"}, rates, jobs, rules)
    assert table.columns.tolist() == pages.CSV_COLUMNS
    assert len(table) == 1 + len(rates) + len(jobs) + len(rules)
    assert table["part"].unique().tolist() == ["machine", "speed", "start-up", "run"]
    assert table.loc[table["part"] != "machine", "value"].notna().all()


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
