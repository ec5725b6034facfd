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

PACKAGES = ("ptl", "numpy", "scipy", "pandas", "matplotlib", "h5py", "snakemake")

TIMED = ("selection_cost", "library_cost", "claims", "claims_parts", "benchmark", "scaling")
"""Stems of the products that hold measured times: they differ from run to run and are not compared.

The claims hold one: the time of a skill selection.
"""


def build(products: Iterable[Path], folder: Path, config: Mapping[str, Any]) -> dict[str, Any]:
    """Manifest of the products below a run's report folder.

    Returns
    -------
    dict
        ``config``, ``versions``, and ``products``: sha256 by path relative to ``folder``.
    """
    return {
        "config": dict(config),
        "versions": {"python": platform.python_version(), **{name: version(name) for name in PACKAGES}},
        "products": {path.relative_to(folder).as_posix(): sha256(path) for path in sorted(products)},
    }


def differences(folder: Path, manifest_path: Path) -> list[str]:
    """How the products in ``folder`` differ from a manifest, one line each; measured times are left out."""
    try:
        products = json.loads(manifest_path.read_text(encoding="utf-8"))["products"]
    except (OSError, ValueError, KeyError, TypeError) as error:
        advice = "'snakemake' writes one with every run"
        raise UserError(f"{manifest_path}: is not a manifest ({error}); {advice}") from error
    found = []
    for name, digest in products.items():
        if Path(name).stem in TIMED:
            continue
        path = folder / name
        if not path.is_file():
            found.append(f"{path}: is missing; run 'snakemake' to make it")
        elif sha256(path) != digest:
            found.append(f"{path}: differs from {manifest_path}")
    return found


def sha256(path: Path) -> str:
    """Hex sha256 of a file."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
