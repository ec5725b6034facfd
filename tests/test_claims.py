"""Claims: made-up runs in which each verdict comes out either way, the rule, places, and the ledger."""

from __future__ import annotations

import copy
import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner
from conftest import MAPS

from ptl import claims, measures
from ptl.archive import write_arrays
from ptl.claims import ledger, places, thresholds
from ptl.claims.verdict import Outcome, Part, Verdict, above, below, between, decide, not_significant, number
from ptl.commands.claims import command
from ptl.errors import UserError
from ptl.evidence import Evidence, Lacking, read_evidence
from ptl.gridworld import GridWorld, load_map
from ptl.statistics import Estimate, Resampling

IDS = [
    "E1-subgoals", "E1-order", "E1-all", "E1-jump", "E1-asymptotic", "E1-80", "E1-total", "E1-unknown",
    "E1-negative", "E2-size", "E2-all", "E2-converge", "E2-positive", "E2-subgoals", "E3-jump",
    "E3-threshold", "E3-ratio", "E3-few", "E3-subgoals", "curves", "reuse-spikes", "growth",
    "selection-cost", "space",
]  # fmt: skip
ENVIRONMENTS, TASKS = ("env1", "env2", "env3"), "ABCDEF"
BASE, FULL, REUSE = "no_transfer", "full_transfer", "policy_reuse"
PTL, SUPERVISED, UNKNOWN = VARIANTS = ("ptl", "ptl_supervised", "ptl_unknown_goal")
METHODS = (BASE, FULL, REUSE, *VARIANTS)
EPISODES, SEEDS = 200, 12
HOW = Resampling(0.95, 200)


