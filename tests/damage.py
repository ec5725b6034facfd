"""Damage to files, every kind of it, always the same."""

from __future__ import annotations

import hashlib
import random
from collections.abc import Callable, Iterator
from pathlib import Path

import h5py

from ptl.files import store

SEED = 20_190_306
"""Seed of every random moment, byte and bit of the tests with faults."""


def damages(whole: bytes, chance: random.Random) -> Iterator[tuple[str, bytes]]:
    """Damaged contents by name; some may equal the whole."""
    yield "emptied", b""
    yield "cut by a byte", whole[:-1]
    for _ in range(3):
        yield "truncated", whole[: chance.randrange(len(whole))]
    for _ in range(25):
        place, bit = chance.randrange(len(whole)), chance.randrange(8)
        flipped = bytearray(whole)
        flipped[place] ^= 1 << bit
        yield f"bit {bit} of byte {place} flipped", bytes(flipped)
    start = chance.randrange(max(len(whole) - 512, 1))
    yield "a block lost", whole[:start] + bytes(len(whole[start : start + 512])) + whole[start + 512 :]


def rewrite(path: Path, change: Callable[[h5py.File], None]) -> None:
    """Change a file and make its checksum right again, so that only the check of its content can tell."""
    digest = store.digest_in(path) or "0" * 16
    with h5py.File(path, "r+") as file:
        change(file)
    image = path.read_bytes()
    seal = f"\njob {digest}, sha256 of all bytes before this line {hashlib.sha256(image).hexdigest()}\n"
    path.write_bytes(image + seal.encode())
