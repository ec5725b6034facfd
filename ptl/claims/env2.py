"""The article's claims on environment 2, a corridor with small rooms and one big room."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ptl.claims import comparisons as c
from ptl.claims import env1, places
from ptl.claims.claim import claim
from ptl.claims.evidence import Evidence, MissingEvidence
from ptl.claims.reading import tasks_text
from ptl.claims.thresholds import FAR, MAJORITY
from ptl.claims.verdict import Part, above, below, in_plain_reading
from ptl.measures.statistics import exactly
from ptl.text import number

ENV = "env2"
TASKS = "ABCDEF"
TABLES = "table3 table4"


@claim(
    "E2-size",
    "Environment 2 has far fewer states than environment 1.",
    shown_in="figure05 figure06",
    by_construction="the drawings of both maps are ours",
)
def size(evidence: Evidence) -> Iterator[Part | str]:
    """Count the states of the maps; there is no interval."""
    small, large = evidence.world(ENV).n_states, evidence.world(env1.ENV).n_states
    yield below("states as a share of those of environment 1", exactly(small / large), 1 / FAR)
    yield f"{small} against {large} states"


@claim(
    "E2-all",
    "PTL improves every measure of the tables significantly over no transfer, in every task from B to F,"
    " except the first episode with the goal unknown, which deviates too much.",
    shown_in=TABLES,
    open_to="runs",
)
def every_measure(evidence: Evidence) -> Iterator[Part]:
    """Yield one part for each variant, task and measure; by the plain reading, for each variant and measure.

    The exception must not be significant.
    """

    def part(method: str, tasks: str, measure: str) -> Part:
        if (method, measure) == (c.UNKNOWN, "jump_start"):
            return c.jump_start_not_significant(evidence, ENV, tasks, method)
        return c.improves(evidence, ENV, tasks, method, measure)

    for method in c.VARIANTS:
        for task in c.TRANSFER_TASKS:
            for measure in c.ARTICLE_MEASURES:
                yield part(method, task, measure)
    for method in c.VARIANTS:
        for measure in c.ARTICLE_MEASURES:
            yield in_plain_reading(part(method, c.TRANSFER_TASKS, measure))


@claim(
    "E2-unknown",
    "With the goal unknown the first episode of PTL still takes fewer steps on average than that of no transfer.",
    shown_in="table3",
    open_to="tasks",
)
def unknown_goal(evidence: Evidence) -> Iterator[Part | str]:
    """Check the mean; that it is not significant by the article's runs is a part of E2-all."""
    tasks = evidence.reading.tasks
    yield c.improves(evidence, ENV, tasks, c.UNKNOWN, "jump_start")
    yield from c.elsewhere(evidence, ENV, "first_episode", [(c.UNKNOWN, task) for task in c.TRANSFER_TASKS[:-1]])


@claim(
    "E2-converge",
    "No transfer and full transfer converge too, but they need many more episodes than PTL.",
    shown_in="table3 figure12",
    open_to="tasks",
)
def converge(evidence: Evidence) -> Iterator[Part | str]:
    """Count a method as converged below the threshold of the tables."""
    tasks = evidence.reading.tasks
    for other in (c.BASE, c.FULL):
        text = f"{tasks_text(tasks)}, {other}, share of runs that reach the threshold"
        yield above(text, c.reached(evidence, ENV, tasks, other), MAJORITY)
        yield from c.needs_fewer_episodes(evidence, ENV, other, tasks)
    yield from c.never_reached(evidence, ENV, (c.PTL, c.BASE, c.FULL), tasks)


@claim("E2-positive", "Full transfer becomes positive.", shown_in="table4 figure12", open_to="tasks")
def positive_transfer(evidence: Evidence) -> Iterator[Part | str]:
    """Check the sign of the transfer ratio."""
    tasks = evidence.reading.tasks
    ratio = c.mean(evidence, ENV, tasks, c.FULL, "transfer_ratio")
    yield above(f"{tasks_text(tasks)}, {c.FULL}, mean transfer ratio", ratio, 0.0)
    yield from c.elsewhere(evidence, ENV, "total_steps", [(c.FULL, task) for task in c.TRANSFER_TASKS[:-1]])


@claim(
    "E2-subgoals",
    "Goals in small rooms give subgoals at the doors of these rooms; goals in the big room give subgoals"
    " inside it, not in the corridor.",
    shown_in="figure10",
    open_to="tolerance",
)
def subgoals(evidence: Evidence) -> Iterator[Part | str]:
    """Take the start's room for the corridor and the largest of the others for the big room."""
    world = evidence.world(ENV)
    room = places.rooms(world)
    sizes = np.bincount(room[room >= 0])
    sizes[room[world.start]] = 0
    big = int(sizes.argmax())
    for task in TASKS:
        goal_room = int(room[evidence.goal(ENV, task)])
        if goal_room in (-1, room[world.start]):
            raise MissingEvidence(f"{world.name}: goal {task} is not in a room")
        peaks = evidence.peaks(ENV, c.PTL, task, "incremental")
        if goal_room == big:
            where, text = room == big, f"task {task}, subgoal inside the big room"
        else:
            doors = places.doors_of(world, goal_room)
            where, text = (
                places.near(world, doors, evidence.reading.tolerance),
                f"task {task}, subgoal at the door of the goal's room",
            )
            distance = places.steps_to(world, doors)[peaks[peaks >= 0]].mean() if (peaks >= 0).any() else np.nan
            yield f"task {task}: the mean distance of the subgoal from the door is {number(distance)} steps"
        yield c.mostly(evidence, text, (peaks >= 0) & where[peaks])
