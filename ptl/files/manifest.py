"""The manifest of a run: its configuration, the versions of packages, and a checksum of each product."""

from __future__ import annotations

import json
import platform
from collections.abc import Iterable, Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

import msgspec

import ptl
from ptl.errors import UserError
from ptl.files.regular import NotReadable, read_bytes, sha256

MANIFEST = "manifest.json"
"""Name of the manifest in a report folder."""

PACKAGES = ("numpy", "scipy", "pandas", "matplotlib", "h5py", "snakemake")
MAX_BYTES = 2**24
"""Maximum size of a manifest."""

AGAIN = "remove it and run the workflow again"


class Manifest(msgspec.Struct, frozen=True):
    """Contents of the manifest of a report folder.

    Attributes
    ----------
    config : dict
        The completed configuration of the run.
    maps : dict of str to str
        Digest of the map of each environment.
    versions : dict of str to str
        Versions of Python and of the packages behind the numbers.
    products : dict of str to str
        Hex sha256 by path below the folder.
    """

    config: dict[str, Any]
    maps: dict[str, str]
    versions: dict[str, str]
    products: dict[str, str]


def build(products: Iterable[Path], folder: Path, config: Mapping[str, Any], maps: Mapping[str, str]) -> Manifest:
    """Make the manifest of products below a report folder."""
    return Manifest(
        config=dict(config),
        maps=dict(maps),
        versions={
            "python": platform.python_version(),
            "ptl": ptl.__version__,
            **{name: version(name) for name in PACKAGES},
        },
        products={path.relative_to(folder).as_posix(): sha256(path) for path in sorted(products)},
    )


def to_json(manifest: Manifest) -> str:
    """Return a manifest as it is written."""
    return json.dumps(msgspec.to_builtins(manifest), indent=1, sort_keys=True) + "\n"


def read(path: Path) -> Manifest:
    """Read a manifest.

    Raises
    ------
    UserError
        If it is missing, damaged or not a manifest.
    """
    try:
        return parse(read_bytes(path, MAX_BYTES), path)
    except NotReadable as error:
        remedy = "run the workflow to make it" if error.missing else AGAIN
        raise UserError(f"{path}: is not a manifest ({error.reason}); {remedy}") from error


def parse(content: bytes, path: Path) -> Manifest:
    """Return the manifest with this content; errors as in `read`, the path is for the message."""
    try:
        manifest = msgspec.json.decode(content, type=Manifest)
    except (msgspec.MsgspecError, UnicodeDecodeError, RecursionError) as error:
        raise UserError(f"{path}: is not a manifest ({error}); {AGAIN}") from error
    for name in manifest.products:
        if Path(name).is_absolute() or ".." in Path(name).parts:
            raise UserError(f"{path}: names {name!r}, which is not below its folder; {AGAIN}")
    return manifest


def products_in(folder: Path) -> dict[str, str]:
    """Return the products that the manifest in a report folder names, none if there is no manifest or it is damaged."""
    try:
        return read(folder / MANIFEST).products
    except UserError:
        return {}


def strangers(folder: Path) -> list[Path]:
    """Return the files beside products in the subfolders of a report folder that its manifest does not name.

    Other files in the folder itself are none of the run's: Snakemake's report, the benchmark.
    """
    named = {folder / name for name in products_in(folder)}
    places = {path.parent for path in named if path.parent.is_dir()} - {folder}
    return sorted(path for place in places for path in place.iterdir() if path.is_file() and path not in named)


def damages(folder: Path) -> list[str]:
    """Compare a report folder with its own manifest; return a line for each product that differs."""
    lines = []
    for name, digest in read(folder / MANIFEST).products.items():
        path = folder / name
        try:
            if sha256(path) != digest:
                lines.append(f"{path}: differs from {MANIFEST}; {AGAIN}")
        except NotReadable as error:
            lines.append(f"{path}: cannot be read ({error.reason}); run the workflow again")
    return lines
