"""Verification of the products of a run: integrity, location, possible content and the code that made them."""

from __future__ import annotations

import os
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

from ptl.errors import UserError
from ptl.files import regular
from ptl.files.atomic import UNFINISHED
from ptl.files.csv import broken_seal, seal_of
from ptl.files.hdf5 import Node, read_file
from ptl.files.manifest import MANIFEST, damages
from ptl.files.manifest import read as read_manifest
from ptl.files.outside import RECORD, learning_code
from ptl.files.provenance import code_digest
from ptl.files.remedies import make_again
from ptl.files.results import WITH_ORIGIN, LearningFile, ResultFile, read_result
from ptl.files.schema import FIT, FREQUENCIES, GAIN, GROWTH, LEARNING, LIVES, SETTING, STEPS
from ptl.methods import names
from ptl.methods.beyond import module_of

FOLDERS = (
    "learning", "growth", "subgoal_frequencies", "misleading_prior", "fernandez_veloso", "robustness", "decision",
    "lives",
)  # fmt: skip
"""Folders below results/<run>/ that hold files of one kind."""


ARCHIVES = (STEPS, GAIN, SETTING, FIT, LIVES)
"""Kinds of plain arrays."""

TEXTS = {".csv", ".md", ".html", ".tex", ".svg", ".png", ".rst", ".json", ".yaml", ".txt"}
"""Suffixes of files that are no HDF5 file even in name."""


def checkable(path: Path) -> list[Path]:
    """Return the files that `faults_of` can check: the file itself, or those below a folder.

    Those are HDF5 files, manifests and files that come with a checksum, in alphabetical order, behind symbolic links
    to folders too. A table that its checksum was lost of is still found by the manifest.
    """
    if not path.is_dir():
        return [path]
    files = set(regular.below(path))
    whole = {file for file in files if file.suffix == ".h5" or file.name == MANIFEST}
    sealed = {file for file in files if seal_of(file) in files}
    lost = {file.with_suffix("") for file in files if file.suffix == ".sha256"} - files
    return sorted(file for file in whole | sealed | lost if not file.name.startswith(UNFINISHED))


def unchecked(path: Path, checked: list[Path]) -> list[Path]:
    """Return the files below a folder that have no checksum anywhere; ``checked`` are those of `checkable`."""
    if not path.is_dir():
        return []
    vouched = set(checked) | {seal_of(file) for file in checked}
    for file in checked:
        if file.name == MANIFEST:
            vouched.update(file.parent / name for name in read_manifest(file)["products"])
    return sorted(set(regular.below(path)) - vouched)


def faults_of(path: Path, *, current_code: bool = True) -> list[str]:
    """Return the faults of a product, one line each with the remedy; empty if there is none.

    Parameters
    ----------
    path : Path
        An HDF5 file that the workflow made, a file with its checksum beside it, or a manifest: then everything
        that it names is held against it.
    current_code : bool
        Also demand that an HDF5 file was made by the code of this package.
    """
    try:
        if path.name == MANIFEST:
            return damages(path.parent)
        if path.suffix != ".h5" and seal_of(path).exists():
            broken = broken_seal(path, regular.read_bytes(path, regular.MOST_BYTES))
            found = [f"damaged (differs from its checksum in {seal_of(path).name})"] if broken else []
        elif path.suffix in TEXTS:
            return [f"{path}: has no checksum to hold it against; name its folder, or an HDF5 file"]
        else:
            found = _faults_of_result(path, current_code)
    except regular.NotReadable as error:
        found = [f"cannot be read ({error.reason})"]
    except UserError as error:
        return [str(error)]
    return [f"{path}: {fault}; {make_again(path)}" for fault in found]


