"""Declared arrays of result files: type, shape, meaning and range of each, and the check of arrays against them.

A shape is given in sizes: ``n`` states of the map, ``e`` episodes of a task, ``t`` tasks. Other sizes are free, but
equal wherever they occur in a group. A number may follow, as in ``e+1``.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

Sizes = Mapping[str, int]
Size = str | int
Limit = int | float | str | None

PLACEHOLDER = re.compile(r"<\w+>")
NAME = r"[A-Za-z0-9_]{1,64}"


class Misfit(ValueError):
    """An array, or a group of arrays, does not fit its declaration."""


class Array(NamedTuple):
    """Declaration of an array.

    Attributes
    ----------
    dtype : str
        NumPy's name of the type; ``bytes`` is text of a fixed length.
    shape : tuple of str or int
    meaning : str
        For the documentation.
    low, high : number, str or None
        Range, ends included; a str is a size. Floats are finite.
    optional : bool
        Optional arrays of a group are either all present or all absent.
    """

    dtype: str
    shape: tuple[Size, ...]
    meaning: str
    low: Limit = None
    high: Limit = None
    optional: bool = False


def check(declared: Mapping[str, Array], arrays: Mapping[str, np.ndarray], known: Sizes) -> None:
    """Check arrays against their declarations.

    Parameters
    ----------
    declared : mapping
        Declarations by name. ``<task>/q`` declares an array ``q`` in each of some groups; each group is complete.
    arrays : mapping
        Arrays by name.
    known : mapping
        Sizes that are known beforehand.

    Raises
    ------
    Misfit
        Naming the first array that is missing, undeclared, or has another type, shape or range.
    """
    patterns = {name: re.compile(PLACEHOLDER.sub(NAME, name)) for name in declared}
    sizes: dict[str, dict[str, int]] = {}
    present: dict[str, set[str]] = {}
    for name, values in arrays.items():
        declaration = next((key for key, pattern in patterns.items() if pattern.fullmatch(name)), None)
        if declaration is None:
            raise Misfit(f"{name}: is not declared for this kind of file")
        group = name.rpartition("/")[0]
        present.setdefault(group, set()).add(declaration)
        _check_one(name, values, declared[declaration], sizes.setdefault(group, dict(known)))
    for group, members in present.items():
        _check_complete(group, members, declared)
    for name, array in declared.items():
        if not array.optional and "<" not in name and name not in arrays:
            raise Misfit(f"{name}: is missing")


def _check_complete(group: str, members: set[str], declared: Mapping[str, Array]) -> None:
    parent = next(iter(members)).rpartition("/")[0]
    some = any(declared[name].optional for name in members)
    for name, array in declared.items():
        if name.rpartition("/")[0] == parent and name not in members and (some or not array.optional):
            raise Misfit(f"{group}/{name.rpartition('/')[2]}".lstrip("/") + ": is missing")


def _check_one(name: str, values: np.ndarray, declared: Array, sizes: dict[str, int]) -> None:
    dtype = values.dtype
    if not (dtype.kind == "S" if declared.dtype == "bytes" else dtype == declared.dtype):
        raise Misfit(f"{name}: must be of the type {declared.dtype}, not {dtype}")
    if values.ndim != len(declared.shape) or not all(map(_bind, declared.shape, values.shape, [sizes] * values.ndim)):
        wanted = ", ".join(str(size_of(size, sizes)) for size in declared.shape)
        raise Misfit(f"{name}: has the shape {values.shape} where ({wanted}) is needed")
    if dtype.kind not in "iuf" or not values.size:
        return
    low, high = (size_of(limit, sizes) if isinstance(limit, str) else limit for limit in declared[3:5])
    least, greatest = values.min(), values.max()
    if not np.isfinite(least) or not np.isfinite(greatest):
        raise Misfit(f"{name}: has a value that is not finite")
    if (low is not None and least < low) or (high is not None and greatest > high):
        limits = f"{'' if low is None else low} to {'' if high is None else high}".strip()
        raise Misfit(f"{name}: has values from {least} to {greatest} where {limits} is allowed")


def _bind(declared: Size, actual: int, sizes: dict[str, int]) -> bool:
    """Return whether a size is as declared; a free size becomes known."""
    if isinstance(declared, str):
        name, change = _parts(declared)
        sizes.setdefault(name, actual - change)
        if sizes[name] < 0:
            return False
    return size_of(declared, sizes) == actual


def size_of(declared: Size, sizes: Sizes) -> int | str:
    """Return a size as a number, or its name if it is not known."""
    if isinstance(declared, int):
        return declared
    name, change = _parts(declared)
    return sizes[name] + change if name in sizes else declared


def _parts(declared: str) -> tuple[str, int]:
    name, change = re.fullmatch(r"(\w+?)([+-]\d+)?", declared).groups()  # type: ignore[union-attr]
    return name, int(change or 0)
