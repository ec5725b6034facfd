"""Result files of learning, growth and survey jobs: writing and reading."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import cached_property
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from ptl.agent.skills import Skill, SkillLibrary
from ptl.errors import UserError
from ptl.files.hdf5 import Node, new_file, read_file
from ptl.files.invariants import impossible
from ptl.files.remedies import make_again
from ptl.files.schema import FREQUENCIES, GROWTH, KINDS, LEARNING
from ptl.learning.life import Life, TaskRecord
from ptl.world.gridworld import GridWorld

WITH_ORIGIN = (LEARNING, GROWTH, FREQUENCIES)
"""Kinds of file that this module reads."""

MOST_FAULTS = 3
"""Impossible things that one line names."""


# -- writing ----------------------------------------------------------------------------------------------------------


def write_learning(path: str | os.PathLike[str], life: Life, world: GridWorld, origin: Mapping[str, Any]) -> None:
    """Write one learner's life.

    Parameters
    ----------
    origin : mapping
        Root attributes: environment, method, seed, root_seed, parameters (nested dictionaries), code (digest).
    """
    with new_file(path, LEARNING, {**origin, "map": world.text}) as file:
        tasks = file.create_group("tasks", track_order=True)
        for record in life.records:
            _write_task(tasks.create_group(record.task.name), record)
        if life.library is not None:
            _write_library(file.create_group("library"), life.library, world.n_states)


def write_growth(path: str | os.PathLike[str], life: Life, world: GridWorld, origin: Mapping[str, Any]) -> None:
    """Write how the library grew over a life of many tasks; Q-tables are left out."""
    with new_file(path, GROWTH, {**origin, "map": world.text}) as file:
        added = [record.update.subgoal >= 0 for record in life.records]
        file["starts"] = np.array([record.task.start for record in life.records], dtype=np.int32)
        file["goals"] = np.array([record.task.goal for record in life.records], dtype=np.int32)
        file["library_size"] = np.concatenate([[0], np.cumsum(added)]).astype(np.int64)
        file["total_steps"] = np.array([record.steps.sum() for record in life.records], dtype=np.int64)
        assert life.library is not None
        _write_library(file.create_group("library"), life.library, world.n_states)


def write_frequencies(
    path: str | os.PathLike[str], arrays: Mapping[str, np.ndarray], world: GridWorld, origin: Mapping[str, Any]
) -> None:
    """Write subgoal frequencies (arrays by name) of one environment."""
    with new_file(path, FREQUENCIES, {**origin, "map": world.text}) as file:
        for name, values in arrays.items():
            file[name] = values


def _write_task(group: h5py.Group, record: TaskRecord) -> None:
    discovery, update = record.discovery, record.update
    group.attrs["start"] = int(record.task.start)
    group.attrs["goal"] = int(record.task.goal)
    group.attrs["subgoal"] = int(update.subgoal)
    group.attrs["reason"] = update.reason
    group.attrs["novelty"] = float(discovery.novelty)
    group.attrs["diameter"] = int(discovery.diameter)
    group["q"] = record.q
    group["seen"] = record.seen
    group["steps"] = record.steps
    group["truncated"] = record.truncated
    group["selected"] = np.array([skill for used in record.selected for skill in used], dtype=np.int32)
    group["selected_offsets"] = np.cumsum([0] + [len(used) for used in record.selected], dtype=np.int64)
    group["original"] = discovery.original.product
    group["incremental"] = discovery.incremental.product


def _write_library(group: h5py.Group, library: SkillLibrary, n_states: int) -> None:
    # The skills and not `library.subgoals`: a library that makes its policies when they are drawn has none to store.
    group["subgoals"] = np.array([skill.subgoal for skill in library.skills], dtype=np.int32)
    group["policies"] = np.array([skill.policy for skill in library.skills], dtype=np.int8).reshape(-1, n_states)
    group["learned_after"] = np.array([skill.learned_after for skill in library.skills], dtype=np.int32)


# -- reading ----------------------------------------------------------------------------------------------------------


class TaskView:
    """One task of a learning file."""

    def __init__(self, name: str, node: Node) -> None:
        self.name = name
        self._node = node
        self.start: int = node.attrs["start"]
        self.goal: int = node.attrs["goal"]
        self.subgoal: int = node.attrs["subgoal"]
        self.reason: str = node.attrs["reason"]
        self.novelty: float = node.attrs["novelty"]
        self.diameter: int = node.attrs["diameter"]

    def __getattr__(self, name: str) -> np.ndarray:
        if name.startswith("_") or name not in self._node:
            raise AttributeError(f"task {self.name} holds no {name!r}")
        return self._node[name]

    def selected_in(self, episode: int) -> list[int]:
        """Return the skills or arms drawn in an episode (counted from 0), in order."""
        first, last = self.selected_offsets[episode : episode + 2]
        return self.selected[first:last].tolist()


class ResultFile:
    """A growth, frequency or learning file, in memory.

    Attributes
    ----------
    path : Path
    file : Node
        Arrays by name, and the root attributes in ``attrs``.
    """

    def __init__(self, path: Path, file: Node) -> None:
        self.path = path
        self.file = file
        self.format: str = file.attrs["format"]
        self.environment: str = file.attrs["environment"]
        self.code: str = file.attrs["code"]
        self.root_seed: int = file.attrs["root_seed"]
        self.parameters: dict[str, Any] = file.attrs["parameters"]
        self.versions: dict[str, str] = file.attrs["versions"]

    @cached_property
    def world(self) -> GridWorld:
        """The world that the job ran in."""
        return GridWorld.from_text(self.file.attrs["map"], name=f"map in {self.path}")

    @cached_property
    def library(self) -> list[Skill] | None:
        """The skills at the end, None if the method keeps no library."""
        if "library" not in self.file:
            return None
        group = self.file["library"]
        rows = zip(group["subgoals"], group["policies"], group["learned_after"], strict=True)
        return [Skill(int(subgoal), policy, int(after)) for subgoal, policy, after in rows]


class LearningFile(ResultFile):
    """A learning file, in memory."""

    def __init__(self, path: Path, file: Node) -> None:
        super().__init__(path, file)
        self.method: str = file.attrs["method"]
        self.seed: int = file.attrs["seed"]
        self.tasks = {name: TaskView(name, node) for name, node in file["tasks"].items()}


VIEWS: Mapping[str, type[ResultFile]] = {LEARNING: LearningFile, GROWTH: ResultFile, FREQUENCIES: ResultFile}


def read_result(path: str | os.PathLike[str], *kinds: str) -> ResultFile:
    """Read a growth, frequency or learning file, or only one of some of these kinds.

    Raises
    ------
    UserError
        If it is missing, damaged, of another kind, or its content does not fit the declaration of its kind or is
        impossible.
    """
    result = read_whole(path, *(kinds or WITH_ORIGIN))
    assert isinstance(result, ResultFile)
    return result


def read_whole(path: str | os.PathLike[str], *kinds: str) -> ResultFile | Node:
    """Read a file of any kind or of some kinds: a `ResultFile` if there is one for it, otherwise the file's root.

    Errors as in `read_result`.
    """
    root = read_file(path, *(kinds or KINDS))
    kind = root.attrs["format"]
    content = VIEWS[kind](Path(path), root) if kind in VIEWS else root
    if faults := list(impossible(kind, content)):
        raise UserError(f"{path}: {'; '.join(faults[:MOST_FAULTS])}; {make_again(path)}")
    return content


@contextmanager
def open_learning(path: str | os.PathLike[str]) -> Iterator[LearningFile]:
    """Read a learning file; errors as in `read_result`."""
    result = read_result(path, LEARNING)
    assert isinstance(result, LearningFile)
    yield result


@contextmanager
def open_result(path: str | os.PathLike[str], kind: str | None = None) -> Iterator[ResultFile]:
    """Read a growth, frequency or learning file; ``kind`` demands one of them. Errors as in `read_result`."""
    yield read_result(path, *([kind] if kind else []))
