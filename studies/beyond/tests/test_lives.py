"""The second study: from the design to lives, and from lives to estimates worked out by hand."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml
from projects import ROOT, imports_of_a_fork

from ptl.agent.subgoals import discover
from ptl.config import Parameters
from ptl.errors import UserError
from ptl.files import store
from ptl.files.csv import write_csv
from ptl.jobs.kinds import job_from
from ptl.learning.life import learn_life, tasks_of
from ptl.measures.statistics import Resampling
from ptl.report.format_tables import filled
from ptl.world.gridworld import GridWorld
from ptl.world.map_files import load_map
from ptl.world.optimum import optimal_steps
from ptl.world.transitions import TransitionGraph
from studies.beyond import page, summary
from studies.beyond.collect import LIFE_COLUMNS, per_life, per_task, read_lives, read_tasks
from studies.beyond.design import SecondStudy, read_study
from studies.beyond.figures import Look
from studies.beyond.jobs import LivesOnMaps
from studies.beyond.lives import NO_CHANGE
from studies.beyond.methods import names
from studies.beyond.methods._sized import sized
from studies.beyond.methods.ptl_farthest import Method as Farthest
from studies.beyond.planned import cost_of_lives, given_maps, lives_jobs, population_of
from studies.beyond.population import read_population

FOLDER = Path(__file__).parent.parent
HOW = Resampling(0.95, 4000)
SMALL = {
    "methods": ["no_transfer", "ptl", "rmax_memory"], "maps": 2, "seeds": 2, "families": ["rooms"],
    "learning": {"episodes": 5}, "article_seeds": 2,
}  # fmt: skip
ENV2 = {"map": str(ROOT / "config/environments/env2.txt"), "tasks": "AB"}
ARENA = "type octile\nheight 4\nwidth 5\nmap\n.....\n.@.@.\n.....\n.....\n"


def planned(study: SecondStudy) -> list[LivesOnMaps]:
    """The jobs of a study."""
    return list(lives_jobs(study, population_of(study), given_maps(study)).values())


def lived(job: LivesOnMaps, study: SecondStudy, folder: Path) -> store.Result:
    """Do a job and read its file back."""
    worlds = {} if job.size else {job.places[0]: given_maps(study)[job.family, job.places[0]].world}
    path = folder / job.place
    store.write(path, job, job.run(worlds), worlds)
    return store.read(path, job)


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


def estimated(logs: dict[str, list[list[float]]]) -> pd.DataFrame:
    """Costs of lives with these logarithms, by method."""
    frame = lives_of(logs)
    return summary.costs(summary.Means(frame, HOW), frame).set_index("method")


def test_the_bootstrap_against_all_of_its_outcomes():
    """Two maps with means 0.5 and 4: of four draws one has the first twice, one the second twice, two have both."""
    logs = np.array([[0.0, 1.0], [3.0, 5.0]])
    drawn = summary.resample(logs, "rooms", "ptl", HOW)
    shares = [np.mean(np.isclose(drawn, value)) for value in (0.5, 2.25, 4)]
    assert sum(shares) == 1 and shares == pytest.approx([0.25, 0.5, 0.25], abs=0.04)
    cost = estimated({"ptl": logs.tolist()}).iloc[0]
    assert (cost["maps"], cost["seeds"]) == (2, 2)
    assert (cost["cost"], cost["low"], cost["high"]) == pytest.approx(np.exp([2.25, 0.5, 4]))


def test_a_map_of_the_article_has_its_lives_drawn():
    drawn = summary.resample(np.array([[0.0, 1.0]]), "env1", "ptl", HOW)
    assert [np.mean(drawn == value) for value in (0, 0.5, 1)] == pytest.approx([0.25, 0.5, 0.25], abs=0.04)
    other = summary.resample(np.array([[0.0, 1.0]]), "env1", "other", HOW)
    assert abs(np.corrcoef(drawn, other)[0, 1]) < 0.1  # lives of two methods have nothing in common
    assert np.isnan(summary.resample(np.array([[1.0]]), "env1", "ptl", HOW)).all()


def test_methods_are_compared_on_the_same_maps():
    """Lives that differ between maps but not on them: the ratio to the base is exact, costs are not."""
    base = np.array([[1.0, 1.0], [4.0, 4.0], [2.0, 2.0]])
    half = estimated({"ptl": base.tolist(), "half": (base - np.log(2)).tolist()}).loc["half"]
    assert (half["ratio"], half["ratio_low"], half["ratio_high"]) == pytest.approx((0.5, 0.5, 0.5))
    assert half["low"] < half["cost"] < half["high"]


def test_families_count_alike_in_a_comparison():
    """Ratios 2 and 8 in families of two and of three maps: 4 over both."""
    few, many = [[1.0], [3.0]], [[0.0], [2.0], [5.0]]
    parts = [
        lives_of({"ptl": few, "other": (np.array(few) + np.log(2)).tolist()}, "rooms"),
        lives_of({"ptl": many, "other": (np.array(many) + np.log(8)).tolist()}, "cave"),
    ]
    means = summary.Means(pd.concat(parts), HOW)
    found = means.compare(["rooms", "cave"], "other", "ptl")
    assert (found.overall.value, found.overall.low, found.overall.high) == pytest.approx((4, 4, 4))
    assert [ratio.value for ratio in found.families.values()] == pytest.approx([2, 8])
    assert (found.less, found.more) == (0, 2)
    cost = means.cost(["rooms", "cave"], "ptl")
    assert cost.value == pytest.approx(np.exp((2 + 7 / 3) / 2))


def test_probability_of_improvement_by_hand():
    """On map 0 three of four pairs are better and one is a tie; on map 1 none is."""
    values, base = np.array([[0.0, 1.0], [9.0, 9.0]]), np.array([[1.0, 2.0], [3.0, 3.0]])
    found = summary.improvement(values, base, HOW, "rooms", "other")
    assert found.value == (3.5 / 4 + 0) / 2
    assert (found.low, found.high) == (0, 3.5 / 4)
    one = summary.improvement(values[:1], base[:1], HOW, "env1", "other")
    assert (one.value, one.low, one.high) == (3.5 / 4, 0.5, 1)


def test_hardness_by_hand():
    """The arena's longest way is from corner to corner: 3 + 4 steps."""
    assert summary.diameter(GridWorld.from_text("I....\n.###.\n....A\n")) == 6
    assert summary.diameter(GridWorld.from_text("I..A\n")) == 3
    entries = [e for e in read_population() if (e.family, e.size) == ("rooms", 300) and e.seed in (4000, 4001)]
    logs = {"ptl": [[1.0, 3.0], [2.0, 2.0]], "mine": [[0.0, 0.0], [1.0, 1.0]]}
    lives = lives_of(logs)
    lives["map"] = lives["map"].replace({"0": "4000", "1": "4001"})
    frame = summary.hardness(lives, entries, ["no_transfer", "ptl", "mine"])
    assert list(frame.columns) == ["family", "map", "diameter", "winding", "ptl", "mine"]
    assert frame["winding"].tolist() == [entry.winding for entry in entries]
    assert frame["diameter"].tolist() == [summary.diameter(entry.world()) for entry in entries]
    assert frame[["ptl", "mine"]].to_numpy() == pytest.approx(np.exp([[2, 0], [2, 1]]))


