"""In how many settings each claim holds: under each reading, given the other claims, and in 30 runs."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pandas as pd
from scipy import stats

from ptl.claims.claim import Claim
from ptl.claims.degrees import STRICT
from ptl.claims.reading import ARTICLE_RUNS, DEFAULT, LAST_TASK, TRANSFER_TASKS, Reading
from studies.multiverse.judging import JUDGED, LIMIT

KEYS = ["claim", "words", "tasks", "tolerance", "runs"]
"""Columns that name a claim under a reading."""

BEST = 0.25
"""Share of the settings that count as those in which the other claims hold best."""

DRAWN = "setting_"
"""Beginning of the names of drawn settings."""


def drawn(frame: pd.DataFrame) -> pd.DataFrame:
    """Return the rows of the settings that were drawn."""
    return frame[frame["setting"].str.startswith(DRAWN)]


def share_table(verdicts: pd.DataFrame, confidence: float) -> pd.DataFrame:
    """Return the share of settings in which each claim holds under each reading.

    Parameters
    ----------
    verdicts : DataFrame
        Columns `studies.multiverse.judging.VERDICT_COLUMNS`, of drawn settings.

    Returns
    -------
    DataFrame
        Columns `KEYS`, settings (judged), share, low, high (Wilson).
    """
    rows = []
    for names, part in verdicts.groupby(KEYS, sort=False):
        held = part["holds"].dropna()
        rows.append((*names, len(held), *_wilson(held.sum(), len(held), confidence)))
    return pd.DataFrame(rows, columns=[*KEYS, "settings", "share", "low", "high"])


def _wilson(count: float, number: float, confidence: float) -> tuple[float, float, float]:
    """Return a share with its Wilson interval; the counts may be sums of weights."""
    if number == 0:
        return np.nan, np.nan, np.nan
    z = stats.norm.ppf((1 + confidence) / 2)
    share = count / number
    middle = (share + z**2 / (2 * number)) / (1 + z**2 / number)
    reach = z / (1 + z**2 / number) * np.sqrt(share * (1 - share) / number + z**2 / (4 * number**2))
    # rounding must not put an end on the wrong side of the share
    return share, min(share, max(0.0, middle - reach)), max(share, min(1.0, middle + reach))


# -- one reading for each claim ------------------------------------------------------------------------------------


def reading_of(claim: Claim, tasks: str) -> Reading:
    """Return the reading of a claim on these tasks, if it leaves them open, and at the article's number of runs."""
    return Reading(
        tasks=tasks if "tasks" in claim.open_to else DEFAULT.tasks,
        runs=ARTICLE_RUNS if "runs" in claim.open_to else DEFAULT.runs,
    )


def held(verdicts: pd.DataFrame, tasks: str, claims: Iterable[Claim] = JUDGED) -> pd.DataFrame:
    """Return what holds in each setting, float (settings, claims), NaN where a claim could not be judged."""
    columns = {}
    for claim in claims:
        columns[claim.id] = column(verdicts, claim, reading_of(claim, tasks))
    return pd.DataFrame(columns).reindex(verdicts["setting"].unique())


def column(verdicts: pd.DataFrame, claim: Claim, reading: Reading, words: str = STRICT) -> pd.Series:
    """Return whether a claim holds in each setting under a reading, indexed by setting."""
    runs = LIMIT if reading.runs is None else str(reading.runs)
    wanted = (
        (verdicts["claim"] == claim.id)
        & (verdicts["words"] == words)
        & (verdicts["tasks"] == reading.tasks)
        & (verdicts["tolerance"] == reading.tolerance)
        & (verdicts["runs"] == runs)
    )
    return verdicts[wanted].set_index("setting")["holds"]


def best_weights(scores: pd.Series, share: float = BEST) -> pd.Series:
    """Return weights 0 to 1 that pick a share of the settings with the highest scores; ties share what is left."""
    wanted = share * len(scores)
    weights = pd.Series(0.0, index=scores.index)
    for score in np.sort(scores.unique())[::-1]:
        tied = scores.index[scores == score]
        weights[tied] = min(1.0, wanted / len(tied))
        wanted -= len(tied)
        if wanted <= 0:
            break
    return weights


def given_others(held: pd.DataFrame, confidence: float) -> pd.DataFrame:
    """Return the share of settings in which each claim holds, of those in which the other claims hold best.

    A setting's score for a claim is the share of the other claims that hold in it, of those that were judged; the best
    quarter counts.

    Returns
    -------
    DataFrame
        Indexed by claim; columns given_others, given_others_low, given_others_high.
    """
    rows = {}
    for claim in held:
        judged = held[held[claim].notna()]
        weights = best_weights(judged.drop(columns=claim).mean(axis=1).fillna(0.0))
        rows[claim] = _wilson(float((weights * judged[claim]).sum()), float(weights.sum()), confidence)
    return pd.DataFrame(rows, index=["given_others", "given_others_low", "given_others_high"]).T


# -- the ledger of degrees -----------------------------------------------------------------------------------------

LEDGER_COLUMNS = (
    "claim", "statement", "class", "holds_when", "share", "low", "high", "share_together", "low_together",
    "high_together", "given_others", "given_others_low", "given_others_high", "printed", "printed_together",
)  # fmt: skip


def ledger(verdicts: pd.DataFrame, printed: pd.DataFrame, classes: pd.DataFrame, confidence: float) -> pd.DataFrame:
    """Return the degrees of each claim.

    Parameters
    ----------
    verdicts : DataFrame
        Of all settings, drawn and named.
    printed : DataFrame
        Of the reference, see `studies.multiverse.judging.replicated`.
    classes : DataFrame
        Columns id, class and holds_when of the published run's claims.

    Returns
    -------
    DataFrame
        Columns `LEDGER_COLUMNS`: shares of the drawn settings on task F (where the claim leaves the task open) and on B
        to F together, the share given all other claims, and the probability that 30 runs of the reference print it.
    """
    cloud, published = drawn(verdicts), classes.set_index("id")
    shares = {tasks: share_table(cloud, confidence).set_index(KEYS) for tasks in (LAST_TASK, TRANSFER_TASKS)}
    others = given_others(held(cloud, LAST_TASK), confidence)
    prints = printed.set_index(KEYS)["printed"]
    rows = []
    for claim in JUDGED:
        keys = {tasks: _key(claim, reading_of(claim, tasks)) for tasks in (LAST_TASK, TRANSFER_TASKS)}
        single, together = (shares[tasks].loc[keys[tasks]] for tasks in (LAST_TASK, TRANSFER_TASKS))
        rows.append(
            (
                claim.id,
                claim.statement,
                *published.loc[claim.id, ["class", "holds_when"]],
                *single[["share", "low", "high"]],
                *together[["share", "low", "high"]],
                *others.loc[claim.id],
                prints[keys[LAST_TASK]],
                prints[keys[TRANSFER_TASKS]],
            )
        )
    return pd.DataFrame(rows, columns=list(LEDGER_COLUMNS))


def _key(claim: Claim, reading: Reading, words: str = STRICT) -> tuple[object, ...]:
    runs = LIMIT if reading.runs is None else str(reading.runs)
    return claim.id, words, reading.tasks, reading.tolerance, runs
