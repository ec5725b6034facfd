"""Result files of learning, growth and survey jobs: writing and reading."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import cached_property
from typing import Any

import h5py
import numpy as np

from ptl.agent.skills import Skill, SkillLibrary
from ptl.files.hdf5 import new_file, open_file
from ptl.learning.life import Life, TaskRecord
from ptl.world.gridworld import GridWorld

LEARNING, GROWTH, FREQUENCIES = "ptl-learning/1", "ptl-growth/1", "ptl-frequencies/1"
"""Values of the root attribute ``format``."""

KINDS = (LEARNING, GROWTH, FREQUENCIES)


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
    group.attrs["start"] = record.task.start
    group.attrs["goal"] = record.task.goal
    group.attrs["subgoal"] = update.subgoal
    group.attrs["reason"] = update.reason
    group.attrs["novelty"] = discovery.novelty
    group.attrs["diameter"] = discovery.diameter
    group["q"] = record.q
    group["seen"] = record.seen
    group["steps"] = record.steps
    group["truncated"] = record.truncated
    group["selected"] = np.array([skill for used in record.selected for skill in used], dtype=np.int32)
    group["selected_offsets"] = np.cumsum([0] + [len(used) for used in record.selected], dtype=np.int64)
    group["original"] = discovery.original.product
    group["incremental"] = discovery.incremental.product


def _write_library(group: h5py.Group, library: SkillLibrary, n_states: int) -> None:
    group["subgoals"] = np.array(library.subgoals, dtype=np.int32)
    group["policies"] = np.array([skill.policy for skill in library.skills], dtype=np.int8).reshape(-1, n_states)
    group["learned_after"] = np.array([skill.learned_after for skill in library.skills], dtype=np.int32)


# -- reading ----------------------------------------------------------------------------------------------------------


class TaskView:
    """One task of a learning file; arrays are read when asked for, while the file is open."""

    def __init__(self, name: str, group: h5py.Group) -> None:
        self.name = name
        self._group = group
        self.start = int(group.attrs["start"])
        self.goal = int(group.attrs["goal"])
        self.subgoal = int(group.attrs["subgoal"])
        self.reason = str(group.attrs["reason"])
        self.novelty = float(group.attrs["novelty"])
        self.diameter = int(group.attrs["diameter"])

    def __getattr__(self, name: str) -> np.ndarray:
        if name.startswith("_") or name not in self._group:
            raise AttributeError(f"task {self.name} holds no {name!r}")
        return self._group[name][()]

    def selected_in(self, episode: int) -> list[int]:
        """Return the skills or arms drawn in an episode (counted from 0), in order."""
        first, last = self._group["selected_offsets"][episode : episode + 2]
        return self._group["selected"][first:last].tolist()


class ResultFile:
    """An open result file of any of the three kinds."""

    def __init__(self, file: h5py.File) -> None:
        self.file = file
        self.format = str(file.attrs["format"])
        self.environment = str(file.attrs["environment"])
        self.code = str(file.attrs["code"])
        self.root_seed = int(file.attrs["root_seed"])
        self.parameters: dict[str, Any] = json.loads(file.attrs["parameters"])
        self.versions: dict[str, str] = json.loads(file.attrs["versions"])

    @cached_property
    def world(self) -> GridWorld:
        """The world that the job ran in."""
        return GridWorld.from_text(str(self.file.attrs["map"]), name=f"map in {self.file.filename}")

    @cached_property
    def library(self) -> list[Skill] | None:
        """The skills at the end, None if the method keeps no library."""
        if "library" not in self.file:
            return None
        group = self.file["library"]
        rows = zip(group["subgoals"][()], group["policies"][()], group["learned_after"][()], strict=True)
        return [Skill(int(subgoal), policy, int(after)) for subgoal, policy, after in rows]


class LearningFile(ResultFile):
    """An open learning file."""

    def __init__(self, file: h5py.File) -> None:
        super().__init__(file)
        self.method = str(file.attrs["method"])
        self.seed = int(file.attrs["seed"])
        self.tasks = {name: TaskView(name, group) for name, group in file["tasks"].items()}


@contextmanager
def open_learning(path: str | os.PathLike[str]) -> Iterator[LearningFile]:
    """Open a learning file for reading.

    Raises
    ------
    UserError
        If it is missing, damaged or of another kind.
    """
    with open_file(path, LEARNING) as file:
        yield LearningFile(file)


@contextmanager
def open_result(path: str | os.PathLike[str], kind: str | None = None) -> Iterator[ResultFile]:
    """Open a growth, frequency or learning file for reading; ``kind`` demands one of them."""
    with open_file(path, *([kind] if kind else KINDS)) as file:
        yield LearningFile(file) if file.attrs["format"] == LEARNING else ResultFile(file)
