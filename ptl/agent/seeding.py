"""Named random streams: the numbers of a job do not depend on which other jobs are in the run."""

from __future__ import annotations

import hashlib
import json

import numpy as np


def bit_generator(root_seed: int, *names: str | int) -> np.random.SFC64:
    """Return the stream of a root seed and a sequence of names, e.g. ``(2019, "env1", "ptl", 7, "A", "steps")``.

    Streams of different names are independent (numpy's SeedSequence with a spawn key made from the names).
    """
    key = hashlib.sha256(json.dumps(names).encode()).digest()
    words = np.frombuffer(key, dtype="<u4").tolist()
    return np.random.SFC64(np.random.SeedSequence(root_seed, spawn_key=words))


def generator(root_seed: int, *names: str | int) -> np.random.Generator:
    """Return a numpy Generator over `bit_generator`."""
    return np.random.Generator(bit_generator(root_seed, *names))
