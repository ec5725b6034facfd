"""Files of plain arrays with their origin: steps per episode of a run, and raw data of the side studies."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ptl.files.hdf5 import Node, new_file
from ptl.files.results import read_whole


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
    """Read the arrays by name and the root attributes (JSON decoded) of a file that `write_arrays` wrote.

    Raises
    ------
    UserError
        If the file is missing, damaged or of another kind, does not fit the declaration of its kind, or is impossible.
    """
    root = read_whole(path, kind)
    assert isinstance(root, Node)  # kinds of plain arrays have no view of their own
    return dict(_arrays(root, "")), root.attrs


def _arrays(node: Node, where: str) -> Iterator[tuple[str, np.ndarray]]:
    for name, item in node.items():
        if isinstance(item, Node):
            yield from _arrays(item, f"{where}{name}/")
        else:
            yield f"{where}{name}", item
