"""The article's claims on environment 3, the map of Fernandez and Veloso."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ptl.claims import comparisons as c
from ptl.claims import places
from ptl.claims.claim import claim
from ptl.claims.evidence import Evidence
from ptl.claims.reading import tasks_text
from ptl.claims.thresholds import FEW_EPISODES, NO_IMPROVEMENT
from ptl.claims.verdict import Part, above, below
from ptl.measures import statistics
from ptl.measures.statistics import named_generator

ENV = "env3"

MAP_SHAPE = (21, 24)
LOWER_CORRIDOR = ((14, 15), (1, 22))
"""Rows and columns of the corridor, two cells wide, that runs below the middle from side to side."""

ROOM = ((1, 3), (13, 22))
"""Rows and columns of the room in the upper right. A wall with one gap, at row 2 and column 17, parts it into
a half with goal A, where the door from the corridor is, and a half with goals E and F. We read "the room" as both
halves with the gap, since the article contrasts it with the corridors, and note the count for the inner half too."""

INNER_HALF = ((1, 3), (18, 22))


@claim("E3-jump", "The jump start is not improved.", shown_in="table5 figure12", open_to="tasks runs")
def jump(evidence: Evidence) -> Iterator[Part | str]:
    """Demand no significant improvement, and a small one: lack of significance alone could be lack of runs."""
    tasks = evidence.reading.tasks
    yield c.jump_start_not_significant(evidence, ENV, tasks, c.PTL)
    percent = c.saved_percent(evidence, ENV, tasks, c.PTL, "first_episode")
    yield below(f"{tasks_text(tasks)}, ptl, jump start in % of the base's mean", percent, NO_IMPROVEMENT, "%")
    yield from c.elsewhere(evidence, ENV, "first_episode")


@claim(
    "E3-threshold",
    "PTL needs far fewer episodes to learn than no transfer.",
    shown_in="table5 figure12",
    open_to="tasks",
)
def threshold(evidence: Evidence) -> Iterator[Part | str]:
    """Check direction and size."""
    tasks = evidence.reading.tasks
    yield from c.needs_fewer_episodes(evidence, ENV, c.BASE, tasks)
    yield from c.never_reached(evidence, ENV, (c.PTL, c.BASE), tasks)


@claim(
    "E3-recovery",
    "Where skills mislead, PTL recovers within a few episodes, even if its first episode gets longer.",
    shown_in="figure12",
    open_to="tasks",
)
def recovery(evidence: Evidence) -> Iterator[Part | str]:
    """Compare the episodes after the first, up to the last of a few; the first one is that of E3-jump."""
    total, levels = [], []
    for task in evidence.reading.tasks:
        own, base = evidence.curves(ENV, (c.PTL, c.BASE), task)
        few = (slice(None), slice(1, FEW_EPISODES))
        total.append((base[few] - own[few]).sum(axis=1))
        levels.append(float(base[few].sum(axis=1).mean()))
    generator = named_generator(ENV, evidence.reading.tasks, c.PTL, "recovery")
    saved = statistics.mean(np.sum(total, axis=0), evidence.how, generator)
    text = f"{tasks_text(evidence.reading.tasks)}, steps in episodes 2 to {FEW_EPISODES}, {c.BASE} minus {c.PTL}"
    yield above(text, saved, 0.0, "steps", sum(levels))
    yield from c.elsewhere(evidence, ENV, "first_episode")


@claim("E3-ratio", "The transfer ratio of PTL exceeds 50%.", shown_in="table6", open_to="tasks")
def ratio(evidence: Evidence) -> Iterator[Part | str]:
    """Check direction and size, as the mean of the ratios of all seeds."""
    tasks = evidence.reading.tasks
    estimate = c.mean(evidence, ENV, tasks, c.PTL, "transfer_ratio")
    yield above(f"{tasks_text(tasks)}, ptl, mean transfer ratio", estimate, 0.0)
    yield above(f"{tasks_text(tasks)}, ptl, mean transfer ratio", estimate, 0.5)
    yield from c.elsewhere(evidence, ENV, "total_steps")


@claim("E3-few", "All methods but no transfer learn task F within a few episodes.", shown_in="table5 figure12")
def few_episodes(evidence: Evidence) -> Iterator[Part | str]:
    """Count a task as learned below the threshold of the tables."""
    methods = (c.FULL, c.REUSE, *c.VARIANTS)
    for method in methods:
        yield c.fewer_than(evidence, ENV, method, FEW_EPISODES, c.LAST_TASK)
    base = c.mean_episodes(evidence, ENV, c.LAST_TASK, c.BASE)
    yield above(f"task F, {c.BASE}, episodes to the threshold", base, FEW_EPISODES, "episodes")
    yield from c.never_reached(evidence, ENV, (c.BASE, *methods), c.LAST_TASK)


@claim(
    "E3-subgoals",
    "The new subgoal of task C lies in the lower corridor; those of E and F lie inside the room in the upper right.",
    shown_in="figure11",
)
def subgoals(evidence: Evidence) -> Iterator[Part | str]:
    """Take the peak of the incremental metric for the subgoal, stored or not, and say how often it was stored."""
    world = evidence.world(ENV)
    corridor, room, inner = (places.rectangle(world, *where, MAP_SHAPE) for where in (LOWER_CORRIDOR, ROOM, INNER_HALF))
    for task, where, name in (("C", corridor, "in the lower corridor"), ("E", room, "inside the room"),
                              ("F", room, "inside the room")):  # fmt: skip
        peaks = evidence.peaks(ENV, c.PTL, task, "incremental")
        stored = int((evidence.stored(ENV, c.PTL, task) >= 0).sum())
        text = f"task {task}, subgoal {name} (peak of the metric; stored in {stored} of {len(peaks)} runs)"
        yield c.mostly(evidence, text, (peaks >= 0) & where[peaks])
        yield c.mostly(evidence, f"task {task}, its subgoal becomes a skill", evidence.stored(ENV, c.PTL, task) >= 0)
        if where is room:
            inside = int(((peaks >= 0) & inner[peaks]).sum())
            yield f"task {task}: in the inner half of the room in {inside} of {len(peaks)} runs"
