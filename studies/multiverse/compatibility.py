"""Which of the article's sentences can hold together, and how far the reference is from a typical setting."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

import numpy as np
import pandas as pd
from scipy import stats

from ptl.claims.degrees import STRICT
from ptl.claims.reading import LAST_TASK, TRANSFER_TASKS
from ptl.text import number, percent
from studies.multiverse.judging import JUDGED
from studies.multiverse.shares import DRAWN, drawn, held

RARE = 0.05
"""A claim that holds in fewer of the settings is not asked what it is compatible with."""

FREE = "free"
"""Each claim is read on the task, or the tasks together, on which it holds."""


def tables(verdicts: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """Return what holds in each drawn setting, float (settings, claims), by how claims are read.

    On task F, on B to F together, and with each claim read on its own tasks.
    """
    cloud = drawn(verdicts)
    strict = cloud[cloud["words"] == STRICT]
    free = strict.groupby(["setting", "claim"], sort=False)["holds"].max().unstack()
    ids = [claim.id for claim in JUDGED]
    return {LAST_TASK: held(cloud, LAST_TASK), TRANSFER_TASKS: held(cloud, TRANSFER_TASKS), FREE: free[ids]}


def pair_table(held_by_reading: dict[str, pd.DataFrame]) -> pd.DataFrame:
    """Return how often two claims hold together.

    Returns
    -------
    DataFrame
        Columns read, first, second, settings (in which both were judged), share_first, share_second, together (share),
        expected (product of the two shares).
    """
    rows = []
    for read, table in held_by_reading.items():
        for first, second in combinations(table, 2):
            both = table[[first, second]].dropna()
            one, other = both[first], both[second]
            rows.append(
                (
                    read,
                    first,
                    second,
                    len(both),
                    one.mean(),
                    other.mean(),
                    (one * other).mean(),
                    one.mean() * other.mean(),
                )
            )
    columns = ["read", "first", "second", "settings", "share_first", "share_second", "together", "expected"]
    return pd.DataFrame(rows, columns=columns)


def sentences(pairs: pd.DataFrame) -> Iterator[str]:
    """Yield what follows from pairs of claims that hold in some settings each, but hardly ever in one.

    A pair is named if it holds together in less than a tenth of the settings that independence would give, and in
    significantly fewer (binomial test at 1 in 1,000, since there are some 250 pairs).
    """
    for read, words in ((LAST_TASK, "both read on task F"), (TRANSFER_TASKS, "both read on B to F together")):
        own = pairs[(pairs["read"] == read) & (pairs[["share_first", "share_second"]].min(axis=1) >= RARE)]
        rare = own[[_excluded(row) for row in own.itertuples()]]
        if rare.empty:
            yield f"With claims {words.removeprefix('both ')}, no two claims that hold at times exclude each other."
        for row in rare.itertuples():
            free = pairs[(pairs["read"] == FREE) & (pairs["first"] == row.first) & (pairs["second"] == row.second)]
            yield (
                f"{row.first} and {row.second}, {words}: together in {number(round(row.together * row.settings))} of"
                f" {number(row.settings)} settings, where chance alone would give"
                f" {number(round(row.expected * row.settings))}; read on whichever tasks suit each, in"
                f" {percent(round(float(free['together'].iloc[0]), 2))}."
            )


def _excluded(row: object) -> bool:
    count, settings, expected = round(row.together * row.settings), row.settings, row.expected  # type: ignore[attr-defined]
    if settings == 0 or row.together >= expected / 10:  # type: ignore[attr-defined]
        return False
    return bool(stats.binomtest(count, settings, expected, alternative="less").pvalue < 0.001)


def score_table(verdicts: pd.DataFrame) -> pd.DataFrame:
    """Return the share of the judged claims that hold in each setting, drawn or named.

    Returns
    -------
    DataFrame
        Columns setting, judged, and for each way to read (F, BCDEF) held_<read> and share_<read>; rank_<read>, the
        share of drawn settings with a lower share, ties half.
    """
    frame = pd.DataFrame({"setting": verdicts["setting"].unique()}).set_index("setting")
    is_drawn = frame.index.str.startswith(DRAWN)
    for read in (LAST_TASK, TRANSFER_TASKS):
        table = held(verdicts, read)
        frame["judged"] = table.notna().sum(axis=1)
        frame[f"held_{read}"] = table.sum(axis=1)
        frame[f"share_{read}"] = table.mean(axis=1)
        cloud = frame.loc[is_drawn, f"share_{read}"].to_numpy()
        shares = frame[f"share_{read}"].to_numpy()[:, np.newaxis]
        frame[f"rank_{read}"] = ((cloud < shares).mean(axis=1) + (cloud == shares).mean(axis=1) / 2).round(6)
    return frame.reset_index()
