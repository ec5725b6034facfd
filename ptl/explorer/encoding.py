"""How arrays are packed into the page: little-endian bytes or varints, as base64 text.

The scripts unpack them in ``web/decode.js``. Only what the functions name is lost.
"""

from __future__ import annotations

import base64
from collections.abc import Iterable

import numpy as np

SHARE_STEPS = 65535
"""Numbers in [0, 1] are kept in 1 / 65535, so within 7.7e-6."""


def bytes_text(data: bytes) -> str:
    """Base64 text of bytes."""
    return base64.b64encode(data).decode("ascii")


def logarithms(values: np.ndarray) -> str:
    """Natural logarithms of values >= 0 as float32; 0 becomes minus infinity.

    Values of far states lie below the least float32, their logarithms do not: down to 1e-308 a value comes back
    with a relative error below 4e-5.
    """
    with np.errstate(divide="ignore"):
        return bytes_text(np.log(np.asarray(values, dtype=np.float64)).astype("<f4").tobytes())


def shares(values: np.ndarray) -> str:
    """Numbers in [0, 1] as uint16 in steps of 1 / `SHARE_STEPS`."""
    return bytes_text(np.rint(np.asarray(values) * SHARE_STEPS).astype("<u2").tobytes())


def actions(policy: np.ndarray) -> str:
    """A policy, actions 0 to 3 or -1 where undefined, as int8."""
    return bytes_text(np.asarray(policy, dtype=np.int8).tobytes())


def varints(numbers: Iterable[int]) -> str:
    """Whole numbers >= 0 in groups of 7 bits, low group first, bit 7 set on all but the last (LEB128)."""
    packed = bytearray()
    for number in numbers:
        rest = int(number)
        while rest > 0x7F:
            packed.append(rest & 0x7F | 0x80)
            rest >>= 7
        packed.append(rest)
    return bytes_text(bytes(packed))
