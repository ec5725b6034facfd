"""What the numbers in a result file must be to each other, whatever made them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from ptl import methods
from ptl.agent.skills import Skill
from ptl.files.schema import GROWTH, LEARNING

if TYPE_CHECKING:
    from ptl.files.results import LearningFile, ResultFile, TaskView


def impossible(result: ResultFile) -> Iterator[str]:
    """Yield what is impossible in a file that fits the declaration of its kind."""
    if result.format == LEARNING:
        yield from _learning(result)  # type: ignore[arg-type]
    elif result.format == GROWTH:
        sizes = result.file["library_size"]
        if sizes[0] != 0 or not np.isin(np.diff(sizes), (0, 1)).all():
            yield "its library does not grow from 0 by at most one skill a task"
        if len(result.library or []) != sizes[-1]:
            yield "its library is not of the size that it says"
        yield from _library(result, len(sizes) - 1)
    else:
        counts, unresolved = result.file["counts"], int(result.file["unresolved"])
        if counts.sum() + unresolved != int(result.file["pairs"]):
            yield "its counts do not add up to the number of pairs"
        if "batch" in result.file.attrs and result.file.attrs["batch"] >= result.file.attrs["batches"]:
            yield "its batch is none of its batches"


def _learning(result: LearningFile) -> Iterator[str]:
    world = result.world
    options = 1
    ours = result.method in methods.names()  # another method may mean something else by Q, and draw what is no skill
    for index, (name, task) in enumerate(result.tasks.items()):
        shortest = world.shortest_path_length(task.start, task.goal)
        if shortest < 0:
            yield f"task {name}: its goal cannot be reached"
        if (task.steps[~task.truncated] < shortest).any():
            yield f"task {name}: an episode is shorter than the shortest path of {shortest} steps"
        if ours:
            if not ((task.q >= 0).all() and (task.q <= 1).all()):
                yield f"task {name}: a value of Q is outside [0, 1]"
            if task.q[task.goal].any() and result.method != "full_transfer":
                yield f"task {name}: Q is not zero at the goal, where no action is taken"
        yield from _selection(name, task, options if ours else None)
        if task.subgoal >= 0 and not (task.seen[task.subgoal] or task.subgoal == task.goal):
            yield f"task {name}: the new subgoal was never visited"
        options += result.library is None or task.subgoal >= 0
        if result.library is not None:
            learned = [skill.subgoal for skill in result.library if skill.learned_after == index]
            if learned != [task.subgoal] * (task.subgoal >= 0):
                yield f"task {name}: the library does not hold the subgoal found"
    yield from _library(result, len(result.tasks))


def _selection(name: str, task: TaskView, options: int | None) -> Iterator[str]:
    selected, offsets = task.selected, task.selected_offsets
    if offsets[0] != 0 or (np.diff(offsets) < 0).any() or offsets[-1] != len(selected):
        yield f"task {name}: the skills drawn do not fit the episodes"
    elif options is not None and len(selected) and selected.max() >= options:
        yield f"task {name}: a skill was drawn that did not exist yet"


def _library(result: ResultFile, tasks: int) -> Iterator[str]:
    library = result.library or []
    if any(skill.learned_after >= tasks for skill in library):
        yield "its library holds a skill of a task that is not there"
    for skill in library:
        if not leads_to_subgoal(skill, result.world.successors):
            yield f"skill of state {skill.subgoal}: its policy does not lead to the subgoal"


def leads_to_subgoal(skill: Skill, successors: np.ndarray) -> bool:
    """Return whether a policy reaches its subgoal from every state where it is defined."""
    states = np.arange(len(successors))
    defined = skill.policy >= 0
    after = np.where(defined, successors[states, np.maximum(skill.policy, 0)], states)
    after[skill.subgoal] = skill.subgoal
    for _ in range(len(successors).bit_length()):  # 1, 2, 4, ... steps
        after = after[after]
    return bool((after[defined] == skill.subgoal).all())
