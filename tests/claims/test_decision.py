"""Runs that decide: many lives in one process, exact first episodes, and how they enter verdicts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import oracles
import pytest
from made_up_run import GROUPS, MadeUpRun
from projects import MAPS

from ptl import claims
from ptl.claims.decision import decision_jobs, read_decision
from ptl.config import Configuration, Parameters
from ptl.errors import UserError
from ptl.learning.growth import grow_library
from ptl.learning.life import learn_life, tasks_of
from ptl.learning.lives import grow_lives, learn_lives
from ptl.measures.exact import first_episode_without_transfer
from ptl.world.gridworld import GridWorld, load_map
from studies.robustness.running import run_setting

ROOMS = GridWorld.from_text("#########\n#I..#..A#\n#.......#\n#...#..B#\n#########\n", "rooms")
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


def configuration(**changes: object) -> dict:
    environments = {name: {"map": str(MAPS / f"{name}.txt"), "tasks": "AB"} for name in ("env2", "env3")}
    environments["mine"] = environments["env2"]
    given = {"run": "x", "environments": environments, "methods": ["no_transfer", "ptl"],
             "learning": {"episodes": 12}, "growth": {"environment": "env3", "tasks": 8},
             "decision": {"seeds": 12, "full_transfer_seeds": 10, "no_transfer_seeds": 14, "growth_runs": 10},
             "measures": {"window": 10}}  # fmt: skip
    return Configuration.from_dict(given | changes).to_dict()


def test_only_what_claims_speak_of_is_decided() -> None:
    jobs = decision_jobs(configuration())
    assert set(jobs) == {"env2_no_transfer", "env2_ptl", "env3_no_transfer", "env3_ptl", "growth"}
    jobs = decision_jobs(configuration(methods=["no_transfer", "full_transfer", "ptl"]))
    seeds = [jobs[f"env2_{method}"]["seeds"] for method in ("no_transfer", "full_transfer", "ptl")]
    assert seeds == [14, 10, 12]
    assert not decision_jobs(configuration(environments={"mine": {"map": "x"}}, growth={"environment": "mine"}))


@pytest.fixture(scope="module")
def decided(tmp_path_factory: pytest.TempPathFactory) -> dict:
    folder = tmp_path_factory.mktemp("decision")
    jobs = decision_jobs(configuration(environments={"env2": configuration()["environments"]["env2"]},
                                       growth={"environment": "env2", "tasks": 8}))  # fmt: skip
    paths = {name: folder / f"{name}.h5" for name in jobs}
    for name, job in jobs.items():
        run_setting(job, paths[name])
    return paths


def test_decision_compares_first_episodes_with_their_expectation(decided: dict) -> None:
    evidence = read_decision(decided.values(), GROUPS)
    world = evidence.world("env2")
    expected = first_episode_without_transfer(world, world.goal("B"))
    first = evidence.values("env2", "B", "ptl", "first_episode")
    assert len(first) == 12
    np.testing.assert_allclose(evidence.values("env2", "B", "ptl", "jump_start"), expected - first)
    assert set(evidence.values("env2", "B", "no_transfer", "first_episode")) == {expected}
    assert evidence.needed("growth").shape == (10, 9)


def test_unfinished_decision_is_refused(tmp_path, decided: dict) -> None:
    job = decision_jobs(configuration())["env2_ptl"] | {"step_budget": 1}
    run_setting(job, tmp_path / "env2_ptl.h5")
    with pytest.raises(UserError, match=r"did not finish .*given up after 1 of 12"):
        read_decision([tmp_path / "env2_ptl.h5"], GROUPS)


def test_a_made_up_run_is_judged_alike_with_exact_first_episodes_of_its_own() -> None:
    """Only the first episode of the base is replaced, and only where ``exact`` says so."""
    evidence = MadeUpRun().evidence()
    before = {judged.claim.id: judged.verdict for judged in claims.judge(evidence)}
    after = {judged.claim.id: judged.verdict for judged in claims.judge(replace(evidence, exact=True))}
    untouched = [name for name in before if name not in ("E1-all", "E1-jump", "E2-all", "E3-jump")]
    assert {name: before[name] for name in untouched} == {name: after[name] for name in untouched}
