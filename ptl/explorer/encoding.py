"""How arrays are packed into the page: varints and little-endian bytes, as base64 text.

The scripts unpack them in ``web/decode.js``. Only what the functions name is lost. The page is kept small,
because Chromium shows it inside the report only up to 1.5 MB (2 MiB as a data address).
"""

from __future__ import annotations

import base64
from collections.abc import Iterable

import numpy as np

SHARE_STEPS = 65535
"""Numbers in [0, 1] are kept in 1 / 65535, so within 7.7e-6."""


def logarithms(values: np.ndarray) -> str:
    """Values >= 0: where they are not 0, and there their natural logarithms as float32 (see `_sparse`).

    Values of far states lie below the least float32, their logarithms do not: down to 1e-308 a value comes
    back with a relative error below 4e-5.
    """
    values = np.asarray(values, dtype=np.float64).ravel()
    return _sparse(values > 0, np.log(values[values > 0]).astype("<f4"))


def shares(values: np.ndarray) -> str:
    """Numbers in [0, 1]: where they are not 0, and there in steps of 1 / `SHARE_STEPS` as uint16."""
    counts = np.rint(np.asarray(values).ravel() * SHARE_STEPS).astype("<u2")
    return _sparse(counts > 0, counts[counts > 0])


def share_rows(rows: np.ndarray) -> str:
    """A table of numbers in [0, 1] in steps of 1 / `SHARE_STEPS`, as varints.

    The number of columns comes first; then, row by row, the change against the row before (the first against
    0), with changes 0, -1, 1, -2, ... as 0, 1, 2, 3, ...
    """
    counts = np.rint(np.asarray(rows) * SHARE_STEPS).astype(np.int64)
    changes = np.diff(counts, axis=0, prepend=0).ravel()
    return varints([counts.shape[1], *np.where(changes < 0, -2 * changes - 1, 2 * changes).tolist()])


def actions(policy: np.ndarray) -> str:
    """A policy, actions 0 to 3 or -1 where undefined, three to a byte: action + 1 as digits of base 5.

    The first state has the lowest digit. Up to two undefined states are added at the end.
    """
    digits = np.asarray(policy, dtype=np.int64) + 1
    digits = np.pad(digits, (0, -len(digits) % 3)).reshape(-1, 3)
    return _text((digits @ [1, 5, 25]).astype(np.uint8).tobytes())


def varints(numbers: Iterable[int]) -> str:
    """Whole numbers >= 0 in groups of 7 bits, low group first, bit 7 set on all but the last (LEB128)."""
    packed = bytearray()
    for number in numbers:
        rest = int(number)
        while rest > 0x7F:
            packed.append(rest & 0x7F | 0x80)
            rest >>= 7
        packed.append(rest)
    return _text(bytes(packed))


def _sparse(present: np.ndarray, values: np.ndarray) -> str:
    """Varints, the lengths of runs of absent and present values in turn; a stop; the present values."""
    edges = np.flatnonzero(np.diff(present, prepend=False)).tolist()
    runs = np.diff([0, *edges, len(present)])
    return f"{varints(runs.tolist())}.{_text(values.tobytes())}"


def _text(data: bytes) -> str:
    return base64.b64encode(data).decode("ascii")
