"""Learn one setting of the study, all environments, methods and seeds in one process, to one raw file."""

from __future__ import annotations

import sys
import traceback
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ptl.config import Parameters
from ptl.errors import printable
from ptl.files.arrays import read_arrays, write_arrays
from ptl.files.invariants import COMPLETE
from ptl.files.provenance import code_digest
from ptl.files.schema import LONGEST_TEXT, SETTING
from ptl.learning.lives import grow_lives, learn_lives
from ptl.world.drawing import changed_world
from ptl.world.gridworld import GridWorld, load_map

STREAM = "robustness"
"""First name of every random stream of the study, followed by the setting's."""


@dataclass
class _Raw:
    """Results of a setting: arrays by name, and remarks on unfinished parts."""

    arrays: dict[str, np.ndarray] = field(default_factory=dict)
    remarks: list[str] = field(default_factory=list)
    worlds: dict[str, GridWorld] = field(default_factory=dict)


def run_setting(job: Mapping[str, Any], output: str | Path) -> None:
    """Learn one setting and write its raw file.

    A method that takes more than ``step_budget`` steps in one environment is given up there: the seeds that it
    finished are kept, and the file's attribute ``status`` says so. So does it when something fails; the traceback
    goes to stderr.

    Parameters
    ----------
    job : mapping
        As `studies.robustness.design.job_of` makes it.
    output : path
        HDF5 file: ``/<environment>/<method>/`` with ``seeds`` (seeds,), ``steps`` (seeds, tasks, episodes),
        ``truncated`` (seeds, tasks) and, where a library is kept, the fields of `ptl.learning.discoveries.Found`
        (seeds, tasks); ``/growth/library_size`` (runs, tasks + 1).
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
        if job["growth"]["runs"]:
            _grow(raw, job, parameters)
    except Exception as error:  # a setting that fails is a result of the study, not the end of it
        traceback.print_exc(file=sys.stderr)
        raw.remarks.append(f"failed: {type(error).__name__}: {str(error).splitlines()[0] if str(error) else ''}")
    origin = {
        "setting": job["setting"],
        "root_seed": job["root_seed"],
        "job": dict(job),
        "maps": {name: world.text for name, world in raw.worlds.items()},
        "status": printable("; ".join(raw.remarks))[:LONGEST_TEXT] or COMPLETE,
        "code": code_digest("studies.robustness.running", *[f"ptl.methods.{method}" for method in job["methods"]]),
    }
    write_arrays(output, SETTING, raw.arrays, origin)


def _learn(
    raw: _Raw, job: Mapping[str, Any], environment: str, letters: str, method: str, parameters: Parameters
) -> None:
    names = (STREAM, job["setting"], environment)
    arrays = learn_lives(
        raw.worlds[environment],
        letters,
        method,
        parameters,
        job["root_seed"],
        range(job["seeds"]),
        *names,
        budget=job["step_budget"],
    )
    finished = len(arrays["seeds"])
    if finished < job["seeds"]:
        raw.remarks.append(
            f"{environment}, {method}: given up after {finished} of {job['seeds']} seeds and"
            f" {arrays['steps'].sum()} steps"
        )
    raw.arrays.update({f"{environment}/{method}/{name}": array for name, array in arrays.items()})


def _grow(raw: _Raw, job: Mapping[str, Any], parameters: Parameters) -> None:
    environment, tasks = job["growth"]["environment"], job["growth"]["tasks"]
    runs, names = range(job["growth"]["runs"]), (STREAM, job["setting"])
    raw.arrays["growth/library_size"] = grow_lives(
        raw.worlds[environment], environment, tasks, parameters, job["root_seed"], runs, *names
    )


def read_setting(path: str | Path) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """Read the arrays by name and the attributes of a raw file, if they fit each other.

    Raises
    ------
    UserError
        If the file cannot be read, or does not hold what its job says.
    """
    return read_arrays(path, SETTING)