class MadeUpRun:
    """A run as the article would have it: what it says of every curve, subgoal and library comes true.

    ``curves`` holds for each environment, method and task: steps of the first episode, steps of the episodes
    from the second to the last slow one, that one's number, steps at the end in shortest paths, and episodes
    that are spikes. ``peaks`` holds the peaks of both metrics, incremental and original, as cells.
    """

    def __init__(self):
        self.worlds = {name: load_map(MAPS / f"{name}.txt") for name in ENVIRONMENTS}
        self.curves = {}
        for level, task in enumerate(TASKS, start=1):
            env1 = {
                BASE: [5000 * level, 2000 * level, 150, 1.3, ()],
                FULL: [9000 * level, 4000 * level, 150, 2.0, ()],
                REUSE: [6000 * level, 2500 * level, 150, 1.4, (170, 180)],
                PTL: [750 * level, 100 * level, 70, 1.1, ()],
                SUPERVISED: [700 * level, 90 * level, 70, 1.1, ()],
                UNKNOWN: [900 * level, 200 * level, 70, 1.1, ()],
            }
            env2 = {
                BASE: [3000, 800, 60, 1.3, ()],
                FULL: [1000, 300, 60, 1.2, ()],
                REUSE: [3000, 900, 60, 1.4, (100, 150)],
                PTL: [300, 100, 15, 1.1, ()],
                SUPERVISED: [300, 90, 15, 1.1, ()],
                UNKNOWN: [3000, 110, 15, 1.1, ()],
            }
            env3 = {
                BASE: [2000, 500, 40, 1.2, ()],
                FULL: [2000, 100, 5, 1.2, ()],
                REUSE: [2000, 100, 5, 1.2, (90, 150)],
                PTL: [2000, 100, 5, 1.1, ()],
                SUPERVISED: [2000, 100, 5, 1.1, ()],
                UNKNOWN: [2000, 100, 5, 1.1, ()],
            }
            for name, methods in zip(ENVIRONMENTS, (env1, env2, env3), strict=True):
                for method, curve in methods.items():
                    self.curves[name, method, task] = curve
        doors = [(6, 11 * level) for level in range(1, 7)]
        self.peaks = {
            "env1": ([(row, column - 1) for row, column in doors], [(6, 3)] * 6),
            "env2": ([(4, 2), (7, 7), (4, 12), (7, 17), (3, 25), (9, 27)], [(5, 9)] * 6),
            "env3": ([(6, 10), (5, 5), (14, 5), (15, 15), (2, 14), (2, 18)], [(5, 9)] * 6),
        }
        tasks = np.arange(31)
        self.library_sizes = np.minimum(tasks, 7) * 0.7 + np.maximum(tasks - 7, 0) * 0.1
        skills = np.array([1, 5, 10, 50, 100, 200, 400, 600, 800, 1000])
        self.selection = pd.DataFrame({"skills": skills, "seconds": 2e-5 + 1e-7 * skills})
        self.library_bytes = pd.DataFrame({"states": 706, "skills": [1, 10], "bytes": [710, 7100]})

    def change(self, environment, methods, position, value, tasks=TASKS):
        for method in (methods,) if isinstance(methods, str) else methods:
            for task in tasks:
                curve = self.curves[environment, method, task]
                curve[position] = value(curve[position]) if callable(value) else value

    def swap(self, environment, one, others):
        """Give each of the others the curves of the one, and it those of the first of the others."""
        for task in TASKS:
            mine, theirs = (self.curves[environment, method, task] for method in (one, others[0]))
            for other in others:
                self.curves[environment, other, task] = list(mine)
            self.curves[environment, one, task] = theirs

    def evidence(self, seeds=SEEDS, methods=METHODS, environments=ENVIRONMENTS):
        steps = {key: self.steps(key, seeds) for key in self.curves if key[0] in environments and key[1] in methods}
        return Evidence(
            per_seed=pd.concat([self.measured(key, steps) for key in steps], ignore_index=True),
            worlds={name: self.worlds[name] for name in environments},
            steps=steps,
            subgoals=self.subgoals(seeds, environments) if PTL in methods else None,
            growth=self.growth(seeds),
            selection_cost=self.selection,
            library_bytes=self.library_bytes,
            how=HOW,
        )

    def steps(self, key, seeds):
        first, middle, until, end, spikes = self.curves[key]
        world = self.worlds[key[0]]
        shortest = world.shortest_path_length(world.start, world.goal(key[2]))
        curve = np.full((seeds, EPISODES), end * shortest)
        curve[:, :until] = middle
        curve[:, 0] = first
        curve[:, list(spikes)] *= 40
        random = np.random.default_rng([ord(letter) for letter in "".join(key)])
        return np.rint(curve * random.uniform(0.98, 1.02, size=(seeds, 1))).astype(np.int64)

    def measured(self, key, steps):
        environment, method, task = key
        world, own = self.worlds[environment], steps[key]
        base = steps.get((environment, BASE, task))
        shortest = world.shortest_path_length(world.start, world.goal(task))
        return pd.DataFrame(
            {
                "environment": environment, "task": task, "method": method, "seed": np.arange(len(own)),
                "first_episode": measures.first_episode(own),
                "asymptotic": measures.asymptotic(own, 10),
                "threshold_episode": measures.threshold_episode(own, shortest, 10, 1.5),
                "total_steps": measures.total_steps(own),
                "jump_start": np.nan if base is None else measures.jump_start(own, base),
                "transfer_ratio": np.nan if base is None else measures.transfer_ratio(own, base),
                "truncated": 0,
            }
        )  # fmt: skip

    def subgoals(self, seeds, environments):
        rows = []
        for environment in environments:
            world, (incremental, original) = self.worlds[environment], self.peaks[environment]
            for task, new, old in zip(TASKS, incremental, original, strict=True):
                state, other = world.state_at(*new), world.state_at(*old)
                for seed in range(seeds):
                    rows.append((environment, PTL, seed, task, state, *new, 9.0, 0.8, "added", state, other))
        return pd.DataFrame(rows, columns=list(measures.SUBGOAL_COLUMNS))

    def growth(self, runs):
        tasks = np.arange(len(self.library_sizes))
        frames = [
            pd.DataFrame({"run": run, "tasks": tasks, "library_size": self.library_sizes * (1 + 0.01 * (run % 3))})
            for run in range(runs)
        ]
        return pd.concat(frames, ignore_index=True)


def concerned(id):
    """Environments that a claim needs."""
    single = {"E1": ("env1",), "E2": ("env2",), "E3": ("env3",)}
    return ENVIRONMENTS if id == "E2-size" else single.get(id[:2], ENVIRONMENTS)


def judgement(evidence, id):
    return claims.CLAIMS[IDS.index(id)].judge(evidence)


# -- made-up runs that say the contrary ----------------------------------------------------------------------


def subgoals_in_room_1(run):
    incremental, _ = run.peaks["env1"]
    run.peaks["env1"] = ([(3, 4)] * 6, incremental)


