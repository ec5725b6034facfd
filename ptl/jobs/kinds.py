"""All kinds of jobs: those of the package and those of the studies."""

from __future__ import annotations

import os
from importlib import import_module
from types import ModuleType

import msgspec

import ptl.jobs  # noqa: F401 - registers its kinds
from ptl.files.job import KINDS, Job, Tagged, from_text, lines_of
from ptl.files.provenance import ROOT
from ptl.files.store import Result
from ptl.files.store import read as read_known


def job_from(text: str | bytes) -> Job:
    """Return the job that a text describes; errors as in `ptl.files.job.from_text`."""
    try:
        known = msgspec.json.decode(text, type=Tagged).kind in KINDS
    except msgspec.MsgspecError:
        known = True  # `from_text` reports the error
    if not known:
        register_studies()
    return from_text(text)


def read(path: str | os.PathLike[str]) -> Result:
    """Return what a result file of any kind holds; errors as in `ptl.files.store.read`."""
    register_studies()
    return read_known(path)


def unpacked(text: str) -> list[Job]:
    """Return the jobs of `ptl.files.job.packed`."""
    return [job_from(line) for line in lines_of(text)]


def register_studies() -> None:
    """Make the kinds of jobs of all studies known."""
    modules_of_studies("jobs")


def modules_of_studies(name: str) -> list[ModuleType]:
    """Import the module of this name of each study that has one."""
    paths = sorted((ROOT / "studies").glob(f"*/{name}.py"))
    return [import_module(f"studies.{path.parent.name}.{name}") for path in paths]