def test_rank_correlations_by_hand():
    """Orders that are kept, turned, both at once in two groups, tied, and without variation in one group or in all."""
    x, y = np.array([1.0, 2, 3]), np.array([10.0, 20, 30])
    assert summary.rank_correlation([(x, y)]) == pytest.approx(1)
    assert summary.rank_correlation([(x, -y)]) == pytest.approx(-1)
    assert summary.rank_correlation([(x, y), (x, -y)]) == pytest.approx(0)
    # ranks 1 2.5 2.5 4 and 2 1 3 4: products 1.5 x 0.5 + 1.5 x 1.5 = 3, sums of squares 4.5 and 5
    tied = summary.rank_correlation([(np.array([1.0, 5, 5, 9]), np.array([4.0, 2, 6, 8]))])
    assert tied == pytest.approx(3 / np.sqrt(4.5 * 5))
    assert summary.rank_correlation([(x, y), (np.ones(3), y)]) == pytest.approx(6 / np.sqrt(4 * 2) / 3)
    assert np.isnan(summary.rank_correlation([(np.ones(3), y)]))


def test_trends_with_hardness_are_over_all_maps_and_within_families():
    """In both families the cost falls with the diameter, yet the family of wide maps is the dearer one."""
    frame = pd.DataFrame(
        {"family": ["a"] * 6 + ["b"] * 6, "map": list("abcdefghijkl"), "diameter": [1, 2, 3, 4, 5, 6, *range(11, 17)],
         "winding": np.linspace(1, 2, 12), "no_transfer": 50.0, "ptl": [6.0, 5, 4, 3, 2, 1, *range(26, 20, -1)]}
    )  # fmt: skip
    trends = summary.hardness_trends(frame, HOW).set_index(["cost", "hardness", "scope"])
    # differences of ranks in a family are 5 3 1 1 3 5, their squares 70; 1 - 6 x 140 / (12 x 143) over both
    everywhere = trends.loc["ptl", "diameter", summary.ALL_MAPS]
    assert everywhere["value"] == pytest.approx(1 - 840 / 1716)
    assert 0 < everywhere["low"] < everywhere["high"] < 1
    assert trends.loc["ptl", "diameter", summary.WITHIN].tolist() == pytest.approx([-1, -1, -1])
    assert trends.loc[
        summary.SAVED,
        "diameter",
        summary.WITHIN,
    ]["value"] == pytest.approx(-1)
    assert np.isnan(trends.loc["no_transfer", "diameter", summary.ALL_MAPS]["value"])
    looks = {"ptl": Look("PTL", "#000000")}
    answer = page.hardness_answer(trends.reset_index(), looks)
    assert "with the diameter 0.51 [" in answer["lead"]
    assert (
        "] over all maps (PTL saves less on harder maps), −1 [−1, −1] within families (PTL saves more" in answer["lead"]
    )
    assert answer["lines"] == [line for line in answer["lines"] if line.startswith("Of the cost of “PTL”, over all")]


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
        summary.Means(lives.drop(lives.index[-1]), HOW)