def harder_is_easier(run):
    for position, value in ((1, 1000), (3, 1.3)):
        run.change("env1", BASE, position, value)
    for level, task in enumerate(TASKS):
        run.curves["env1", BASE, task][1] -= 150 * level
        run.curves["env1", BASE, task][3] *= 8.0 / 2**level


def ptl_worse_in_env1(run):
    run.swap("env1", BASE, VARIANTS)


def ptl_worse_in_env2_but_unknown_goal_starts_better(run):
    run.swap("env2", BASE, VARIANTS)
    run.change("env2", UNKNOWN, 0, 10)


def converged_slowly_or_not(run):
    run.change("env2", (BASE, FULL, PTL), 2, 200)


def two_env1(run):
    run.worlds = {"env1": run.worlds["env2"], "env2": run.worlds["env1"], "env3": run.worlds["env3"]}
    run.peaks["env1"], run.peaks["env2"] = run.peaks["env2"], run.peaks["env1"]


def subgoals_in_the_corridor(run):
    run.peaks["env2"] = ([(6, 1)] * 6, run.peaks["env2"][1])


def subgoals_at_the_start(run):
    run.peaks["env3"] = ([(9, 14)] * 6, run.peaks["env3"][1])


def all_slow_but_no_transfer(run):
    run.change("env3", (FULL, REUSE, *VARIANTS), 2, 150)
    run.change("env3", BASE, 2, 3)


def calm_reuse(run):
    for environment in ENVIRONMENTS:
        run.change(environment, REUSE, 4, ())
        run.change(environment, BASE, 4, (170, 180))


def stagnant_then_growing(run):
    run.library_sizes = np.interp(np.arange(31), [0, 3, 7, 30], [0, 3, 3, 26])


def quadratic_selection(run):
    run.selection["seconds"] = 1e-9 * run.selection["skills"] ** 2 + 1e-6


def overfull_library(run):
    run.library_bytes["bytes"] *= 2
    whole = [tuple(cell) for cell in run.worlds["env2"].cells]
    plain = run.subgoals

    def subgoals(seeds, environments):
        frame = plain(seeds, environments)
        more = pd.concat([frame[:1].assign(environment="env2", subgoal=i) for i in [*range(len(whole)), 0]])
        return pd.concat([frame, more], ignore_index=True)

    run.subgoals = subgoals


CONTRARY = {
    "E1-subgoals": subgoals_in_room_1,
    "E1-order": harder_is_easier,
    "E1-all": ptl_worse_in_env1,
    "E1-jump": lambda run: run.change("env1", PTL, 0, lambda steps: 20 * steps),
    "E1-asymptotic": lambda run: run.change("env1", VARIANTS, 3, 3.0),
    "E1-80": lambda run: run.change("env1", PTL, 3, 1.9),
    "E1-total": lambda run: run.change("env1", PTL, 1, 10**6),
    "E1-unknown": lambda run: (run.change("env1", UNKNOWN, 1, 10**6), run.change("env1", PTL, 1, 10**7)),
    "E1-negative": lambda run: run.change("env1", FULL, 1, 200),
    "E2-size": two_env1,
    "E2-all": ptl_worse_in_env2_but_unknown_goal_starts_better,
    "E2-converge": converged_slowly_or_not,
    "E2-positive": lambda run: run.change("env2", FULL, 1, 5000),
    "E2-subgoals": subgoals_in_the_corridor,
    "E3-jump": lambda run: run.change("env3", PTL, 0, 200),
    "E3-threshold": lambda run: run.change("env3", PTL, 2, 100),
    "E3-ratio": lambda run: run.change("env3", PTL, 1, 10**5),
    "E3-few": all_slow_but_no_transfer,
    "E3-subgoals": subgoals_at_the_start,
    "curves": lambda run: [run.change(env, PTL, p, 10**6) for env in ENVIRONMENTS for p in (0, 1, 3)],
    "reuse-spikes": calm_reuse,
    "growth": stagnant_then_growing,
    "selection-cost": quadratic_selection,
    "space": overfull_library,
}


@pytest.fixture(scope="module")
def as_in_the_article():
    return MadeUpRun().evidence()


@pytest.fixture(scope="module")
def nine_seeds():
    return MadeUpRun().evidence(seeds=9)


@pytest.fixture(scope="module")
def verdicts(as_in_the_article):
    return dict(zip(IDS, claims.judge(as_in_the_article), strict=True))


def test_ids_are_those_of_the_specification_in_order():
    assert [claim.id for claim in claims.CLAIMS] == IDS


