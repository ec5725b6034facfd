"""Runs that decide: many lives in one process, exact first episodes, and how they enter verdicts."""

from __future__ import annotations

from dataclasses import replace

import msgspec
import numpy as np
import oracles
import pytest
from made_up_run import GROUPS, MadeUpRun
from projects import MAPS

from ptl import claims
from ptl.claims.comparisons import own_and_base
from ptl.claims.decision import confidence_at, decision_jobs, evidence_of, goes_on, open_pairs
from ptl.claims.verdict import Outcome
from ptl.config import Configuration, Parameters
from ptl.errors import UserError
from ptl.files import store
from ptl.learning.growth import grow_library
from ptl.learning.life import learn_life, tasks_of
from ptl.learning.lives import grow_lives, learn_lives
from ptl.measures import statistics
from ptl.measures.exact import first_episode_without_transfer
from ptl.measures.statistics import Resampling
from ptl.world.gridworld import GridWorld, map_digest
from ptl.world.map_files import load_map

ROOMS = GridWorld.from_text("#########\n#I..#..A#\n#.......#\n#...#..B#\n#########\n", "rooms")
WORLDS = {"env2": load_map(MAPS / "env2.txt")}
DIGEST = map_digest(WORLDS["env2"].text)
BRIEF = Parameters().replace(learning__episodes=12, subgoals__trajectories=5)


@pytest.mark.parametrize("name", ["env1", "env2", "env3"])
def test_expected_first_episode_solves_the_linear_system(name: str) -> None:
    world = load_map(MAPS / f"{name}.txt")
    for goal in world.goals.values():
        expected, _ = oracles.hitting_time(world.successors, world.start, goal)
        assert first_episode_without_transfer(world, goal) == pytest.approx(expected)


def test_many_lives_are_single_lives_side_by_side() -> None:
    arrays = learn_lives(ROOMS, "AB", "ptl", BRIEF, 7, [3, 5], "rooms")
    for row, seed in enumerate((3, 5)):
        life = learn_life(ROOMS, tasks_of(ROOMS, "AB"), "ptl", BRIEF, 7, "rooms", seed)
        np.testing.assert_array_equal(arrays["steps"][row], [record.steps for record in life.records])
        np.testing.assert_array_equal(arrays["subgoal"][row], [record.update.subgoal for record in life.records])
    assert arrays["seeds"].tolist() == [3, 5]
    assert "subgoal" not in learn_lives(ROOMS, "AB", "no_transfer", BRIEF, 7, [0], "rooms")


def test_no_life_is_begun_beyond_the_budget() -> None:
    arrays = learn_lives(ROOMS, "AB", "no_transfer", BRIEF, 7, range(9), "rooms", budget=1)
    assert arrays["seeds"].tolist() == [0]


def test_growing_lives_are_those_of_the_growth_experiment() -> None:
    sizes = grow_lives(ROOMS, "rooms", 6, BRIEF, 7, range(2))
    for run in range(2):
        records = grow_library(ROOMS, 6, BRIEF, 7, "rooms", run).records
        assert np.diff(sizes[run]).tolist() == [record.update.subgoal >= 0 for record in records]


def jobs_of(environments: tuple[str, ...] = ("env2", "env3", "mine"), **changes: object) -> dict:
    entry = {"map": str(MAPS / "env2.txt"), "tasks": "AB"}
    given = {
        "run": "x", "environments": dict.fromkeys(environments, entry), "methods": ["no_transfer", "ptl"],
        "learning": {"episodes": 12}, "growth": {"environment": environments[-1], "tasks": 8},
        "decision": {"looks": [10, 14]},
    }  # fmt: skip
    return decision_jobs(Configuration.from_dict(given | changes), dict.fromkeys(environments, DIGEST))


