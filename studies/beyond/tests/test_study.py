"""The second study: from the design to lives, and from lives to estimates worked out by hand."""

from __future__ import annotations

import itertools
import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from projects import ROOT

from ptl.agent.subgoals import discover
from ptl.config import Parameters
from ptl.errors import UserError
from ptl.files.csv import write_csv
from ptl.files.verification import faults_of
from ptl.learning.life import learn_life, tasks_of
from ptl.measures.statistics import Resampling
from ptl.methods import beyond
from ptl.world.gridworld import GridWorld
from ptl.world.transitions import TransitionGraph
from studies.beyond import summary
from studies.beyond.collect import LIFE_COLUMNS, per_life, per_task, read_lives, read_tasks
from studies.beyond.design import Study, cells, job_of, method_digest, read_study
from studies.beyond.methods._sized import sized
from studies.beyond.methods.ptl_farthest import Method as Farthest
from studies.beyond.population import load_entry, read_population
from studies.beyond.running import run_cell

HOW = Resampling(0.95, 4000)
SMALL = {
    "population": str(ROOT / "config/population.csv"), "methods": ["no_transfer", "ptl", "rmax_memory"], "maps": 2,
    "seeds": 2, "families": ["rooms"], "learning": {"episodes": 5}, "article_seeds": 2,
}  # fmt: skip


def lives_of(logs: dict[str, list[list[float]]], family: str = "rooms") -> pd.DataFrame:
    """Lives with these logarithms of the cost: method -> map -> seed."""
    rows = [
        (family, str(place), 300, "increasing", method, seed, 1000 * np.exp(log), 1000, 3)
        for method, maps in logs.items()
        for place, row in enumerate(maps)
        for seed, log in enumerate(row)
    ]
    return pd.DataFrame(rows, columns=list(LIFE_COLUMNS))


# -- the bootstrap and what is estimated with it


def test_the_hierarchical_bootstrap_against_all_of_its_outcomes():
    """Two maps with two lives each: 4 draws of maps, 16 of lives; every mean has its exact probability."""
    logs = np.array([[0.0, 1.0], [3.0, 5.0]])
    exact = [
        np.mean([logs[place, chosen] for place, pair in zip(maps, (first, second), strict=True) for chosen in pair])
        for maps in itertools.product(range(2), repeat=2)
        for first in itertools.product(range(2), repeat=2)
        for second in itertools.product(range(2), repeat=2)
    ]
    drawn = summary.resample({"ptl": logs}, "rooms", HOW).means["ptl"]
    assert set(np.round(drawn, 9)) == set(np.round(exact, 9))
    for value in set(exact):
        share = np.mean(np.isclose(exact, value))
        assert abs(np.mean(np.isclose(drawn, value)) - share) < 5 * np.sqrt(share * (1 - share) / HOW.resamples)
    cost = summary.costs(lives_of({"ptl": logs.tolist()}), HOW).iloc[0]
    assert (cost["maps"], cost["seeds"]) == (2, 2)
    assert cost["cost"] == pytest.approx(np.exp(9 / 4))
    assert (cost["low"], cost["high"]) == pytest.approx(np.exp(np.quantile(drawn, [0.025, 0.975])))


def test_a_map_of_the_article_has_its_lives_drawn_only():
    drawn = summary.resample({"ptl": np.array([[0.0, 1.0]])}, "env1", HOW).means["ptl"]
    assert [np.mean(drawn == value) for value in (0, 0.5, 1)] == pytest.approx([0.25, 0.5, 0.25], abs=0.04)


def test_methods_are_compared_on_the_same_maps():
    """Lives that differ between maps but not on them: the ratio to the base is exact, costs are not."""
    base = np.array([[1.0, 1.0], [4.0, 4.0], [2.0, 2.0]])
    logs = {"ptl": base.tolist(), "half": (base - np.log(2)).tolist()}
    half = summary.costs(lives_of(logs), HOW).set_index("method").loc["half"]
    assert (half["ratio"], half["ratio_low"], half["ratio_high"]) == pytest.approx((0.5, 0.5, 0.5))
    assert half["low"] < half["cost"] < half["high"]


def test_probability_of_improvement_by_hand():
    """On map 0 three of four pairs are better and one is a tie; on map 1 none is."""
    values, base = np.array([[0.0, 1.0], [9.0, 9.0]]), np.array([[1.0, 2.0], [3.0, 3.0]])
    found = summary.improvement(values, base, HOW)
    assert found.value == (3.5 / 4 + 0) / 2
    assert (found.low, found.high) == (0, 3.5 / 4)


def test_performance_profiles_by_hand():
    lives = lives_of({"ptl": np.log([[1.0, 2.0], [10.0, 150.0]]).tolist()})
    profile = summary.profiles(lives, HOW).set_index("threshold")
    assert profile["share"].iloc[[0, -1]].tolist() == [0.25, 1.0]
    assert profile.loc[:9.9, "share"].max() == 0.5 and profile["share"].is_monotonic_increasing
    assert (profile["low"] <= profile["share"]).all() and (profile["share"] <= profile["high"]).all()


