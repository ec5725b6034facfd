"""Files of plain arrays with their origin: steps per episode of a run, and raw data of the side studies."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from ptl.files.hdf5 import new_file, open_file


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
    with new_file(path, kind, origin) as file:
        for name, values in arrays.items():
            options = {"compression": "gzip", "shuffle": True} if np.size(values) else {}
            file.create_dataset(name, data=values, track_times=False, **options)


def read_arrays(path: str | Path, kind: str) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """Read the arrays by name and the root attributes of a file that `write_arrays` wrote.

    Raises
    ------
    UserError
        When the file is missing, damaged or of another kind.
    """
    arrays: dict[str, np.ndarray] = {}

    def collect(name: str, item: h5py.Group | h5py.Dataset) -> None:
        if isinstance(item, h5py.Dataset):
            arrays[name] = item[()]

    with open_file(path, kind) as file:
        file.visititems(collect)
        return arrays, dict(file.attrs)
