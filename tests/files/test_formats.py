"""Declarations of arrays: every array that does not fit is refused with its name."""

from __future__ import annotations

import numpy as np
import pytest

from ptl.files.formats import Array, Misfit, check

DECLARED = {
    "total": Array("int64", (), "a number", 0),
    "<task>/q": Array("float64", ("n", 4), "values"),
    "<task>/steps": Array("int64", ("e",), "steps", 1, "n"),
    "<task>/limits": Array("int64", ("m+1",), "limits", 0, "m"),
    "<task>/drawn": Array("int32", ("m",), "draws", 0),
    "library/subgoals": Array("int32", ("k",), "subgoals", 0, "n-1", True),
    "library/names": Array("bytes", ("k",), "names", optional=True),
}
KNOWN = {"n": 5, "e": 3}


def good() -> dict[str, np.ndarray]:
    arrays = {
        "total": np.int64(4),
        "library/subgoals": np.array([0, 4], "int32"),
        "library/names": np.array([b"a", b"b"]),
    }
    for task in "AB":
        arrays |= {
            f"{task}/q": np.zeros((5, 4)),
            f"{task}/steps": np.array([1, 5, 5]),
            f"{task}/limits": np.array([0, 1, 2]),
            f"{task}/drawn": np.zeros(2, "int32"),
        }
    return {name: np.asarray(values) for name, values in arrays.items()}


def test_arrays_that_fit_are_accepted():
    check(DECLARED, good(), KNOWN)
    without = {name: values for name, values in good().items() if not name.startswith("library")}
    check(DECLARED, without, KNOWN)


@pytest.mark.parametrize(
    ("name", "values", "says"),
    [
        ("total", None, "^total: is missing"),
        ("A/q", None, "^A/q: is missing"),
        ("library/names", None, "^library/names: is missing"),
        ("B/colour", np.zeros(1), "^B/colour: is not declared"),
        ("total", np.float64(4), "must be of the type int64, not float64"),
        ("total", np.int64(-1), "from -1 to -1 where 0 to is allowed"),
        ("A/q", np.zeros((5, 3)), r"has the shape \(5, 3\) where \(5, 4\) is needed"),
        ("A/q", np.zeros(20), "has the shape"),
        ("A/q", np.full((5, 4), np.nan), "not finite"),
        ("B/steps", np.array([0, 1, 1]), "from 0 to 1 where 1 to 5"),
        ("B/limits", np.array([0, 1, 2, 2]), r"drawn: has the shape \(2,\) where \(3\) is needed"),
        ("B/limits", np.array([0, 1, 3]), "from 0 to 3 where 0 to 2"),
        ("library/subgoals", np.array([0, 5], "int32"), "where 0 to 4"),
        ("library/names", np.array([b"a"]), "shape"),
    ],
)
def test_an_array_that_does_not_fit_is_named(name, values, says):
    arrays = good()
    if values is None:
        del arrays[name]
    else:
        arrays[name] = np.asarray(values)
    with pytest.raises(Misfit, match=says):
        check(DECLARED, arrays, KNOWN)
