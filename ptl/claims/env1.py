"""The article's claims on environment 1, seven rooms in a row."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from ptl.claims import comparisons as c
from ptl.claims import places
from ptl.claims.claim import claim
from ptl.claims.evidence import Evidence
from ptl.claims.reading import tasks_text
from ptl.claims.thresholds import ABOUT, ABOUT_POINTS, MAJORITY
from ptl.claims.verdict import Part, above, below, between, in_plain_reading
from ptl.measures.statistics import exactly
from ptl.text import percent

ENV = "env1"
TASKS = "ABCDEF"
TABLES = "table1 table2"


@claim(
    "E1-subgoals",
    "Subgoals concentrate on the doorways with the incremental metric; the original metric does not single"
    " out the newest doorway, the last one on the way to the goal.",
    shown_in="figure09",
    open_to="tolerance",
)
def subgoals(evidence: Evidence) -> Iterator[Part | str]:
    """Take the peak of the metric for the subgoal; task A has only one doorway to single out."""
    world = evidence.world(ENV)
    doors, reach = places.doorways(world), evidence.reading.tolerance
    at_any = places.near(world, doors, reach)
    goals = {task: evidence.goal(ENV, task) for task in TASKS}
    at_newest = {task: places.near(world, [places.newest_doorway(world, goal)], reach) for task, goal in goals.items()}

    def hits(metric: str, tasks: str, where: dict[str, np.ndarray]) -> np.ndarray:
        peaks = {task: evidence.peaks(ENV, c.PTL, task, metric) for task in tasks}
        return np.column_stack([(peaks[task] >= 0) & where[task][peaks[task]] for task in tasks])

    anywhere = hits("incremental", TASKS, dict.fromkeys(TASKS, at_any))
    newest = hits("incremental", TASKS, at_newest)
    original = hits("original", c.TRANSFER_TASKS, at_newest)
    control = hits("original", TASKS, dict.fromkeys(TASKS, at_any))
    name = (ENV, "subgoals")
    yield above("incremental metric, share of subgoals on a doorway", c.mean_share(evidence, anywhere, *name), MAJORITY)
    yield above("incremental metric, share on the newest doorway", c.mean_share(evidence, newest, *name), MAJORITY)
    yield below(
        "original metric, share on the newest doorway, tasks B to F",
        c.mean_share(evidence, original, *name),
        MAJORITY,
    )
    yield above(
        "share of subgoals on a doorway, incremental minus original metric",
        c.difference_of_shares(evidence, anywhere, control, *name),
        0.0,
    )
    yield f"doorways and their neighbours are {percent(at_any.mean())} of the states"
    on_doorway = hits("incremental", TASKS, dict.fromkeys(TASKS, places.near(world, doors, 0)))
    yield f"runs with all subgoals on doorways: {anywhere.all(axis=1).sum()} of {len(anywhere)}"
    yield f"on the very cell of a doorway, not beside it: {on_doorway.sum()} of {on_doorway.size} subgoals"


@claim(
    "E1-frequencies",
    "Over all pairs of start and goal, doorways are the states that the original metric selects most often.",
    shown_in="figure08",
    open_to="tolerance",
)
def frequencies(evidence: Evidence) -> Iterator[Part | str]:
    """Count the selections of the survey; there is no interval, since its pairs are all there are."""
    world, counts = evidence.world(ENV), evidence.selected(ENV)
    at = places.near(world, places.doorways(world), evidence.reading.tolerance)
    share, states = float(counts[at].sum() / counts.sum()), float(at.mean())
    yield above("share of all selections that fall on doorways", exactly(share), MAJORITY)
    most = float(counts[at].max() / max(counts[~at].max(), 1))
    yield above(
        "selections of the doorway selected most over those of the other state selected most", exactly(most), 1.0
    )
    yield f"doorways and their neighbours are {percent(states)} of the states"


@claim(
    "E1-order",
    "Without transfer, performance degrades regularly as the tasks get harder: each task from B to F takes"
    " more steps than the one before, in total and at the end.",
    shown_in=TABLES,
)
def order(evidence: Evidence) -> Iterator[Part]:
    """Pair tasks by seed."""
    for metric in ("total_steps", "asymptotic"):
        for easier, harder in pairwise(TASKS):
            low, high = evidence.pair((ENV, easier, c.BASE), (ENV, harder, c.BASE), metric)
            generator = c.named_generator(ENV, easier, harder, c.BASE, metric)
            more = c.statistics.mean_difference(high, low, evidence.how, generator)
            yield above(f"{c.label(metric)}, {harder} minus {easier}", more, 0.0, "steps", float(low.mean()))


@claim(
    "E1-all",
    "Every variant of PTL improves every measure of the tables over no transfer, in every task from B to F.",
    shown_in=TABLES,
)
def every_measure(evidence: Evidence) -> Iterator[Part]:
    """Yield one part for each variant, task and measure; by the plain reading, for each variant and measure."""
    for method in c.VARIANTS:
        for task in c.TRANSFER_TASKS:
            for measure in c.ARTICLE_MEASURES:
                yield c.improves(evidence, ENV, task, method, measure)
    for method in c.VARIANTS:
        for measure in c.ARTICLE_MEASURES:
            yield in_plain_reading(c.improves(evidence, ENV, c.TRANSFER_TASKS, method, measure))


@claim(
    "E1-jump",
    "The first episode of PTL is about 80 to 90% shorter than without transfer.",
    shown_in="table1",
    open_to="tasks",
)
def jump(evidence: Evidence) -> Iterator[Part | str]:
    """Check direction and size."""
    tasks = evidence.reading.tasks
    percent = c.saved_percent(evidence, ENV, tasks, c.PTL, "first_episode")
    yield c.improves(evidence, ENV, tasks, c.PTL, "jump_start")
    yield between("jump start in % of the base's mean", percent, 80 - ABOUT_POINTS, 90 + ABOUT_POINTS, "%")
    yield from c.elsewhere(evidence, ENV, "first_episode")


@claim(
    "E1-asymptotic",
    "PTL ends with a better policy than no transfer and full transfer, even if the goal is unknown.",
    shown_in="table1 figure12",
    open_to="tasks",
)
def asymptotic(evidence: Evidence) -> Iterator[Part]:
    """Compare all three variants with both."""
    for method in c.VARIANTS:
        for other in (c.BASE, c.FULL):
            yield c.saves(evidence, ENV, method, other, "asymptotic", evidence.reading.tasks)


@claim("E1-80", "PTL learns task F in about 80 episodes.", shown_in="table1 figure12")
def eighty_episodes(evidence: Evidence) -> Iterator[Part | str]:
    """Count a task as learned below the threshold of the tables."""
    yield above("share of runs that reach the threshold", c.reached(evidence, ENV, c.LAST_TASK, c.PTL), MAJORITY)
    episodes = c.mean_episodes(evidence, ENV, c.LAST_TASK, c.PTL)
    yield between("mean episodes to the threshold", episodes, 80 * (1 - ABOUT), 80 * (1 + ABOUT), "episodes")
    yield from c.never_reached(evidence, ENV, [c.PTL], c.LAST_TASK)


@claim(
    "E1-total",
    "The total performance of PTL is better than without transfer by more than 90% of the steps.",
    shown_in="table2",
    open_to="tasks",
)
def total(evidence: Evidence) -> Iterator[Part | str]:
    """Check direction and size, as a ratio of mean totals."""
    tasks = evidence.reading.tasks
    yield c.improves(evidence, ENV, tasks, c.PTL, "total_steps")
    percent = c.saved_percent(evidence, ENV, tasks, c.PTL, "total_steps")
    yield above("total steps saved in % of the base's mean", percent, 90.0, "%")
    yield from c.elsewhere(evidence, ENV, "total_steps")


@claim(
    "E1-unknown",
    "Not knowing the goal costs PTL something in total, yet it still needs fewer steps than the other approaches.",
    shown_in="table2 figure12",
    open_to="tasks",
)
def unknown_goal(evidence: Evidence) -> Iterator[Part]:
    """Check the cost first, then compare with each other approach."""
    yield c.saves(evidence, ENV, c.PTL, c.UNKNOWN, "total_steps", evidence.reading.tasks)
    for other in c.OTHERS:
        yield c.saves(evidence, ENV, c.UNKNOWN, other, "total_steps", evidence.reading.tasks)


@claim("E1-negative", "Full transfer shows negative transfer.", shown_in="table2 figure12", open_to="tasks")
def negative_transfer(evidence: Evidence) -> Iterator[Part | str]:
    """Check the sign of the transfer ratio."""
    tasks = evidence.reading.tasks
    ratio = c.mean(evidence, ENV, tasks, c.FULL, "transfer_ratio")
    yield below(f"{tasks_text(tasks)}, {c.FULL}, mean transfer ratio", ratio, 0.0)
    yield from c.elsewhere(evidence, ENV, "total_steps", [(c.FULL, task) for task in c.TRANSFER_TASKS[:-1]])
