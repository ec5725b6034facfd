"""Verification of the products of a run: integrity, location, possible content and the code that made them."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ptl.errors import UserError
from ptl.files import regular
from ptl.files.atomic import UNFINISHED
from ptl.files.csv import broken_seal, seal_of
from ptl.files.hdf5 import Node
from ptl.files.manifest import MADE, MANIFEST, damages
from ptl.files.manifest import read as read_manifest
from ptl.files.outside import RECORD
from ptl.files.question import code_faults, misplaced
from ptl.files.remedies import make_again
from ptl.files.results import ResultFile, read_whole

TEXTS = {".csv", ".md", ".html", ".tex", ".svg", ".png", ".rst", ".json", ".yaml", ".txt"}
"""Suffixes of files that are no HDF5 file even in name."""

SETTINGS = "robustness"
"""Folder of the robustness study in results/<run>/."""

REPORT = "report.html"
"""Snakemake's report, which no rule makes."""


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
    again = f"make it again with 'snakemake --report {path}'" if path.name == REPORT else make_again(path)
    return [f"{path}: {fault}; {again}" for fault in found]


def made_beside(path: Path) -> Path | None:
    """Return the copy of its manifest that the run of a result left above it, if it did.

    The settings of the robustness study have their own in their folder, if that study was made.
    """
    above = path.absolute().parents if path.parent.name != SETTINGS else path.absolute().parents[:1]
    return next((folder / MADE for folder in above if (folder / MADE).is_file()), None)


def _faults_of_result(path: Path, current_code: bool) -> list[str]:
    content = read_whole(path)
    root = content.file if isinstance(content, ResultFile) else content
    return list(_foreign(path, root, current_code))


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
        for fault in _foreign(path, result.file, current_code=True):
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


def _foreign(path: Path, root: Node, current_code: bool) -> Iterator[str]:
    yield from misplaced(path, root)
    if current_code:
        yield from code_faults(root)
