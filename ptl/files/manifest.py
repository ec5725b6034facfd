"""The manifest of a run: a checksum of each product, with which a rerun can be compared."""

from __future__ import annotations

import hashlib
import json
import platform
from collections.abc import Iterable, Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

from ptl.errors import UserError
from ptl.files.remedies import make_again, rebuild_command

MANIFEST = "manifest.json"
"""Name of the manifest in a report folder."""

PACKAGES = ("ptl", "numpy", "scipy", "pandas", "matplotlib", "h5py", "snakemake")


def build(products: Iterable[Path], folder: Path, config: Mapping[str, Any]) -> dict[str, Any]:
    """Make the manifest of the products below a run's report folder.

    Returns
    -------
    dict
        ``config``, ``versions``, ``products`` (sha256 by path relative to ``folder``) and ``content`` (sha256 over the
        rest).
    """
    manifest = {
        "config": dict(config),
        "versions": {"python": platform.python_version(), **{name: version(name) for name in PACKAGES}},
        "products": {path.relative_to(folder).as_posix(): sha256(path) for path in sorted(products)},
    }
    return {**manifest, "content": _content(manifest)}


def _content(manifest: Mapping[str, Any]) -> str:
    """Return the sha256 over all of a manifest but its own checksum."""
    rest = {name: value for name, value in manifest.items() if name != "content"}
    return hashlib.sha256(json.dumps(rest, sort_keys=True).encode()).hexdigest()


def damages(folder: Path) -> list[str]:
    """Compare a report folder with its own manifest; return a line with the remedy for each fault."""
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


def read(manifest_path: Path) -> dict[str, Any]:
    """Read a manifest and check its own checksum.

    Raises
    ------
    UserError
        If it is missing, damaged or something else; the line ends with the command that makes it again.
    """
    try:
        text = manifest_path.read_text(encoding="utf-8")
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else "not UTF-8"
        raise UserError(f"{manifest_path}: is not a manifest ({reason}); {make_again(manifest_path)}") from error
    return parse(text, manifest_path)


def parse(text: str, manifest_path: Path) -> dict[str, Any]:
    """Return the manifest that a text holds, as `read` does; the path is for the message."""
    try:
        manifest = json.loads(text)
        intact = manifest["content"] == _content(manifest) and "products" in manifest
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        reason = "not the JSON that 'snakemake' writes"
        raise UserError(f"{manifest_path}: is not a manifest ({reason}); {make_again(manifest_path)}") from error
    if not intact:
        raise UserError(
            f"{manifest_path}: damaged (its content does not match its checksum); {make_again(manifest_path)}"
        )
    return manifest


def sha256(path: Path) -> str:
    """Return the hex sha256 of a file."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