def test_only_what_claims_speak_of_is_decided() -> None:
    pairs = [(name, method) for name in ("env2", "env3") for method in ("no_transfer", "ptl")]
    lives = {f"decision/{name}_{method}_{look}.h5" for name, method in pairs for look in (1, 2)}
    assert {*jobs_of()} == lives, "neither lives nor libraries on a map that no claim speaks of"
    assert not jobs_of(("mine",))
    jobs = jobs_of(("env2",), methods=["no_transfer", "full_transfer", "ptl", "methods/mine.py"])
    assert {job.pair for job in jobs.values()} == {
        ("env2", method) for method in ("no_transfer", "full_transfer", "ptl", "growth")
    }
    first, second = jobs["decision/env2_ptl_1.h5"], jobs["decision/env2_ptl_2.h5"]
    assert (first.first, first.seeds, second.first, second.seeds) == (0, 10, 10, 4)
    assert jobs["decision/growth_2.h5"].runs == 4


@pytest.fixture(scope="module")
def decided(tmp_path_factory: pytest.TempPathFactory) -> list[store.Result]:
    folder = tmp_path_factory.mktemp("decision")
    jobs = jobs_of(("env2",))
    for place, job in jobs.items():
        store.write(folder / place, job, job.run(WORLDS), WORLDS)
    return [store.read(folder / place, job) for place, job in jobs.items()]


def test_decision_compares_first_episodes_with_their_expectation(decided: list[store.Result]) -> None:
    evidence = evidence_of(decided, GROUPS, 0.95)
    world = evidence.world("env2")
    expected = first_episode_without_transfer(world, world.goal("B"))
    first = evidence.values("env2", "B", "ptl", "first_episode")
    assert len(first) == 14
    np.testing.assert_allclose(evidence.values("env2", "B", "ptl", "jump_start"), expected - first)
    assert not evidence.values("env2", "B", "no_transfer", "jump_start").any()
    assert set(own_and_base(evidence, "env2", "B", "ptl", "first_episode")[1].round(6)) == {round(expected, 6)}
    assert evidence.needed("growth").shape == (14, 9)
    assert evidence.needed("subgoals").groupby("method").size().to_dict() == {"ptl": 2 * 14}


def test_a_later_look_adds_the_lives_that_follow(decided: list[store.Result]) -> None:
    lives = [result for result in decided if result.job.pair == ("env2", "ptl")]
    steps = np.concatenate([result.arrays["steps"] for result in lives])
    job = lives[0].job
    names = ("robustness", "env2_ptl", "env2")
    at_once = learn_lives(WORLDS["env2"], "AB", "ptl", job.settings, job.root_seed, range(14), *names)
    np.testing.assert_array_equal(steps, at_once["steps"])
    assert [result.arrays["seeds"][0] for result in lives] == [0, 10]


# -- looks ---------------------------------------------------------------------------------------------------------


def test_the_errors_of_all_looks_add_up() -> None:
    looks = (100, 200, 400, 800)
    errors = [1 - confidence_at(look, looks, 0.95) for look in range(1, 5)]
    assert sum(errors) == pytest.approx(0.05)
    assert errors == sorted(errors)


def test_only_what_an_open_part_speaks_of_goes_on() -> None:
    run = MadeUpRun()
    evidence = run.evidence()
    judged = {judgement.claim.id: judgement for judgement in claims.judge(evidence)}
    assert {part.outcome for part in judged["E3-ratio"].parts} == {Outcome.HOLDS}
    assert open_pairs(judged.values()) == set()
    parts = tuple(replace(part, outcome=Outcome.OPEN) for part in judged["E3-ratio"].parts)
    pairs = open_pairs([replace(judged["E3-ratio"], parts=parts)])
    assert pairs == {("env3", "ptl"), ("env3", "no_transfer")}
    growing = tuple(replace(part, outcome=Outcome.OPEN) for part in judged["growth"].parts)
    assert open_pairs([replace(judged["growth"], parts=growing)]) == {("", "growth")}
    jobs = jobs_of(("env2", "env3"), methods=["no_transfer", "full_transfer", "ptl"])
    assert {place for place, job in jobs.items() if goes_on(job, pairs | {("", "growth")})} == {
        f"decision/{name}_{look}.h5" for name in ("env3_ptl", "env3_no_transfer", "growth") for look in (1, 2)
    }