@pytest.mark.parametrize("id", IDS)
def test_reproduced_where_the_run_is_as_in_the_article(verdicts, id):
    assert verdicts[id].verdict is Verdict.REPRODUCED, list(map(str, verdicts[id].parts))


@pytest.mark.parametrize("id", IDS)
def test_not_reproduced_where_the_run_says_the_contrary(id):
    run = MadeUpRun()
    CONTRARY[id](run)
    judged = judgement(run.evidence(environments=concerned(id)), id)
    assert judged.verdict is Verdict.NOT, (list(map(str, judged.parts)), judged.reason)


@pytest.mark.parametrize(
    ("id", "change"),
    [
        ("E1-total", lambda run: run.change("env1", PTL, 1, lambda steps: 8 * steps)),
        ("E1-jump", lambda run: run.change("env1", PTL, 0, lambda steps: 3 * steps)),
        ("E1-80", lambda run: run.change("env1", PTL, 2, 30)),
        ("E1-all", lambda run: run.change("env1", UNKNOWN, 0, 10**6, tasks="C")),
        ("E2-all", lambda run: run.change("env2", UNKNOWN, 0, 10, tasks="D")),
        ("E2-converge", lambda run: run.change("env2", FULL, 2, 20)),
        ("E3-threshold", lambda run: run.change("env3", PTL, 2, 25)),
        ("E3-ratio", lambda run: run.change("env3", PTL, 1, 4000)),
        ("E3-few", lambda run: run.change("env3", REUSE, 2, 50)),
        ("curves", lambda run: run.change("env2", PTL, 3, 1.25)),
    ],
)
def test_partly_reproduced_where_only_some_of_it_is_so(id, change):
    run = MadeUpRun()
    change(run)
    judged = judgement(run.evidence(environments=concerned(id)), id)
    assert judged.verdict is Verdict.PARTLY, (list(map(str, judged.parts)), judged.reason)
    assert {part.outcome for part in judged.parts} > {Outcome.HOLDS}


def test_not_improved_needs_more_than_lack_of_significance(as_in_the_article):
    noisy = as_in_the_article.per_seed.copy()
    rows = (noisy["environment"] == "env3") & (noisy["method"] == PTL)
    noisy.loc[rows, "first_episode"] = noisy.loc[rows, "seed"] % 4 * 1000
    noisy.loc[rows, "jump_start"] = 2000 - noisy.loc[rows, "first_episode"]
    judged = judgement(replace(as_in_the_article, per_seed=noisy), "E3-jump")
    assert [part.outcome for part in judged.parts] == [Outcome.HOLDS, Outcome.OPEN]
    assert judged.verdict is Verdict.PARTLY


# -- what is not in the run ----------------------------------------------------------------------------------

COUNTED = {"E2-size", "selection-cost", "space"}
"""Claims that rest on no runs."""


@pytest.mark.parametrize("id", IDS)
def test_too_few_seeds_decide_nothing(nine_seeds, id):
    judged = judgement(nine_seeds, id)
    if id in COUNTED:
        assert judged.verdict is Verdict.REPRODUCED
    else:
        assert judged.verdict is Verdict.UNDECIDED
        assert "9" in judged.reason
        assert "fewer than the 10" in judged.reason


@pytest.mark.parametrize("environment", ENVIRONMENTS)
def test_claims_on_an_environment_that_is_missing_are_undecided(environment):
    others = tuple(name for name in ENVIRONMENTS if name != environment)
    evidence = MadeUpRun().evidence(environments=others)
    for id in IDS:
        if id.startswith(f"E{environment[-1]}"):
            judged = judgement(evidence, id)
            assert judged.verdict is Verdict.UNDECIDED
            assert judged.reason == f"environment {environment} is not in this run"


def test_files_that_are_missing_make_undecided(as_in_the_article):
    bare = Evidence(as_in_the_article.per_seed, as_in_the_article.worlds, how=HOW)
    reasons = {judged.claim.id: judged.reason for judged in claims.judge(bare)}
    assert reasons["growth"] == "growth is not in this run"
    assert reasons["selection-cost"] == "selection cost is not in this run"
    assert reasons["E1-subgoals"] == "subgoals are not in this run"
    assert reasons["curves"].startswith("env1: steps per episode of ptl, task F")
    assert reasons["E1-all"] == ""