def tasks_table() -> pd.DataFrame:
    """A method as it is (2 tasks), and with libraries of 2 and 4 skills."""
    rows = []
    for added, steps in ((0, (100, 400)), (2, (100, 200)), (4, (100, 50))):
        for task, number in enumerate(steps, start=1):
            rows.append(("rooms", "4000", 300, "increasing", "ptl", added, 0, task, number, 7, 50, 0,
                         max(1, added) * task, 290, 1.5))  # fmt: skip
    columns = ("family", "map", "size", "sequence", "method", "per_task", "seed", "task", "steps", "first_episode",
               "optimum", "truncated", "library_size", "states", "winding")  # fmt: skip
    return pd.DataFrame(rows, columns=list(columns)).assign(slip=0.0, change=NO_CHANGE)


def test_costs_against_tasks_and_library_size_by_hand():
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


# -- worlds that slip or change


def constant_lives(method: str, steps: int, **world: object) -> pd.DataFrame:
    """Two lives on each of two maps, optimum 100."""
    rows = [("rooms", place, 300, "increasing", method, seed, steps, 100, 0) for place in "ab" for seed in range(2)]
    return pd.DataFrame(rows, columns=list(LIFE_COLUMNS)).assign(**world)


def test_costs_in_harder_worlds_stand_beside_those_of_the_certain_one_on_the_same_maps():
    main = pd.concat([constant_lives("ptl", 800), constant_lives("rmax_memory", 200)])
    slips = [
        constant_lives("ptl", 400, slip=0.2, change=NO_CHANGE),
        constant_lives("rmax_memory", 100, slip=0.2, change=NO_CHANGE),
    ]
    door = [
        constant_lives("ptl", 100, slip=0.0, change="door"),
        constant_lives("rmax_memory", 300, slip=0.0, change="door"),
    ]
    harder = pd.concat([*slips, *door])
    harder = harder[harder["map"] == "a"]
    worlds = summary.by_world(harder, main, HOW)
    frame = pd.concat([costs for _, costs in worlds.values()])
    costs = frame.set_index(["world", "method"])["cost"].to_dict()
    expected = {("certain", "ptl"): 8, ("certain", "rmax_memory"): 2, ("slip 0.2", "ptl"): 4}
    expected |= {("slip 0.2", "rmax_memory"): 1, ("a door changes", "ptl"): 1, ("a door changes", "rmax_memory"): 3}
    assert costs == pytest.approx(expected)
    assert set(frame["maps"]) == {1}
    looks = {name: Look(name.upper(), "#000000") for name in ("ptl", "rmax_memory")}
    answer = page.harder_answer({name: means for name, (means, _) in worlds.items()}, looks, ["rooms"])
    assert answer["lead"] == "It turns for “RMAX_MEMORY”."
    assert answer["lines"] == ["“RMAX_MEMORY”: cheaper than PTL: certain, slip 0.2; dearer: a door changes."]
    same = {name: means for name, (means, _) in worlds.items() if name != "a door changes"}
    lead = page.harder_answer(same, looks, ["rooms"])["lead"]
    assert lead == "Cheaper than PTL in all 2 worlds: “RMAX_MEMORY”. No comparison with PTL turns."
    groups = page.by_group_table(worlds, looks, {"rooms": "Rooms"}, ["rooms"], "", "").groups
    assert [group.name for group in groups] == [page.EVERY, "rooms"]
    assert [[cell.text for cell in row.cells] for row in groups[1].rows] == [["0.25", "0.25", "3"]]