def _faults_of_result(path: Path, current_code: bool) -> list[str]:
    file = read_file(path, *WITH_ORIGIN, *ARCHIVES)
    if file.attrs["format"] in ARCHIVES:
        return list(_foreign_archive(path, file, current_code))
    return list(_foreign(path, read_result(path), current_code))


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
        shared = {name: value for name, value in result.parameters.items() if name != RECORD}
        settings = {"root_seed": result.root_seed, **shared}
        first, expected = self._first.setdefault("settings", (path, settings))
        if settings != expected:
            differing = ", ".join(key for key in expected if settings.get(key) != expected[key]) or "parameters"
            raise UserError(f"{path}: was made with other settings ({differing}) than {first}; {make_again(path)}")
        world = {"map": result.file.attrs["map"]}
        first, expected = self._first.setdefault(f"map of {result.environment}", (path, world))
        if world != expected:
            raise UserError(f"{path}: was made on another map than {first}; {make_again(path)}")


def _foreign(path: Path, result: ResultFile, current_code: bool) -> Iterator[str]:
    yield from _misplaced(path, result)
    if not current_code:
        return
    method = str(result.file.attrs.get("method", ""))
    outside = result.parameters.get(RECORD)
    reference = str(outside["reference"]) if isinstance(outside, dict) and "reference" in outside else method
    if reference == method and method and method not in names():
        yield f"was made by the method {method}, which is not there"
    elif reference != method and not reference.endswith(".py"):
        pass  # nothing that a file names is imported
    elif reference != method and not Path(reference).is_file():
        yield f"was made by the method {reference}, which is not there"
    elif result.code != _present_code(result.format, reference):
        yield "was made by another version of the code"


@cache
def _present_code(kind: str, method: str) -> str:
    if kind == LEARNING:
        return learning_code(method)
    if kind == GROWTH:
        return code_digest("ptl.learning.growth", f"ptl.methods.{method}")
    return code_digest("ptl.learning.survey")


def _foreign_archive(path: Path, file: Node, current_code: bool) -> Iterator[str]:
    """Check place and code of the files of plain arrays."""
    kind = file.attrs["format"]
    if kind == STEPS:
        if path.name != "steps.h5":
            yield "holds the steps of a whole run, steps.h5"
        return
    if kind == LIVES:
        if not path.absolute().as_posix().endswith(f"/{file.attrs['place']}.h5"):
            yield f"holds the job {file.attrs['place']}"
        module = module_of(str(file.attrs["job"]["cell"].get("method")))
        if current_code and module and file.attrs["code"] != lives_code(module):  # another's method may have changed
            yield "was made by another version of the code"
        return
    name, modules = {
        GAIN: ("arm", ("ptl.study.policy_reuse_experiment", "ptl.methods.policy_reuse", "ptl.methods.no_transfer")),
        SETTING: ("setting", ()),
        FIT: ("setting", ()),
    }[kind]
    if path.stem != file.attrs[name]:
        yield f"holds the job {file.attrs[name]}"
    if kind == SETTING:
        methods = file.attrs["job"]["methods"]
        modules = ("ptl.study.robustness.running", *[f"ptl.methods.{method}" for method in methods])
    if kind == FIT:  # its name is a digest of everything that it was learned from, the code included
        return
    if current_code and file.attrs["code"] != code_digest(*modules):
        yield "was made by another version of the code"


def lives_code(*modules: str) -> str:
    """Return a digest of the sources that lives of the second study depend on, a method's own ones included."""
    return code_digest("ptl.study.population.running", *modules)


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
        expected_name = f"run_{result.file.attrs['seed']:03d}.h5"
        if parts[-1] != expected_name:
            yield f"holds the job {expected_name}"
    elif result.format == FREQUENCIES and "subgoal_frequencies" in folders:
        batch = result.file.attrs.get("batch")
        expected = (f"{result.environment}.h5",) if batch is None else (result.environment, f"batch_{batch}.h5")
        if parts[-len(expected) :] != expected:
            yield f"holds the frequencies {'/'.join(expected)}"
    elif parts[-1] == "steps.h5" or any(folder in folders for folder in FOLDERS):
        yield f"is of the kind {result.format}, which does not belong in this folder"