def test_too_short_lives_do_not_show_the_growth(as_in_the_article):
    growth = as_in_the_article.growth
    judged = judgement(replace(as_in_the_article, growth=growth[growth["tasks"] < 10]), "growth")
    assert judged.verdict is Verdict.UNDECIDED
    assert "9 tasks" in judged.reason


@pytest.mark.parametrize(
    ("method", "concerned"),
    [
        (
            FULL,
            {"E1-asymptotic", "E1-unknown", "E1-negative", "E2-converge", "E2-positive", "E3-few", "curves"},
        ),
        (REUSE, {"E1-unknown", "E3-few", "curves", "reuse-spikes"}),
        (SUPERVISED, {"E1-all", "E1-asymptotic", "E2-all", "E3-few"}),
        (UNKNOWN, {"E1-all", "E1-asymptotic", "E1-unknown", "E2-all", "E3-few"}),
    ],
)
def test_a_method_counts_only_in_claims_about_it(verdicts, method, concerned):
    left = tuple(name for name in METHODS if name != method)
    for judged in claims.judge(MadeUpRun().evidence(methods=left)):
        before = verdicts[judged.claim.id]
        if judged.claim.id in concerned:
            assert judged.verdict is Verdict.UNDECIDED
            assert f"method {method} is not in this run" in judged.reason
        else:
            assert (judged.verdict, judged.parts) == (before.verdict, before.parts)


def test_a_foreign_method_moves_nothing(as_in_the_article, verdicts):
    foreign = as_in_the_article.per_seed.query("method == 'ptl'").assign(method="another", total_steps=1)
    more = pd.concat([foreign, as_in_the_article.per_seed], ignore_index=True)
    for judged in claims.judge(replace(as_in_the_article, per_seed=more)):
        assert judged == verdicts[judged.claim.id]


def test_a_claim_needs_its_base():
    evidence = MadeUpRun().evidence(methods=(FULL, *VARIANTS))
    judged = judgement(evidence, "E1-negative")
    assert judged.verdict is Verdict.UNDECIDED
    assert "no_transfer" in judged.reason


def test_methods_are_paired_by_seed(as_in_the_article, verdicts):
    shuffled = as_in_the_article.per_seed.sample(frac=1, random_state=1)
    for id in ("E1-order", "E1-total", "E1-unknown", "E2-converge", "E3-ratio"):
        assert judgement(replace(as_in_the_article, per_seed=shuffled), id) == verdicts[id]


# -- the rule ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("low", "high", "expected"),
    [(1, 2, Outcome.HOLDS), (-2, -1, Outcome.FAILS), (-1, 1, Outcome.OPEN), (0, 1, Outcome.OPEN),
     (-1, 0, Outcome.FAILS), (0, 0, Outcome.FAILS), (np.nan, np.nan, Outcome.OPEN)],
)  # fmt: skip
def test_a_part_is_judged_by_its_whole_interval(low, high, expected):
    estimate = Estimate((low + high) / 2, low, high)
    mirrored = Estimate(-estimate.value, -high, -low)
    assert above("x", estimate, 0).outcome is expected
    assert below("x", mirrored, 0).outcome is expected
    assert between("x", estimate, 0, 5).outcome is expected


def test_a_part_that_denies_significance_fails_only_beyond_doubt():
    assert not_significant("x", Estimate(1, -1, 3)).outcome is Outcome.HOLDS
    assert not_significant("x", Estimate(-2, -3, -1)).outcome is Outcome.HOLDS
    assert not_significant("x", Estimate(2, 1, 3)).outcome is Outcome.FAILS
    assert not_significant("x", Estimate(2, np.nan, np.nan)).outcome is Outcome.OPEN


@pytest.mark.parametrize(
    ("outcomes", "verdict"),
    [("hh", Verdict.REPRODUCED), ("hf", Verdict.PARTLY), ("ho", Verdict.PARTLY), ("hfo", Verdict.PARTLY),
     ("ff", Verdict.NOT), ("fo", Verdict.NOT), ("oo", Verdict.UNDECIDED), ("", Verdict.UNDECIDED)],
)  # fmt: skip
def test_the_rule_from_parts_to_a_verdict(outcomes, verdict):
    kinds = {"h": Outcome.HOLDS, "f": Outcome.FAILS, "o": Outcome.OPEN}
    parts = [Part("x", Estimate(0, 0, 0), "", kinds[letter]) for letter in outcomes]
    assert decide(parts) is verdict


