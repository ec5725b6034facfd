"""HDF5 files: what a learning, growth or frequency job leaves behind, and how it is read back.

Equal runs give equal bytes: nothing in a file depends on when or where it was written. Every file carries what is
needed to rerun it and, as ``content``, a sha256 over everything else in it.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import cached_property
from pathlib import Path
from typing import Any

import h5py
import numpy as np

import ptl
from ptl.errors import UserError
from ptl.files import atomic_path
from ptl.gridworld import GridWorld
from ptl.learning import Life, TaskRecord
from ptl.skills import Skill, SkillLibrary

LEARNING, GROWTH, FREQUENCIES = "ptl-learning/1", "ptl-growth/1", "ptl-frequencies/1"
"""Values of the root attribute ``format``."""


# -- writing ----------------------------------------------------------------------------------------------------------


def write_learning(path: str | os.PathLike[str], life: Life, world: GridWorld, origin: Mapping[str, Any]) -> None:
    """Write one learner's life.

    Parameters
    ----------
    origin : mapping
        Root attributes: environment, method, seed, root_seed, parameters (nested dictionaries), code (digest).
    """
    with _new_file(path, LEARNING, world, origin) as file:
        tasks = file.create_group("tasks", track_order=True)
        for record in life.records:
            _write_task(tasks.create_group(record.task.name), record)
        if life.library is not None:
            _write_library(file.create_group("library"), life.library, world.n_states)


def write_growth(path: str | os.PathLike[str], life: Life, world: GridWorld, origin: Mapping[str, Any]) -> None:
    """Write how the library grew over a life of many tasks; Q-tables are left out."""
    with _new_file(path, GROWTH, world, origin) as file:
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
    with _new_file(path, FREQUENCIES, world, origin) as file:
        for name, values in arrays.items():
            file[name] = values


@contextmanager
def _new_file(
    path: str | os.PathLike[str], kind: str, world: GridWorld, origin: Mapping[str, Any]
) -> Iterator[h5py.File]:
    with atomic_path(path) as temporary, h5py.File(temporary, "w", libver="v110") as file:
        file.attrs["format"] = kind
        for name, value in origin.items():
            file.attrs[name] = json.dumps(value, sort_keys=True) if isinstance(value, dict) else value
        file.attrs["map"] = world.text
        file.attrs["versions"] = json.dumps(
            {"ptl": ptl.__version__, "numpy": np.__version__, "h5py": h5py.__version__}, sort_keys=True
        )
        yield file
        file.attrs["content"] = content_digest(file)


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


def content_digest(file: h5py.File) -> str:
    """sha256 over all names, attributes, types, shapes and values of an open file, save the root's ``content``."""
    digest = hashlib.sha256()

    def add_attributes(item: h5py.Group | h5py.Dataset) -> None:
        for name in sorted(item.attrs):
            if not (item.name == "/" and name == "content"):
                value = np.asarray(item.attrs[name])
                digest.update(f"{item.name}@{name}={value.dtype.str} {value.tolist()!r}\n".encode())

    def add(_: str, item: h5py.Group | h5py.Dataset) -> None:
        digest.update(f"{item.name}\n".encode())
        add_attributes(item)
        if isinstance(item, h5py.Dataset):
            digest.update(f"{item.dtype.str}{item.shape}\n".encode())
            digest.update(np.ascontiguousarray(item[()]).tobytes())

    add_attributes(file)
    file.visititems(add)
    return digest.hexdigest()


# -- reading ----------------------------------------------------------------------------------------------------------


class TaskView:
    """One task of a learning file; arrays are read when asked for."""

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
        """Skills or arms drawn in an episode (counted from 0), in order."""
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
    with _open(path, LEARNING) as file:
        yield LearningFile(file)


@contextmanager
def open_result(path: str | os.PathLike[str], kind: str | None = None) -> Iterator[ResultFile]:
    """Open a growth, frequency or learning file for reading; ``kind`` demands one of them."""
    with _open(path, kind) as file:
        yield LearningFile(file) if file.attrs["format"] == LEARNING else ResultFile(file)


@contextmanager
def _open(path: str | os.PathLike[str], kind: str | None) -> Iterator[h5py.File]:
    remedy = f"remove it and run 'snakemake {path}' to make it again"
    if not Path(path).is_file():
        raise UserError(f"{path}: no such file; run 'snakemake {path}' to make it")
    try:
        file = h5py.File(path, "r")
    except OSError as error:
        raise UserError(f"{path}: damaged or not an HDF5 file ({_first_line(error)}); {remedy}") from error
    with file:
        try:
            found = file.attrs.get("format")
            intact = file.attrs.get("content") == content_digest(file)
        except Exception as error:  # HDF5 reports damage by exceptions of many types
            raise UserError(f"{path}: damaged ({_first_line(error)}); {remedy}") from error
        if found not in (LEARNING, GROWTH, FREQUENCIES) or (kind is not None and found != kind):
            raise UserError(f"{path}: is not a {kind or 'result'} file (format {found!r}); {remedy}")
        if not intact:
            raise UserError(f"{path}: damaged (its content does not match its checksum); {remedy}")
        yield file


def _first_line(error: Exception) -> str:
    return (str(error) or type(error).__name__).splitlines()[0]