def test_the_page_answers_its_question_from_mean_costs():
    methods = {"no_transfer": 1600, "ptl": 800, "rmax_memory": 200}
    looks = {name: Look(name.upper(), "#000000") for name in methods}
    means = summary.Means(pd.concat([constant_lives(*pair) for pair in methods.items()]), HOW)
    text = page.lead(means, looks, ["rooms"])
    assert text.startswith("On the same maps PTL takes 0.5 times as many steps as learning every task from")
    assert (
        "Of 2 other methods, variants of it included, 1 cost less than PTL, 1 more, and 0 cannot be told from it."
        in text
    )
    assert text.endswith("“RMAX_MEMORY” takes 0.25 times PTL’s steps.")
    alone = summary.Means(pd.concat([constant_lives("ptl", 800), constant_lives("no_transfer", 1600)]), HOW)
    assert "needs no skills" not in page.lead(alone, looks, ["rooms"])
    assert page.lead(summary.Means(constant_lives("ptl", 800), HOW), looks, ["rooms"]) == ""


def test_lives_in_harder_worlds_have_the_optimum_of_their_world(tmp_path):
    study = SecondStudy.read(
        {**SMALL, "maps": 1, "article_maps": {"env2": ENV2}, "article_seeds": 1,
         "harder": {"slips": [0.2], "changes": ["cells"], "methods": ["ptl"], "maps": 1, "article_seeds": 1}}
    )  # fmt: skip
    jobs = {(job.family, job.slip, job.change): job for job in planned(study) if job.method == "ptl"}
    families = {*study.families, "env2"}
    worlds = ((0.0, NO_CHANGE), (0.2, NO_CHANGE), (0.0, "cells"))
    assert set(jobs) == {(family, *world) for family in families for world in worlds}
    assert len({job.place for job in jobs.values()}) == len(jobs)
    for slip, change in worlds:
        job = jobs["env2", slip, change]
        world = load_map(ENV2["map"]).with_slip(slip)
        path = tmp_path / f"{slip}_{change}.h5"
        store.write(path, job, job.run({"env2": world}), {"env2": world})
        arrays = store.read(path, job).arrays
        if slip:
            goals = [world.goal(letter) for letter in "AB"]
            expected = [optimal_steps(world, goal)[world.start] for goal in goals]
            np.testing.assert_allclose(arrays["optimum"][0], expected)
            assert (arrays["optimum"] > arrays["shortest"]).all()
        else:
            assert (arrays["optimum"] == arrays["shortest"]).all()
        assert (arrays["steps"] >= job.settings.learning.episodes * arrays["shortest"][:, None]).all()


# -- from the design to lives