def test_variance_between_maps_and_between_lives_is_told_apart():
    random = np.random.default_rng(3)
    of_map = random.normal(0, 0.8, (400, 1))
    base = random.normal(0, 1, (400, 3))
    logs = {"ptl": base.tolist(), "other": (base + of_map + random.normal(0, 0.4, (400, 3))).tolist()}
    row = summary.variance_components(lives_of(logs)).iloc[0]
    assert row["between_maps"] == pytest.approx(0.64, rel=0.15)
    assert row["between_lives"] == pytest.approx(0.16, rel=0.15)
    assert row["intraclass"] == pytest.approx(0.8, abs=0.03)
    # the same lives on a tenth of the maps would leave the maps' part of the error ten times as large
    assert row["error"] == pytest.approx(np.sqrt((0.64 + 0.16 / 3) / 400), rel=0.1)
    assert row["error_fewer_maps"] == pytest.approx(np.sqrt((6.4 + 0.16 / 3) / 400), rel=0.1)


def test_methods_must_have_been_run_on_the_same_maps():
    lives = lives_of({"ptl": [[1.0], [2.0]], "mine": [[1.0], [2.0]]})
    with pytest.raises(UserError, match=r"method mine: its lives in the family rooms are not those of the other"):
        summary.costs(lives.drop(lives.index[-1]), HOW)


def tasks_table() -> pd.DataFrame:
    """A method as it is (2 tasks), and with libraries of 2 and 4 skills."""
    rows = []
    for added, steps in ((0, (100, 400)), (2, (100, 200)), (4, (100, 50))):
        for task, number in enumerate(steps, start=1):
            rows.append(("rooms", "4000", 300, "increasing", "ptl", added, 0, task, number, 7, 50, 0,
                         max(1, added) * task, 290, 1.5))  # fmt: skip
    columns = ("family", "map", "size", "sequence", "method", "per_task", "seed", "task", "steps", "first_episode",
               "optimum", "truncated", "library_size", "states", "winding")  # fmt: skip
    return pd.DataFrame(rows, columns=list(columns))


def test_costs_against_tasks_library_size_and_winding_by_hand():
    tasks = tasks_table()
    assert summary.by_task(tasks, "increasing", HOW)[["task", "cost"]].values == pytest.approx(
        np.array([[1, 2], [2, 8]])
    )
    sizes = summary.by_library_size(tasks, HOW).set_index("per_task")
    # the library at the beginning of the second task, whose cost it is about
    assert sizes["library_size"].to_dict() == {0: 1, 2: 2, 4: 4}
    assert sizes["cost"].to_dict() == pytest.approx({0: 8, 2: 4, 4: 1})
    lives = per_life(tasks)
    assert lives.values.tolist() == [["rooms", "4000", 300, "increasing", "ptl", 0, 400, 50, 2]]
    entry = next(e for e in read_population(ROOT / "config/population.csv") if (e.family, e.seed) == ("rooms", 4000))
    windings = summary.by_winding(lives, [entry])
    assert windings[["winding", "cost"]].values.tolist() == [[entry.winding, pytest.approx(8)]]


# -- from the design to lives


def test_jobs_are_all_and_only_those_of_the_design():
    study = Study.read(
        {**SMALL, "maps": 5, "batch": 2, "sequences": {"names": ["random"], "methods": ["ptl"], "maps": 3},
         "library_sizes": {"methods": ["ptl"], "per_task": [1, 2], "maps": 1},
         "article_maps": {"env1": {"map": "config/environments/env1.txt", "tasks": "AB"}}}
    )  # fmt: skip
    made = list(cells(study))
    assert len({cell.name for cell in made}) == len(made)
    maps = [(cell.sequence, cell.method, cell.per_task, place) for cell in made for place in cell.maps]
    assert len(set(maps)) == len(maps)
    counts = pd.Series([(sequence, per_task > 0) for sequence, _, per_task, _ in maps]).value_counts().to_dict()
    assert counts == {("increasing", False): 15, ("random", False): 3, ("increasing", True): 2,
                      ("article", False): 3, ("article", True): 2}  # fmt: skip


