"""Cost of a skill library against its size: operations of one selection, counted, and bytes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd

from ptl.agent._selection import SkillSelection
from ptl.agent.selection import prior

SELECTION_COLUMNS, STORAGE_COLUMNS = ("skills", "operations"), ("states", "skills", "bytes")

SIZES = (1, 2, 5, 10, 20, 50, 100, 200, 350, 500, 700, 1000, 2000, 5000)
"""Numbers of skills for which a selection is counted."""

LAST_DRAWN = SimpleNamespace(random=lambda: np.nextafter(1.0, 0.0))
"""Source of a random number with which a draw looks at all skills, the costliest case."""

STORED_SIZES = (1, 3, 10, 30, 100)
"""Numbers of skills for which bytes are given."""


class Counter:
    """Number of elements that numpy has worked on."""

    def __init__(self) -> None:
        self.operations = 0

    def array(self, values: np.ndarray) -> CountedArray:
        """Return the values as an array whose use is counted here, as is that of all arrays computed from it."""
        counted = np.asarray(values).view(CountedArray)
        counted.counter = self
        return counted

    def visited(self, items: Iterable[int]) -> Iterator[int]:
        """Yield the items and count them."""
        for item in items:
            self.operations += 1
            yield item


class CountedArray(np.ndarray):
    """An array that counts an operation for every element that a function of numpy goes through.

    A sum of k numbers counts k, an outer product of k by k numbers k squared, and a binary search its comparisons.
    """

    counter: Counter

    def __array_finalize__(self, source: Any) -> None:
        if isinstance(source, CountedArray):
            self.counter = source.counter

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **options: Any) -> Any:
        plain = [np.asarray(item) for item in inputs]
        result = getattr(ufunc, method)(*plain, **options)
        self._count(max(np.size(item) for item in (*plain, result)))
        return self._counted(result)

    def __array_function__(self, function: Any, types: Any, arguments: Any, options: Any) -> Any:
        before = self.counter.operations
        result = super().__array_function__(function, types, arguments, options)
        if function is np.searchsorted:
            self._count(len(arguments[0]).bit_length() * np.size(arguments[1]))
        elif function is np.where:
            self._count(np.size(result))
        elif self.counter.operations == before and function not in (np.shape, np.size, np.ndim):
            raise TypeError(f"operations of numpy.{function.__name__} cannot be counted")
        return self._counted(result)

    def __getitem__(self, index: Any) -> Any:
        result = super().__getitem__(index)
        self._count(np.size(result))
        return result

    def _count(self, operations: int) -> None:
        self.counter.operations += operations

    def _counted(self, result: Any) -> Any:
        return self.counter.array(result) if isinstance(result, np.ndarray) else result


def selection_operations(sizes: Iterable[int] = SIZES, seed: int = 0) -> pd.DataFrame:
    """Count the operations of one skill selection for libraries of several sizes.

    A selection is the prior for a goal, as `ptl.agent.selection` computes it, then the weighting by the likelihood
    after an episode and the draw, as `ptl.agent._selection.SkillSelection` does.

    Returns
    -------
    DataFrame
        Columns `SELECTION_COLUMNS`; operations are elements that numpy's functions go through in the prior, and skills
        that the compiled loops look at in the draw, which is the costliest possible.
    """
    random = np.random.default_rng(seed)
    rows = []
    for size in sizes:
        counter = Counter()
        cells = counter.array(random.integers(0, 1000, size=(size, 2)))
        selection = SkillSelection(prior(cells, counter.visited(range(size)), 0, 1000.0))
        selection.record([0], 100)
        selection.draw(LAST_DRAWN)
        rows.append((size, counter.operations + selection.visits))
    return pd.DataFrame(rows, columns=list(SELECTION_COLUMNS))


def library_bytes(states: Iterable[int], skills: Iterable[int] = STORED_SIZES) -> pd.DataFrame:
    """Return the bytes of libraries as stored: one byte per state and skill, and four per subgoal.

    Returns
    -------
    DataFrame
        Columns `STORAGE_COLUMNS`.
    """
    rows = [
        (n, k, np.empty((k, n), dtype=np.int8).nbytes + np.empty(k, dtype=np.int32).nbytes)
        for n in states
        for k in skills
    ]
    return pd.DataFrame(rows, columns=list(STORAGE_COLUMNS))