def test_jobs_are_all_and_only_those_of_the_design():
    study = SecondStudy.read(
        {**SMALL, "maps": 5, "batch": 2, "sequences": {"names": ["random"], "methods": ["ptl"], "maps": 3},
         "library_sizes": {"methods": ["ptl"], "per_task": [1, 2], "maps": 1}, "article_maps": {"env2": ENV2}}
    )  # fmt: skip
    made = planned(study)
    assert len({job.place for job in made}) == len(made)
    maps = [(job.sequence, job.method, job.per_task, place) for job in made for place in job.places]
    assert len(set(maps)) == len(maps)
    counts = pd.Series([(sequence, per_task > 0) for sequence, _, per_task, _ in maps]).value_counts().to_dict()
    assert counts == {("increasing", False): 15, ("random", False): 3, ("increasing", True): 2,
                      ("article", False): 3, ("article", True): 2}  # fmt: skip
    assert all(job_from(job.text) == job for job in made)


def test_the_shipped_configurations_are_right(monkeypatch):
    monkeypatch.chdir(ROOT)
    study = read_study(FOLDER / "config/beyond.yaml")
    slow = yaml.safe_load((FOLDER / "config/beyond_slow.yaml").read_text())["methods"]
    assert set(names()) - {*study.methods, *slow} == {"ptl_frontier_path"}
    jobs = planned(study)
    places = {
        (job.family, job.sequence, job.method, job.per_task, job.slip, job.change, place)
        for job in jobs
        for place in job.places
    }
    generated, given = 30 * 15 + 4 * 8 * 5 + 5 * 4 * 5 + 4 * 11 * 3 + 13 * 3, 30 + 20 + 4 * 11 + 13
    assert len(places) == 6 * generated + 3 * given
    learned = pd.read_csv(ROOT / "reports/beyond/per_life.csv")["total_steps"].sum()
    cost = cost_of_lives(jobs, population_of(study), given_maps(study))
    assert learned < cost.steps < learned * 5
    assert 0.1 < cost.hours < 2  # README.md says a quarter of an hour on two cores
    half = cost_of_lives(jobs[::2], population_of(study), given_maps(study))
    assert half.hours < cost.hours and half.jobs == -(-cost.jobs // 2)


def test_files_are_described():
    page = (FOLDER / "README.md").read_text()
    assert "`library_size`" in page and page == filled(page), "run 'make docs'"


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
        ({"article_maps": {"moving_ai": ENV2}}, "moving_ai is the name of another family"),
        ({"moving_ai": ["maps/a b.map"]}, "moving_ai: 'maps/a b.map' is not allowed"),
        ({"moving_ai": ["a.map", "maps/a.map"]}, "two maps are called a"),
    ],
)
def test_what_cannot_be_run_is_refused(changes, message):
    with pytest.raises(UserError) as raised:
        SecondStudy.read({**SMALL, **changes})
    assert message in str(raised.value)


def test_lives_of_a_job_are_those_that_the_library_learns(tmp_path):
    (tmp_path / "arena.map").write_text(ARENA)
    study = SecondStudy.read({**SMALL, "article_maps": {"env2": ENV2}, "moving_ai": [str(tmp_path / "arena.map")]})
    tasks = per_task(lived(job, study, tmp_path) for job in planned(study))
    parameters = Parameters().replace(learning__episodes=5)
    entry = next(e for e in read_population() if (e.family, e.seed) == ("rooms", 4001))
    env2, arena = (given.world for given in given_maps(study).values())
    for world, letters, stream, size in (
        (entry.world(), "ABCDEF", ("rooms", 300, "increasing", 4001), 300),
        (env2, "AB", ("env2", 0, "article", "env2"), env2.n_states),
        (arena, "ABCDEF", ("moving_ai", 0, "increasing", "arena"), 18),
    ):
        life = learn_life(world, tasks_of(world, letters), "ptl", parameters, study.root_seed, *stream, 1)
        chosen = (tasks["family"] == stream[0]) & (tasks["map"] == str(stream[3])) & (tasks["method"] == "ptl")
        own = tasks[chosen & (tasks["seed"] == 1)]
        assert own["steps"].tolist() == [record.steps.sum() for record in life.records]
        assert own["first_episode"].tolist() == [record.steps[0] for record in life.records]
        assert own["library_size"].iloc[-1] == len(life.library)
        shortest = [world.shortest_path_length(world.start, world.goal(letter)) for letter in letters]
        assert own["optimum"].tolist() == [5 * length for length in shortest]
        assert set(own["size"]) == {size} and set(own["sequence"]) == {stream[2]}
    lives = per_life(tasks)
    assert len(lives) == 3 * (2 * 2 + 2 + 2)
    assert (lives["total_steps"] >= lives["optimum"]).all()
    for frame, name, read in ((tasks, "tasks.csv", read_tasks), (lives, "lives.csv", read_lives)):
        write_csv(frame, tmp_path / name)
        again = read(tmp_path / name)
        assert again.drop(columns="winding", errors="ignore").equals(
            frame.drop(columns="winding", errors="ignore").astype(again.dtypes.drop("winding", errors="ignore"))
        )
    write_csv(pd.concat([lives, lives.tail(1)]), tmp_path / "twice.csv")
    with pytest.raises(UserError, match="is there twice"):
        read_lives(tmp_path / "twice.csv")


