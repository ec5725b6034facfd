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

GREY_LEVELS = 2
"""Largest difference of a colour channel (0 to 255) at which two pixels count as equal (our choice).

Processors round differently, and that can move an antialiased pixel by a level.
"""


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


def differences(folder: Path, manifest_path: Path) -> list[str]:
    """Compare the products in a report folder with another run; return a line for each that differs or is missing.

    Files must be equal byte for byte. A PNG may differ from the one beside the manifest by `GREY_LEVELS`.

    Parameters
    ----------
    folder : path
        Report folder.
    manifest_path : path
        Manifest of the other run.
    """
    found = []
    for name, digest in read(manifest_path)["products"].items():
        path = folder / name
        if not path.is_file():
            found.append(f"{path}: is missing; run '{rebuild_command(path)}' to make it")
        elif sha256(path) != digest and not looks_like(path, manifest_path.parent / name):
            found.append(f"{path}: differs from {manifest_path}")
    return found


def looks_like(path: Path, other: Path) -> bool:
    """Return whether two files are PNGs of one size whose pixels differ by at most `GREY_LEVELS`."""
    import numpy as np
    from PIL import Image

    if {path.suffix, other.suffix} != {".png"}:
        return False
    try:
        with Image.open(path) as ours, Image.open(other) as theirs:
            pixels, others = (np.asarray(image.convert("RGBA"), dtype=int) for image in (ours, theirs))
    except (OSError, SyntaxError, ValueError):  # missing, or damaged
        return False
    return pixels.shape == others.shape and int(np.abs(pixels - others).max()) <= GREY_LEVELS


def read(manifest_path: Path) -> dict[str, Any]:
    """Read a manifest and check its own checksum.

    Raises
    ------
    UserError
        If it is missing, damaged or something else; the line ends with the command that makes it again.
    """
    try:
        manifest = json.loads(manifest_path.read_text(encoding="utf-8"))
        intact = manifest["content"] == _content(manifest) and "products" in manifest
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "not the JSON that 'snakemake' writes"
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
