"""Reader of the file of steps per episode of a whole run."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from ptl.errors import UserError
from ptl.files.hdf5 import Node, read_file
from ptl.files.schema import STEPS


class StepsFile:
    """Steps per episode of every environment, method and task: ``/<environment>/<method>/<task>``."""

    def __init__(self, path: Path, file: Node) -> None:
        self.path = path
        self._file = file

    @property
    def environments(self) -> list[str]:
        """Names of the environments."""
        return list(self._file)

    def has(self, environment: str, method: str) -> bool:
        """Return whether a method was run in an environment."""
        return method in self._file.get(environment, {})

    def steps(self, environment: str, method: str, task: str) -> np.ndarray:
        """Return the steps per episode, int64 array (seeds, episodes)."""
        place: Any = self._file
        for kind, name in (("environment", environment), ("method", method), ("task", task)):
            if name not in place:
                known = ", ".join(place)
                raise UserError(f"{self.path}: no {kind} {name!r} (there are: {known}); learn it or name another")
            place = place[name]
        return place


@contextmanager
def open_steps(path: str | Path) -> Iterator[StepsFile]:
    """Open a file of steps for reading."""
    yield StepsFile(Path(path), read_file(path, STEPS))