@pytest.mark.parametrize(
    ("value", "text"),
    [(0, "0"), (0.88123, "0.8812"), (-39.04, "−39.04"), (2632123.0, "2,632,000"), (1.0, "1"),
     (99999, "100,000"), (np.nan, "–"), (np.inf, "∞")],
)  # fmt: skip
def test_numbers_have_four_digits(value, text):
    assert number(value) == text


# -- places --------------------------------------------------------------------------------------------------


def cells(world, states):
    return sorted(map(tuple, world.cells[np.asarray(states)].tolist()))


def test_doorways_of_the_maps(env1, env2):
    assert cells(env1, places.doorways(env1)) == [(6, 11 * level) for level in range(1, 7)]
    small = [(row, column) for row in (4, 7) for column in (2, 7, 12, 17)]
    assert cells(env2, places.doorways(env2)) == sorted([*small, (5, 20)])


def test_newest_doorway_is_the_last_on_the_way(env1):
    for level, task in enumerate(TASKS, start=1):
        newest = places.newest_doorway(env1, env1.goal(task))
        assert env1.cells[newest].tolist() == [6, 11 * level]


def test_rooms_and_their_doors(env2):
    room = places.rooms(env2)
    assert room.max() == 9
    assert np.count_nonzero(room == -1) == 9
    assert sorted(np.bincount(room[room >= 0]).tolist()) == [12] * 8 + [38, 100]
    for task, door in zip("ABCDE", [(4, 2), (7, 7), (4, 12), (7, 17), (5, 20)], strict=True):
        assert cells(env2, places.doors_of(env2, room[env2.goal(task)])) == [door]


def test_one_step_from_a_doorway_counts_as_on_it(env1):
    near = np.flatnonzero(places.near(env1, places.doorways(env1), thresholds.AT))
    assert cells(env1, near) == [(6, 11 * level + step) for level in range(1, 7) for step in (-1, 0, 1)]


def test_places_of_another_map_are_refused(env1):
    with pytest.raises(Lacking, match="21 by 24"):
        places.rectangle(env1, (1, 2), (1, 2), (21, 24))
    with pytest.raises(Lacking, match="no doorway"):
        places.doorways(GridWorld.from_text("I.A\n...\n"))


def test_the_regions_of_env3_are_what_they_are_called(env3):
    corridor, room, inner = (
        places.rectangle(env3, *where, claims.env3.MAP_SHAPE)
        for where in (claims.env3.LOWER_CORRIDOR, claims.env3.ROOM, claims.env3.INNER_HALF)
    )
    assert corridor.sum() == 44
    assert all(room[env3.goal(letter)] for letter in "AEF")
    assert [bool(inner[env3.goal(letter)]) for letter in "AEF"] == [False, True, True]
    doors = np.flatnonzero(~room & room[env3.successors].any(axis=1))
    assert cells(env3, doors) == [(4, 13)]


# -- the ledger ----------------------------------------------------------------------------------------------

RUN = ledger.Run(12, 0.95, 200)


def test_frame_has_a_row_for_each_claim(verdicts):
    frame = ledger.to_frame(list(verdicts.values()))
    assert tuple(frame.columns) == ledger.COLUMNS
    assert frame["id"].tolist() == IDS
    assert (frame["evidence"] != "").all()
    parts = ledger.to_parts_frame(list(verdicts.values()))
    assert parts.groupby("id").size().to_dict() == frame.set_index("id")["parts"].to_dict()


def test_evidence_names_the_parts_that_miss():
    run = MadeUpRun()
    run.change("env1", UNKNOWN, 0, 10**6, tasks="C")
    text = ledger.evidence_text(judgement(run.evidence(), "E1-all"))
    assert re.match(r"7\d of 75 parts hold, \d+ fail, \d+ open", text)
    assert "task C, ptl_unknown_goal, jump start: −98" in text
    assert "task D" not in text


def test_markdown_starts_with_counts_for_programs(verdicts):
    lines = ledger.to_markdown(list(verdicts.values()), RUN).splitlines()
    expected = "<!-- claims: 24; reproduced: 24; partly reproduced: 0; not reproduced: 0; undecided: 0 -->"
    assert lines[0] == expected
    rows = [line for line in lines if line.startswith("| **")]
    assert len(rows) == 24
    assert {len(re.findall(r"(?<!\\)\|", row)) for row in rows} == {6}