def test_a_part_uses_the_runs_that_it_was_made_from() -> None:
    [converge] = [claim for claim in claims.CLAIMS if claim.id == "E2-converge"]
    uses = {part.text: part.uses for part in converge.judge(MadeUpRun().evidence()).parts}
    base, full = (("env2", name) for name in ("no_transfer", "full_transfer"))
    assert uses["task F, no_transfer, share of runs that reach the threshold"] == {base}
    assert full not in uses["task F, episodes of no_transfer over those of ptl"]
    assert {full, ("env2", "ptl")} <= uses["task F, episodes of full_transfer over those of ptl"]


def test_parts_in_a_row_use_the_curves_that_they_share() -> None:
    [curves] = [claim for claim in claims.CLAIMS if claim.id == "curves"]
    parts = curves.judge(MadeUpRun().evidence()).parts
    for part in parts:
        environment = part.text.partition(",")[0]
        other = part.text.removesuffix(" minus ptl").rpartition(", ")[2]
        assert {(environment, "ptl"), (environment, other)} <= part.uses


def test_looking_often_errs_no_more_often_than_stated() -> None:
    """A bound that is true is rejected at some look in at most 5% of the sequences."""
    looks = (20, 40, 80, 160)
    random = np.random.default_rng(7)
    wrong = 0
    for _ in range(1000):
        values = random.normal(0, 1, looks[-1])
        for look, runs in enumerate(looks, start=1):
            how = Resampling(confidence_at(look, looks, 0.95), 0, normal=True)
            estimate = statistics.mean(values[:runs], how, random)
            if estimate.low > 0 or estimate.high < 0:
                wrong += 1
                break
    assert wrong / 1000 < 0.05 + 3 * np.sqrt(0.05 * 0.95 / 1000)
    assert wrong > 0


def spoil_steps(arrays: dict[str, np.ndarray]) -> None:
    arrays["steps"][3, 1, 2] = 1


def spoil_truncated(arrays: dict[str, np.ndarray]) -> None:
    arrays["truncated"][0, 0] = 1


def spoil_seeds(arrays: dict[str, np.ndarray]) -> None:
    arrays["seeds"][[0, 1]] = 1, 0


def spoil_sizes(arrays: dict[str, np.ndarray]) -> None:
    arrays["library_size"][2, 1:] += 2


def leave_lives_out(arrays: dict[str, np.ndarray]) -> None:
    arrays["steps"] = arrays["steps"][:5]


@pytest.mark.parametrize(
    ("name", "spoil", "says"),
    [
        ("env2_ptl", spoil_steps, "task B: an episode is shorter than the shortest path"),
        ("env2_ptl", spoil_truncated, "more episodes are truncated than have learning.max_steps"),
        ("env2_no_transfer", spoil_seeds, "its seeds are not 0, 1, 2"),
        ("env2_no_transfer", leave_lives_out, r"steps: has the shape \(5, 2, 12\) where \(10, 2, 12\) is needed"),
        ("growth", spoil_sizes, "a library does not grow from 0 by at most one skill a task"),
    ],
)
def test_what_no_lives_can_contain_is_refused(tmp_path, decided: list[store.Result], name, spoil, says) -> None:
    [result] = [result for result in decided if result.job.place == f"decision/{name}_1.h5"]
    arrays = {name: values.copy() for name, values in result.arrays.items()}
    store.write(tmp_path / "same.h5", result.job, arrays, WORLDS)
    spoil(arrays)
    with pytest.raises(UserError, match=says):
        store.write(tmp_path / "spoilt.h5", result.job, arrays, WORLDS)


def test_lives_that_decide_are_others_than_those_of_the_tables(decided: list[store.Result]) -> None:
    job = jobs_of(("env2",))["decision/env2_no_transfer_1.h5"]
    tables = learn_lives(WORLDS["env2"], "AB", "no_transfer", job.settings, job.root_seed, range(3), "env2")
    assert not np.array_equal(tables["steps"], decided[0].arrays["steps"][:3])
    fewer = msgspec.structs.replace(job, seeds=3).run(WORLDS)
    np.testing.assert_array_equal(fewer["steps"], decided[0].arrays["steps"][:3])