def test_the_shipped_configurations_are_right(monkeypatch):
    monkeypatch.chdir(ROOT)
    study = read_study("config/beyond.yaml")
    assert set(beyond.names()) - set(study.methods) == {"ptl_frontier_path"}
    assert all(cell.seeds * len(cell.maps) > 0 for cell in cells(study))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"maps": 101}, "maps: 101 is not allowed; give at most 100"),
        ({"size": 301}, "size: 301 is not allowed; give one of 300"),
        ({"families": ["sea"]}, "families: 'sea' is not allowed; give one of chain"),
        ({"families": ["cave", "cave"]}, "families: cave is repeated"),
        ({"methods": ["ptl", "fly"]}, "unknown method 'fly'"),
        ({"library_sizes": {"methods": ["rmax_memory"]}}, "library_sizes.methods: 'rmax_memory'"),
        ({"library_sizes": {"methods": ["ptl"], "per_task": [0]}}, "library_sizes.per_task"),
        ({"sequences": {"names": ["increasing"]}}, "sequences.names"),
        ({"methods": []}, "methods: is empty, and so is foreign_lives"),
        ({"map": 1}, "map"),
        ({"article_maps": [1]}, "article_maps: [1] is not allowed"),
        ({"article_maps": "abc"}, "article_maps: 'abc' is not allowed"),
    ],
)
def test_what_cannot_be_run_is_refused(changes, message):
    with pytest.raises(UserError) as raised:
        Study.read({**SMALL, **changes})
    assert message in str(raised.value)


def test_lives_of_a_job_are_those_that_the_library_learns(tmp_path: Path):
    article = {"map": str(ROOT / "config/environments/env2.txt"), "tasks": "AB"}
    study = Study.read({**SMALL, "article_maps": {"env2": article}})
    paths = []
    for cell in cells(study):
        paths.append(tmp_path / f"{cell.name}.h5")
        run_cell(json.loads(json.dumps(job_of(cell, study, "0" * 16))), paths[-1], method_digest(cell.method))
        assert faults_of(paths[-1]) == []
    assert faults_of(paths[0].rename(paths[0].with_stem("moved"))) != []
    paths[0].with_stem("moved").rename(paths[0])
    tasks = per_task(paths)
    entry = next(e for e in read_population(study.population) if (e.family, e.seed) == ("rooms", 4001))
    world = load_entry(entry)
    parameters = Parameters().replace(learning__episodes=5)
    names = ("rooms", 300, "increasing", 4001, 1)
    life = learn_life(world, tasks_of(world, "ABCDEF"), "ptl", parameters, study.root_seed, *names)
    own = tasks[
        (tasks["family"] == "rooms") & (tasks["map"] == "4001") & (tasks["method"] == "ptl") & (tasks["seed"] == 1)
    ]
    assert own["steps"].tolist() == [record.steps.sum() for record in life.records]
    assert own["library_size"].iloc[-1] == len(life.library)
    assert own["optimum"].tolist() == [5 * length for length in entry.shortest_paths]
    assert set(tasks.loc[tasks["family"] == "env2", ["map", "sequence"]].itertuples(index=False, name=None)) == {
        ("env2", "article")
    }
    lives = per_life(tasks)
    assert len(lives) == 3 * (2 * 2 + 2)
    assert (lives["total_steps"] >= lives["optimum"]).all()
    for frame, name, read in ((tasks, "tasks.csv", read_tasks), (lives, "lives.csv", read_lives)):
        write_csv(frame, tmp_path / name, sealed=True)
        again = read(tmp_path / name)
        assert again.drop(columns="winding", errors="ignore").equals(
            frame.drop(columns="winding", errors="ignore").astype(again.dtypes.drop("winding", errors="ignore"))
        )
    write_csv(pd.concat([lives, lives.tail(1)]), tmp_path / "twice.csv")
    with pytest.raises(UserError, match="is there twice"):
        read_lives(tmp_path / "twice.csv")


def test_a_library_of_a_given_size_has_that_many_skills_of_its_finder():
    """With the farthest state as finder this is greedy k-centre."""
    world = GridWorld.from_text("I....\n.###.\n....A\n")
    method = sized(Farthest, "ptl_farthest", 3)(world, Parameters(), np.random.default_rng(0))
    graph = TransitionGraph(world.successors)
    method.library.update(discover([np.array([world.start, 1])], graph, [], 2), graph, 0)
    distance = np.array([world.distances_to(state) for state in range(world.n_states)])
    centres = [world.start]
    for _ in range(3):
        centres.append(int(distance[centres].min(axis=0).argmax()))
    assert method.library.subgoals == centres[1:]
    for skill in method.library.skills:
        assert skill.policy.tolist() == graph.shortest_path_policy(skill.subgoal).tolist()
    method.library.update(discover([], graph, [], 2), graph, 1)  # nothing was reached: nothing is added
    assert len(method.library) == 3


@pytest.mark.parametrize("label", ["A\u202egnp.exe", "A\x1b[31m", "_hidden", 5])
def test_a_label_that_cannot_be_shown_is_refused(tmp_path, label):
    (tmp_path / "mine.py").write_text(
        "from ptl.methods.no_transfer import Method as NoTransfer\n\n\n"
        f"class Method(NoTransfer):\n    label = {label!r}\n    colour = '#123456'\n"
    )
    with pytest.raises(UserError, match="label"):
        Study.read({**SMALL, "methods": ["ptl", str(tmp_path / "mine.py")]})
