"""The manifest of a run: a checksum for each product, so that anyone can hold their rerun against ours."""

from __future__ import annotations

import hashlib
import json
import platform
from collections.abc import Iterable, Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

from ptl.errors import UserError
from ptl.remedies import make_again, rebuild_command

MANIFEST = "manifest.json"
"""Name of the manifest in a report folder."""

PACKAGES = ("ptl", "numpy", "scipy", "pandas", "matplotlib", "h5py", "snakemake")

TIMED = ("selection_cost", "library_cost", "benchmark", "scaling")
"""Stems of the products that hold measured times: they differ from run to run and are not compared."""

TIMED_LINE = b"selection-cost"
"""Stands in each line of other products that holds measured times: those of the claim of this name."""


def build(products: Iterable[Path], folder: Path, config: Mapping[str, Any]) -> dict[str, Any]:
    """Manifest of the products below a run's report folder.

    Returns
    -------
    dict
        ``config``, ``versions``, ``products``: sha256 by path relative to ``folder``; ``untimed``: for products of
        which some lines hold measured times, sha256 over the others; ``content``: sha256 over all the rest.
    """
    paths = {path.relative_to(folder).as_posix(): path for path in sorted(products)}
    manifest = {
        "config": dict(config),
        "versions": {"python": platform.python_version(), **{name: version(name) for name in PACKAGES}},
        "products": {name: sha256(path) for name, path in paths.items()},
        "untimed": {name: _sha256_untimed(path) for name, path in paths.items() if _holds_times(path)},
    }
    return {**manifest, "content": _content(manifest)}


def _holds_times(path: Path) -> bool:
    return path.suffix in {".csv", ".md", ".html"} and TIMED_LINE in path.read_bytes()


def _sha256_untimed(path: Path) -> str:
    lines = path.read_bytes().splitlines(keepends=True)
    return hashlib.sha256(b"".join(line for line in lines if TIMED_LINE not in line)).hexdigest()


def _content(manifest: Mapping[str, Any]) -> str:
    """sha256 over all of a manifest but its own checksum."""
    rest = {name: value for name, value in manifest.items() if name != "content"}
    return hashlib.sha256(json.dumps(rest, sort_keys=True).encode()).hexdigest()


def damages(folder: Path) -> list[str]:
    """Products in a report folder that differ from the folder's own manifest, one line each with the remedy.

    Products with measured times are compared as well: this manifest was written right after them.
    """
    manifest_path = folder / MANIFEST
    found = []
    for name, digest in read(manifest_path)["products"].items():
        path = folder / name
        if not path.is_file():
            found.append(f"{path}: is missing; run '{rebuild_command(manifest_path)}' to make it")
        elif sha256(path) != digest:
            advice = f"remove it and run '{rebuild_command(manifest_path)}' to make both again"
            found.append(f"{path}: differs from {MANIFEST}; {advice}")
    return found


def differences(folder: Path, manifest_path: Path) -> list[str]:
    """How the products in ``folder`` differ from a manifest, one line each; measured times are left out."""
    manifest = read(manifest_path)
    found = []
    for name, digest in manifest["products"].items():
        if Path(name).stem in TIMED:
            continue
        path = folder / name
        if not path.is_file():
            found.append(f"{path}: is missing; run '{rebuild_command(path)}' to make it")
            continue
        untimed = manifest["untimed"].get(name)
        if (sha256(path) != digest) if untimed is None else (_sha256_untimed(path) != untimed):
            found.append(f"{path}: differs from {manifest_path}")
    return found


def read(manifest_path: Path) -> dict[str, Any]:
    """A manifest, after its own checksum has been checked.

    Raises
    ------
    UserError
        If it is missing, damaged or something else; the line ends with the command that makes it again.
    """
    try:
        manifest = json.loads(manifest_path.read_text(encoding="utf-8"))
        intact = manifest["content"] == _content(manifest) and {"products", "untimed"} <= set(manifest)
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "not the JSON that 'snakemake' writes"
        raise UserError(f"{manifest_path}: is not a manifest ({reason}); {make_again(manifest_path)}") from error
    if not intact:
        raise UserError(
            f"{manifest_path}: damaged (its content does not match its checksum); {make_again(manifest_path)}"
        )
    return manifest


def sha256(path: Path) -> str:
    """Hex sha256 of a file."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
