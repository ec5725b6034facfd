"""Learns one setting of the study, all environments, methods and seeds in one process, to one raw file."""

from __future__ import annotations

import sys
import traceback
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ptl import seeding
from ptl.archive import read_arrays, write_arrays
from ptl.gridworld import GridWorld, load_map
from ptl.growth import METHOD as GROWTH_METHOD
from ptl.growth import random_tasks
from ptl.learning import Life, learn_life, tasks_of
from ptl.parameters import Parameters
from ptl.provenance import code_digest
from ptl.robustness.worlds import changed_world

FORMAT = "ptl-robustness/1"

STREAM = "robustness"
"""First name of every random stream of the study; the setting's name after it makes them its own."""

COMPLETE = "complete"


@dataclass
class _Raw:
    """What a setting leaves: arrays by name, and remarks on what was not finished."""

    arrays: dict[str, np.ndarray] = field(default_factory=dict)
    remarks: list[str] = field(default_factory=list)
    worlds: dict[str, GridWorld] = field(default_factory=dict)


def run_setting(job: Mapping[str, Any], output: str | Path) -> None:
    """Learn one setting and write its raw file.

    A method that takes more than ``step_budget`` steps in one environment is given up there: the seeds that
    it finished are kept, and the file's attribute ``status`` says so. So does it when something fails; the
    traceback goes to stderr.

    Parameters
    ----------
    job : mapping
        As `ptl.robustness.design.job_of` makes it.
    output : path
        HDF5 file: ``/<environment>/<method>/`` with ``seeds`` (seeds,), ``steps`` (seeds, tasks, episodes),
        ``truncated`` (seeds, tasks) and, where a library is kept, what was discovered after each task;
        ``/growth/``.
    """
    raw = _Raw()
    try:
        parameters = Parameters.from_dict(job["parameters"])
        raw.worlds = {
            name: changed_world(load_map(entry["map"]), entry["changes"]) for name, entry in job["environments"].items()
        }
        for name, entry in job["environments"].items():
            for method in job["methods"]:
                _learn(raw, job, name, entry["tasks"], method, parameters)
        _grow(raw, job, parameters)
    except Exception as error:  # a setting that fails is a result of the study, not the end of it
        traceback.print_exc(file=sys.stderr)
        raw.remarks.append(f"failed: {type(error).__name__}: {str(error).splitlines()[0] if str(error) else ''}")
    origin = {
        "setting": job["setting"],
        "root_seed": job["root_seed"],
        "job": dict(job),
        "maps": {name: world.text for name, world in raw.worlds.items()},
        "status": "; ".join(raw.remarks) or COMPLETE,
        "code": code_digest("ptl.robustness.running", *[f"ptl.methods.{method}" for method in job["methods"]]),
    }
    write_arrays(output, FORMAT, raw.arrays, origin)


def _learn(
    raw: _Raw, job: Mapping[str, Any], environment: str, letters: str, method: str, parameters: Parameters
) -> None:
    world = raw.worlds[environment]
    tasks = tasks_of(world, letters)
    lives: list[Life] = []
    taken = 0
    for seed in range(job["seeds"]):
        if taken > job["step_budget"]:
            raw.remarks.append(
                f"{environment}, {method}: given up after {seed} of {job['seeds']} seeds and {taken} steps"
            )
            break
        names = (STREAM, job["setting"], environment, seed)
        lives.append(learn_life(world, tasks, method, parameters, job["root_seed"], *names))
        taken += int(sum(record.steps.sum() for record in lives[-1].records))
    raw.arrays.update({f"{environment}/{method}/{name}": array for name, array in _arrays(lives)})


def _arrays(lives: list[Life]) -> Iterator[tuple[str, np.ndarray]]:
    yield "seeds", np.arange(len(lives), dtype=np.int64)
    yield "steps", np.array([[record.steps for record in life.records] for life in lives], dtype=np.int64)
    yield (
        "truncated",
        np.array(
            [[np.count_nonzero(record.truncated) for record in life.records] for life in lives],
            dtype=np.int64,
        ),
    )
    if lives[0].library is not None:
        yield (
            "subgoal",
            np.array([[r.update.subgoal for r in life.records] for life in lives], dtype=np.int32),
        )
        yield "reason", np.array([[r.update.reason.encode() for r in life.records] for life in lives])
        yield "novelty", np.array([[r.discovery.novelty for r in life.records] for life in lives])
        for kind in ("incremental", "original"):
            metrics = [[getattr(r.discovery, kind).product for r in life.records] for life in lives]
            yield f"{kind}_peak", np.array([[peak(m) for m in row] for row in metrics], dtype=np.int32)
            yield f"{kind}_value", np.array([[m.max() for m in row] for row in metrics])


def peak(metric: np.ndarray) -> int:
    """State where a metric is greatest, the first of several; -1 if it is 0 everywhere."""
    return int(metric.argmax()) if metric.any() else -1


def _grow(raw: _Raw, job: Mapping[str, Any], parameters: Parameters) -> None:
    environment = job["growth"]["environment"]
    world = raw.worlds[environment]
    sizes = []
    for run in range(job["growth"]["runs"]):
        names = (STREAM, job["setting"], "growth", environment, run)
        tasks = random_tasks(world, job["growth"]["tasks"], seeding.generator(job["root_seed"], *names, "tasks"))
        life = learn_life(world, tasks, GROWTH_METHOD, parameters, job["root_seed"], *names)
        sizes.append(np.concatenate([[0], np.cumsum([record.update.subgoal >= 0 for record in life.records])]))
    raw.arrays["growth/library_size"] = np.array(sizes, dtype=np.int64)


def read_setting(path: str | Path) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """Arrays by name and attributes of a raw file (``job`` and ``maps`` decoded)."""
    import json

    arrays, origin = read_arrays(path, FORMAT)
    return arrays, {**origin, "job": json.loads(origin["job"]), "maps": json.loads(origin["maps"])}
