"""The manifest of a run: a checksum of each product, with which a rerun can be compared."""

from __future__ import annotations

import hashlib
import json
import platform
import re
from collections.abc import Iterable, Mapping
from importlib.metadata import version
from pathlib import Path, PurePosixPath
from typing import Any

from ptl.errors import UserError
from ptl.files.regular import NotReadable, read_bytes, sha256
from ptl.files.remedies import make, make_again
from ptl.files.schema import Misfit, parse_json

MANIFEST = "manifest.json"
"""Name of the manifest in a report folder."""

MADE = "made.json"
"""Copy of it that a run leaves in results/<run>/, where nothing is checked out."""

PACKAGES = ("ptl", "numpy", "scipy", "pandas", "matplotlib", "h5py", "snakemake")

MOST_BYTES = 2**24
"""Most bytes of a manifest."""

PARTS = {"config": dict, "versions": dict, "products": dict, "content": str}
LATER = {"maps": dict}
"""Part that manifests of version 1.0 do not have."""

DIGEST = re.compile("[0-9a-f]{64}")


def build(products: Iterable[Path], folder: Path, config: Mapping[str, Any], maps: Mapping[str, str]) -> dict[str, Any]:
    """Make the manifest of the products below a run's report folder.

    Parameters
    ----------
    maps : mapping
        Digest of the map of each environment and side study.

    Returns
    -------
    dict
        ``config``, ``maps``, ``versions``, ``products`` (sha256 by path relative to ``folder``) and ``content`` (sha256
        over the rest).
    """
    manifest = {
        "config": dict(config),
        "maps": dict(maps),
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
        try:
            if sha256(path) != digest:
                found.append(f"{path}: differs from {MANIFEST}; {make_again(path)}")
        except NotReadable as error:
            if error.missing:
                found.append(f"{path}: is missing; {make(path)}")
            else:
                found.append(f"{path}: cannot be read ({error.reason}); {make_again(path)}")
    return found


def read(manifest_path: Path) -> dict[str, Any]:
    """Read a manifest and check its own checksum.

    Raises
    ------
    UserError
        If it is missing, damaged or something else; the line ends with the command that makes it again.
    """
    try:
        text = read_bytes(manifest_path, MOST_BYTES).decode("utf-8")
    except NotReadable as error:
        advice = make(manifest_path) if error.missing else make_again(manifest_path)
        raise UserError(f"{manifest_path}: is not a manifest ({error.reason}); {advice}") from error
    except UnicodeDecodeError as error:
        raise UserError(f"{manifest_path}: is not a manifest (not UTF-8); {make_again(manifest_path)}") from error
    return parse(text, manifest_path)


def parse(text: str, manifest_path: Path) -> dict[str, Any]:
    """Return the manifest that a text holds, as `read` does; the path is for the message."""
    try:
        manifest = parse_json(text)
        _check(manifest)
    except Misfit as error:
        raise UserError(f"{manifest_path}: is not a manifest ({error}); {make_again(manifest_path)}") from error
    if manifest["content"] != _content(manifest):
        raise UserError(
            f"{manifest_path}: damaged (its content does not match its checksum); {make_again(manifest_path)}"
        )
    return manifest


def _check(manifest: Any) -> None:
    """Refuse what the workflow never writes, above all names of products that lead out of the report folder."""
    if not isinstance(manifest, dict) or not set(PARTS) <= set(manifest) <= {*PARTS, *LATER}:
        raise Misfit(f"must have the keys {', '.join(PARTS)}")
    for name, kind in {**PARTS, **LATER}.items():
        if name in manifest and not isinstance(manifest[name], kind):
            raise Misfit(f"the key {name} must have a value of the type {kind.__name__}")
    for name, digest in manifest.get("maps", {}).items():
        if not isinstance(digest, str):
            raise Misfit(f"the map {name!r} has no digest")
    products = manifest["products"]
    if not products:
        raise Misfit("names no product")
    for name, digest in products.items():
        if name in {"", "."} or name != PurePosixPath(name).as_posix() or {"/", ".."} & {*PurePosixPath(name).parts}:
            raise Misfit(f"{name!r} is no path below the report folder")
        if not isinstance(digest, str) or not DIGEST.fullmatch(digest):
            raise Misfit(f"{name!r} has no sha256")
