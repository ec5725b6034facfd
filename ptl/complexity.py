"""What a skill library costs: time of one selection and bytes, against its size."""

from __future__ import annotations

import time
from collections.abc import Iterable

import numpy as np
import pandas as pd

from ptl.selection import SkillSelection, prior

REPEATS, DRAWS = 15, 100


def selection_seconds(sizes: Iterable[int], seed: int = 0) -> pd.DataFrame:
    """CPU seconds of one skill selection for libraries of several sizes.

    A selection is the prior for a goal, the weighting by the likelihood and the draw: one loop over the skills.

    Returns
    -------
    DataFrame
        Columns ``skills`` and ``seconds`` (the least of several repeats, each the mean over draws: what disturbs a
        measurement can only lengthen it).
    """
    random = np.random.default_rng(seed)
    rows = []
    for size in sizes:
        cells = random.integers(0, 1000, size=(size, 2))
        timed = []
        for _ in range(REPEATS):
            begin = time.process_time()
            for _ in range(DRAWS):
                selection = SkillSelection(prior(cells, range(size), 0, 1000.0))
                selection.draw(random)
            timed.append((time.process_time() - begin) / DRAWS)
        rows.append({"skills": size, "seconds": min(timed)})
    return pd.DataFrame(rows)


def library_bytes(states: Iterable[int], skills: Iterable[int]) -> pd.DataFrame:
    """Bytes of a library's policies and subgoals as stored: one byte per state and skill, and four per subgoal."""
    rows = [
        {
            "states": n,
            "skills": k,
            "bytes": np.empty((k, n), dtype=np.int8).nbytes + np.empty(k, dtype=np.int32).nbytes,
        }
        for n in states
        for k in skills
    ]
    return pd.DataFrame(rows)