class WellFormed(HTMLParser):
    """Refuses tags that are closed in another order than they were opened in."""

    def __init__(self, page):
        super().__init__()
        self.open, self.words, self.rows = [], [], []
        self.feed(page)
        assert not self.open

    def handle_starttag(self, tag, attributes):
        if tag not in ("meta", "br"):
            self.open.append(tag)
        if tag == "tr":
            self.rows.append(dict(attributes).get("id"))

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.words.append(data)


def test_page_is_well_formed_and_says_verdicts_in_words(verdicts):
    judged = list(verdicts.values())
    judged[0] = replace(judged[0], verdict=Verdict.NOT, notes=("<b> & co",))
    page = WellFormed(ledger.to_html(judged, RUN))
    assert page.rows == [None, *IDS]
    assert "not reproduced" in page.words
    assert "<b> & co" in page.words
    assert "src=" not in ledger.to_html(judged, RUN)


# -- from files ----------------------------------------------------------------------------------------------


@pytest.fixture
def files(tmp_path, as_in_the_article):
    evidence = as_in_the_article
    paths = {name: tmp_path / f"{name}.csv" for name in ("per_seed", "subgoals", "growth", "selection", "bytes")}
    frames = (
        evidence.per_seed, evidence.subgoals, evidence.growth, evidence.selection_cost, evidence.library_bytes
    )  # fmt: skip
    for path, frame in zip(paths.values(), frames, strict=True):
        frame.to_csv(path, index=False)
    paths["steps"] = tmp_path / "steps.h5"
    write_arrays(paths["steps"], "ptl-steps/1", {"/".join(names): steps for names, steps in evidence.steps.items()}, {})
    return paths


def run_command(files, tmp_path):
    out = {kind: tmp_path / f"claims.{kind}" for kind in ("csv", "md", "html")}
    out["parts"] = tmp_path / "parts.csv"
    maps = [word for name in ENVIRONMENTS for word in ("--map", f"{name}={MAPS / name}.txt")]
    outputs = [word for kind, path in out.items() for word in (f"--output-{kind}", str(path))]
    arguments = [
        files["per_seed"], *maps, "--steps", files["steps"], "--subgoals", files["subgoals"],
        "--growth", files["growth"], "--selection-cost", files["selection"],
        "--library-bytes", files["bytes"], "--confidence", "0.95", "--resamples", "200", *outputs,
    ]  # fmt: skip
    result = CliRunner().invoke(command, list(map(str, arguments)), catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return {kind: path.read_text(encoding="utf-8") for kind, path in out.items()}, pd.read_csv(out["csv"])


def test_command_judges_a_run_from_its_files(files, tmp_path):
    texts, frame = run_command(files, tmp_path)
    assert frame["id"].tolist() == IDS
    assert set(frame["verdict"]) == {"reproduced"}
    assert "24 reproduced" in texts["md"]
    assert len(texts["parts"].splitlines()) == 1 + frame["parts"].sum()


def test_editing_the_data_flips_the_verdict(files, tmp_path):
    table = pd.read_csv(files["per_seed"])
    rows = table.query("environment == 'env1' and task == 'F' and method == 'full_transfer'").index
    table.loc[rows, "transfer_ratio"] *= -1
    table.to_csv(files["per_seed"], index=False)
    _, frame = run_command(files, tmp_path)
    assert frame.loc[frame["verdict"] != "reproduced", ["id", "verdict"]].to_numpy().tolist() == [
        ["E1-negative", "not reproduced"]
    ]


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda files: files["subgoals"].write_text("environment\n1\n"), "no column 'method'"),
        (lambda files: files["growth"].unlink(), "cannot be read as CSV"),
        (lambda files: files["steps"].write_text("no"), "damaged or not an HDF5 file"),
        (lambda files: files["per_seed"].write_text("environment,seed\nenv1,1\n"), "no column"),
    ],
)
def test_damaged_files_are_named(files, spoil, message):
    spoil(files)
    maps = {name: MAPS / f"{name}.txt" for name in ENVIRONMENTS}
    with pytest.raises(UserError, match=message):
        read_evidence(files["per_seed"], maps, files["steps"], files["subgoals"], files["growth"])


def test_made_up_runs_do_not_share_state():
    run = MadeUpRun()
    before = copy.deepcopy(run.curves)
    other = MadeUpRun()
    other.change("env1", PTL, 0, 1)
    assert run.curves == before
