"""Verification of result files: integrity, location and invariants."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from ptl.agent.skills import Skill
from ptl.errors import UserError
from ptl.files.atomic import UNFINISHED
from ptl.files.csv import read_csv, seal_of
from ptl.files.hdf5 import open_file
from ptl.files.manifest import MANIFEST, damages
from ptl.files.provenance import code_digest
from ptl.files.remedies import make_again
from ptl.files.results import FREQUENCIES, GROWTH, KINDS, LEARNING, LearningFile, ResultFile, TaskView, open_result

STEPS, GAIN, SETTING = ARCHIVES = ("ptl-steps/1", "ptl-gain/1", "ptl-robustness/1")
"""Formats of plain arrays, which have a checksum but no invariants of their own."""

FOLDERS = (
    "learning", "growth", "subgoal_frequencies", "misleading_prior", "fernandez_veloso", "robustness",
)  # fmt: skip
"""Folders below results/<run>/ that hold files of one kind."""


def checkable(path: Path) -> list[Path]:
    """Return the files that `faults_of` can check: the file itself, or those below a folder.

    Those are HDF5 files, manifests and tables that come with a checksum, in alphabetical order. A table that its
    checksum was lost of is still found by the manifest.
    """
    if not path.is_dir():
        return [path]
    sealed = {seal.with_suffix("") for seal in path.rglob("*.sha256")}
    whole = (file for pattern in ("*.h5", MANIFEST) for file in path.rglob(pattern))
    return sorted(sealed.union(file for file in whole if not file.name.startswith(UNFINISHED)))


def faults_of(path: Path, *, current_code: bool = True) -> list[str]:
    """Return the faults of a product, one line each with the remedy; empty if there is none.

    Parameters
    ----------
    path : Path
        An HDF5 file that the workflow made, a table with its checksum beside it, or a manifest: then everything
        that it names is held against it.
    current_code : bool
        Also demand that an HDF5 file was made by the code of this package.
    """
    try:
        if path.name == MANIFEST:
            return damages(path.parent)
        if path.suffix != ".h5":
            return _broken_table(path)
        with open_file(path, *KINDS, *ARCHIVES) as file:
            kind = str(file.attrs["format"])
            found = list(_foreign_archive(path, file, current_code)) if kind in ARCHIVES else []
        if kind in KINDS:
            with open_result(path) as result:
                found = [*_foreign(path, result, current_code), *_impossible(result)]
    except UserError as error:
        return [str(error)]
    return [f"{path}: {fault}; {make_again(path)}" for fault in found]


def _broken_table(path: Path) -> list[str]:
    if not seal_of(path).is_file():
        return [f"{path}: has no checksum to hold it against; name its folder, or an HDF5 file"]
    read_csv(path)
    return []


class OneRun:
    """Lets only files through that lie where they belong, come from the present code, and from one run.

    What aggregates many files calls `admit` for each one, so that a file of another job, an older version of the
    code or other settings cannot slip in.
    """

    def __init__(self) -> None:
        self._first: dict[str, tuple[Path, dict[str, Any]]] = {}

    def admit(self, path: str | os.PathLike[str], result: ResultFile) -> None:
        """Refuse a file that does not belong to the run of those before it.

        Raises
        ------
        UserError
            Naming the file and the command that makes it again.
        """
        path = Path(path)
        for fault in _foreign(path, result, current_code=True):
            raise UserError(f"{path}: {fault}; {make_again(path)}")
        settings = {"root_seed": result.root_seed, **result.parameters}
        first, expected = self._first.setdefault("settings", (path, settings))
        if settings != expected:
            differing = ", ".join(key for key in expected if settings.get(key) != expected[key]) or "parameters"
            raise UserError(f"{path}: was made with other settings ({differing}) than {first}; {make_again(path)}")
        world = {"map": str(result.file.attrs["map"])}
        first, expected = self._first.setdefault(f"map of {result.environment}", (path, world))
        if world != expected:
            raise UserError(f"{path}: was made on another map than {first}; {make_again(path)}")


def _foreign(path: Path, result: ResultFile, current_code: bool) -> Iterator[str]:
    yield from _misplaced(path, result)
    if current_code and result.code != _present_code(result.format, str(result.file.attrs.get("method", ""))):
        yield "was made by another version of the code"


@cache
def _present_code(kind: str, method: str) -> str:
    if kind == LEARNING:
        return code_digest("ptl.learning.life", f"ptl.methods.{method}")
    if kind == GROWTH:
        return code_digest("ptl.learning.growth", f"ptl.methods.{method}")
    return code_digest("ptl.learning.survey")


def _foreign_archive(path: Path, file: h5py.File, current_code: bool) -> Iterator[str]:
    """Check place and code of the files of plain arrays."""
    kind = str(file.attrs["format"])
    if kind == STEPS:
        if path.name != "steps.h5":
            yield "holds the steps of a whole run, steps.h5"
        return
    name, modules = {
        GAIN: ("arm", ("ptl.study.policy_reuse_experiment", "ptl.methods.policy_reuse", "ptl.methods.no_transfer")),
        SETTING: ("setting", ()),
    }[kind]
    if path.stem != str(file.attrs[name]):
        yield f"holds the job {file.attrs[name]}"
    if kind == SETTING:
        methods = json.loads(file.attrs["job"])["methods"]
        modules = ("ptl.study.robustness.running", *[f"ptl.methods.{method}" for method in methods])
    if current_code and str(file.attrs["code"]) != code_digest(*modules):
        yield "was made by another version of the code"


def _misplaced(path: Path, result: ResultFile) -> Iterator[str]:
    """Check that a file is where the layout of results/<run>/ puts its job."""
    parts = path.absolute().parts
    folders = parts[-4:-1]  # not the folders above the project
    if result.format == LEARNING and ("learning" in folders or folders[-1] == "misleading_prior"):
        assert isinstance(result, LearningFile)
        expected: tuple[str, ...] = (result.environment, result.method, f"seed_{result.seed:03d}.h5")
        if "learning" not in folders:
            expected = (result.environment, expected[-1])
        if parts[-len(expected) :] != expected:
            yield f"holds the job {'/'.join(expected)}"
    elif result.format == GROWTH and folders[-1] == "growth":
        expected_name = f"run_{int(result.file.attrs['seed']):03d}.h5"
        if parts[-1] != expected_name:
            yield f"holds the job {expected_name}"
    elif result.format == FREQUENCIES and "subgoal_frequencies" in folders:
        batch = result.file.attrs.get("batch")
        expected = (f"{result.environment}.h5",) if batch is None else (result.environment, f"batch_{batch}.h5")
        if parts[-len(expected) :] != expected:
            yield f"holds the frequencies {'/'.join(expected)}"
    elif parts[-1] == "steps.h5" or any(folder in folders for folder in FOLDERS):
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
            yield f"task {name}: a value of Q is outside [0, 1]"
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
    """Check that the policy leads to the subgoal from every state where it is defined."""
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
