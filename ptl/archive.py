"""HDF5 files of plain arrays with their origin and a checksum: raw data of the side studies.

The files of learning, growth and survey jobs have a room of their own (`ptl.store`); the rules are the same
here: equal runs give equal bytes, a file holds what is needed to rerun it, and ``content`` is a sha256 over
all the rest.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np

import ptl
from ptl.errors import UserError
from ptl.files import atomic_path
from ptl.store import content_digest


def write_arrays(path: str | Path, kind: str, arrays: Mapping[str, np.ndarray], origin: Mapping[str, Any]) -> None:
    """Write arrays by name (slashes make groups).

    Parameters
    ----------
    kind : str
        Value of the root attribute ``format``.
    arrays : mapping
        Numbers or fixed-length byte strings; they are compressed.
    origin : mapping
        Other root attributes; dictionaries and lists are written as JSON.
    """
    versions = {"ptl": ptl.__version__, "numpy": np.__version__, "h5py": h5py.__version__}
    with atomic_path(path) as temporary, h5py.File(temporary, "w", libver="v110") as file:
        file.attrs["format"] = kind
        for name, value in ({**origin, "versions": versions}).items():
            file.attrs[name] = json.dumps(value, sort_keys=True) if isinstance(value, dict | list) else value
        for name, values in arrays.items():
            options = {"compression": "gzip", "shuffle": True} if np.size(values) else {}
            file.create_dataset(name, data=values, track_times=False, **options)
        file.attrs["content"] = content_digest(file)


def read_arrays(path: str | Path, kind: str) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """Arrays by name and the root attributes of a file that `write_arrays` wrote.

    Raises
    ------
    UserError
        When the file is missing, damaged or of another kind.
    """
    path = Path(path)
    remedy = f"remove it and run 'snakemake {path}' to make it again"
    if not path.is_file():
        raise UserError(f"{path}: no such file; run 'snakemake {path}' to make it")
    try:
        with h5py.File(path, "r") as file:
            intact = file.attrs.get("content") == content_digest(file)
            origin = dict(file.attrs)
            arrays: dict[str, np.ndarray] = {}
            file.visititems(
                lambda name, item: arrays.update({name: item[()]}) if isinstance(item, h5py.Dataset) else None
            )
    except Exception as error:  # HDF5 reports damage by exceptions of many types
        reason = (str(error) or type(error).__name__).splitlines()[0]
        raise UserError(f"{path}: damaged or not an HDF5 file ({reason}); {remedy}") from error
    if origin.get("format") != kind:
        raise UserError(f"{path}: is not a {kind} file (format {origin.get('format')!r}); {remedy}")
    if not intact:
        raise UserError(f"{path}: damaged (its content does not match its checksum); {remedy}")
    return arrays, origin
