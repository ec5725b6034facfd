"""Checks result files: that they are whole, that they belong where they lie, and that what they say can be true."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ptl.errors import UserError
from ptl.hdf5 import open_file
from ptl.provenance import code_digest
from ptl.skills import Skill
from ptl.store import FREQUENCIES, GROWTH, KINDS, LEARNING, LearningFile, ResultFile, TaskView, open_result

ARCHIVES = ("ptl-steps/1", "ptl-gain/1", "ptl-robustness/1")
"""Formats of plain arrays, which have a checksum but no invariants of their own."""


def faults_of(path: Path, *, current_code: bool = True) -> list[str]:
    """What is wrong with a result file, one line each that ends with the remedy; empty if nothing is.

    Parameters
    ----------
    path : Path
        A learning, growth or frequency file.
    current_code : bool
        Also demand that the file was made by the code of this package.
    """
    try:
        with open_file(path, *KINDS, *ARCHIVES) as file:
            if file.attrs["format"] in ARCHIVES:
                return []
        with open_result(path) as result:
            found = list(_misplaced(path, result)) + list(_impossible(result))
            if current_code and result.code != _present_code(result):
                found.append("was made by another version of the code")
    except UserError as error:
        return [str(error)]
    return [f"{path}: {fault}; remove it and run 'snakemake {path}' to make it again" for fault in found]


def _present_code(result: ResultFile) -> str:
    if isinstance(result, LearningFile):
        return code_digest("ptl.learning", f"ptl.methods.{result.method}")
    if result.format == GROWTH:
        return code_digest("ptl.growth", f"ptl.methods.{result.file.attrs['method']}")
    return code_digest("ptl.frequencies")


def _misplaced(path: Path, result: ResultFile) -> Iterator[str]:
    """The layout of results/<run>/ says which job a file must come from."""
    parts = path.absolute().parts
    if result.format == LEARNING and "learning" in parts[:-3]:
        assert isinstance(result, LearningFile)
        expected = (result.environment, result.method, f"seed_{result.seed:03d}.h5")
        if parts[-3:] != expected:
            yield f"holds the job {'/'.join(expected)}"
    elif result.format == GROWTH and parts[-2] == "growth":
        expected_name = f"run_{int(result.file.attrs['seed']):03d}.h5"
        if parts[-1] != expected_name:
            yield f"holds the job {expected_name}"
    elif result.format == FREQUENCIES and parts[-2] == "subgoal_frequencies":
        if path.stem != result.environment:
            yield f"holds the frequencies of {result.environment}"
    elif any(folder in parts[-4:-1] for folder in ("learning", "growth", "subgoal_frequencies")):
        yield f"is of the kind {result.format}, which does not belong in this folder"


def _impossible(result: ResultFile) -> Iterator[str]:
    if isinstance(result, LearningFile):
        yield from _impossible_learning(result)
    elif result.format == GROWTH:
        growth = np.diff(result.file["library_size"][()])
        if result.file["library_size"][0] != 0 or ((growth != 0) & (growth != 1)).any():
            yield "its library does not grow from 0 by at most one skill a task"
        if len(result.library or []) != result.file["library_size"][-1]:
            yield "its library is not of the size that it says"
    else:
        counts, unresolved = result.file["counts"][()], int(result.file["unresolved"][()])
        if (counts < 0).any() or counts.sum() + unresolved != int(result.file["pairs"][()]):
            yield "its counts do not add up to the number of pairs"


def _impossible_learning(result: LearningFile) -> Iterator[str]:
    world = result.world
    options = 1
    for index, (name, task) in enumerate(result.tasks.items()):
        shortest = world.shortest_path_length(task.start, task.goal)
        steps, truncated, q = task.steps, task.truncated, task.q
        if (steps[~truncated] < shortest).any():
            yield f"task {name}: an episode is shorter than the shortest path of {shortest} steps"
        if not (np.isfinite(q).all() and (q >= 0).all() and (q <= 1).all()):
            yield f"task {name}: a value of Q lies outside [0, 1]"
        if q[task.goal].any() and result.method != "full_transfer":
            yield f"task {name}: Q is not zero at the goal, where no action is taken"
        yield from _impossible_selection(name, task, len(steps), options)
        if task.subgoal >= 0 and not (task.seen[task.subgoal] or task.subgoal == task.goal):
            yield f"task {name}: the new subgoal was never visited"
        options += result.library is None or task.subgoal >= 0
        if result.library is not None:
            learned = [skill.subgoal for skill in result.library if skill.learned_after == index]
            if learned != [task.subgoal] * (task.subgoal >= 0):
                yield f"task {name}: the library does not hold the subgoal found"
    for skill in result.library or []:
        yield from _impossible_skill(skill, world.successors)


def _impossible_selection(name: str, task: TaskView, episodes: int, options: int) -> Iterator[str]:
    selected, offsets = task.selected, task.selected_offsets
    if len(offsets) != episodes + 1 or offsets[0] != 0 or (np.diff(offsets) < 0).any() or offsets[-1] != len(selected):
        yield f"task {name}: the skills drawn do not fit the episodes"
    elif len(selected) and (selected.min() < 0 or selected.max() >= options):
        yield f"task {name}: a skill was drawn that did not exist yet"


def _impossible_skill(skill: Skill, successors: np.ndarray) -> Iterator[str]:
    """Following the policy from every state where it is defined must end at the subgoal."""
    n = len(successors)
    state = np.flatnonzero(skill.policy >= 0)
    if not ((skill.policy >= -1) & (skill.policy <= 3)).all():
        yield f"skill of state {skill.subgoal}: holds an action that does not exist"
        return
    for _ in range(n):
        state = state[state != skill.subgoal]
        if not state.size:
            return
        if (skill.policy[state] < 0).any():
            break
        state = np.unique(successors[state, skill.policy[state]])
    yield f"skill of state {skill.subgoal}: its policy does not lead to the subgoal"