def test_a_generated_map_is_the_one_that_was_planned():
    [job, *_] = planned(SecondStudy.read(SMALL))
    other = job_from(job.text.replace(job.maps["4001"], "0" * 16))
    with pytest.raises(UserError, match=r"map rooms_300_4001: has the digest .*, not 0+ as planned"):
        other.run({})


def test_the_server_has_imported_what_lives_import(tmp_path):
    [job, *_] = planned(SecondStudy.read(SMALL))
    assert imports_of_a_fork(tmp_path, job.text, "studies.beyond.jobs") == set()
    assert "studies.beyond.lives" in imports_of_a_fork(tmp_path, job.text)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"family": "sea"}, "no maps of the family 'sea'"),
        ({"sequence": "none"}, "with 'none' tasks"),
        ({"size": 0}, "--map: 4000 is missing"),
        ({"per_task": 2}, "per_task: 2 skills a task need a variant of ptl, not no_transfer"),
        ({"reference": "none"}, "unknown method 'none'"),
    ],
)
def test_a_job_that_cannot_be_done_is_refused_in_one_line(change: dict[str, Any], message):
    [job, *_] = planned(SecondStudy.read(SMALL))
    with pytest.raises(UserError, match=message):
        LivesOnMaps(**{**{name: getattr(job, name) for name in job.__struct_fields__}, **change}).run({})


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("steps", 1, "steps: a task took fewer steps than its shortest path"),
        ("first", 0, "first: a task took fewer steps"),
        ("first", 10**9, "first: a task took more steps than learning.max_steps"),
        ("truncated", 6, "truncated: has values"),
        ("shortest", 3, "its shortest paths or its number of states are not those of its map"),
    ],
)
def test_impossible_lives_are_not_written(name, value, message, tmp_path):
    study = SecondStudy.read({**SMALL, "families": [], "article_maps": {"env2": ENV2}})
    [job, *_] = planned(study)
    worlds = {"env2": given_maps(study)["env2", "env2"].world}
    arrays = job.run(worlds)
    arrays[name].flat[-1] = value
    with pytest.raises(UserError, match=message):
        store.write(tmp_path / "lives.h5", job, arrays, worlds)


@pytest.mark.parametrize("column", ["size", "seed", "total_steps", "optimum", "library_size"])
def test_lives_of_other_programs_have_numbers(tmp_path, column):
    path = tmp_path / "lives.csv"
    life = dict.fromkeys(LIFE_COLUMNS, "300") | {"family": "chain", "sequence": "increasing", "method": "theirs"}
    for value in ("many", "", "nan", "inf"):
        path.write_text(f"{','.join(life)}\n{','.join({**life, column: value}.values())}\n")
        with pytest.raises(UserError, match=rf"lives\.csv: .*{column}"):
            read_lives(path)
    path.write_text(f"{','.join(life)}\n{','.join({**life, column: '-1'}.values())}\n")
    with pytest.raises(UserError):
        read_lives(path)


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
        SecondStudy.read({**SMALL, "methods": ["ptl", str(tmp_path / "mine.py")]})
