"""From the verdicts of all settings to the unknowns that each claim depends on.

Two readings (both ours):

* *One at a time*: a claim depends on an unknown if moving that unknown alone changes the verdict that most replicates
  of the reference setting give. Replicates that differ among themselves show how far chance alone moves a verdict.
* *Latin hypercube*: the rank association of the claim's score with each unknown when all move at once: Spearman's
  coefficient where the unknown is a number; where it is one of several options, the square root of H / (n - 1) of the
  Kruskal-Wallis test, which is between 0 and 1 and has no sign.

The score of a claim in a setting is the share of its parts that hold: 1 if it is reproduced, 0 if it is not, between
if partly; undecided has none.
"""

from __future__ import annotations

import json
import warnings
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy import stats

from ptl.claims.verdict import Verdict
from ptl.errors import UserError
from ptl.files.tables import read_table
from ptl.text import number
from studies.robustness.design import GROUPS, LATIN_HYPERCUBE, ONE_AT_A_TIME, REFERENCE, Unknown

VERDICTS = REPRODUCED, PARTLY, NOT, UNDECIDED = tuple(map(str, Verdict))
"""From the most favourable on."""

SIGNIFICANT = 0.01
"""Associations with a greater p-value are not named; of some 500 by chance alone, five would be."""

VERDICT_COLUMNS = ("setting", "group", "changes", "status", "claim", "verdict", "parts", "parts_holding")
"""Columns of `studies.robustness.verdicts.verdict_frame` that are used here; changes are JSON."""


def read_verdicts(paths: Iterable[str | Path]) -> pd.DataFrame:
    """Read the verdicts of all settings in the order of the files; errors as in `read_tables`."""
    return read_tables(paths, VERDICT_COLUMNS)


def read_tables(paths: Iterable[str | Path], columns: Sequence[str] = ("setting",)) -> pd.DataFrame:
    """Read CSV files one below the other; files without rows are left out.

    Raises
    ------
    UserError
        When a file cannot be read or lacks one of the columns, or there is no file.
    """
    frames = [read_table(path, columns) for path in paths]
    if not frames:
        raise UserError("no setting to put together; run 'make robustness'")
    return pd.concat([frame for frame in frames if len(frame)] or frames[:1], ignore_index=True)


def setting_table(verdicts: pd.DataFrame, unknowns: Mapping[str, Unknown]) -> pd.DataFrame:
    """Return a row for each setting.

    Columns setting, group, changes (in words), status, truncated, total_steps and the key of each unknown, empty where
    the setting leaves it as in the run's configuration.
    """
    frame = verdicts.drop_duplicates("setting")
    changes = [json.loads(text) for text in frame["changes"]]
    rows = frame[["setting", "group", "status", "truncated", "total_steps"]].reset_index(drop=True)
    rows.insert(2, "changes", [changed_text(change, unknowns) for change in changes])
    for key in unknowns:
        rows[key] = [value_text(change[key]) if key in change else "" for change in changes]
    return rows


def scores(verdicts: pd.DataFrame) -> pd.Series:
    """Return the share of a claim's parts that hold, NaN where it is undecided."""
    share = verdicts["parts_holding"] / verdicts["parts"].where(verdicts["parts"] > 0)
    return share.where(verdicts["verdict"] != UNDECIDED)


def changed_text(changes: Mapping[str, object], unknowns: Mapping[str, Unknown]) -> str:
    """Return changes in words: ``α = 0.2``."""
    return ", ".join(f"{unknowns[key].symbol} = {value_text(value)}" for key, value in changes.items())


def value_text(value: object) -> str:
    """Return a value as text."""
    if isinstance(value, list | tuple):
        return f"({', '.join(map(str, value))})"
    if isinstance(value, dict):
        return ", ".join(f"{name} {value_text(part)}" for name, part in value.items())
    return str(value).lower() if isinstance(value, bool) else f"{value:g}" if isinstance(value, float) else str(value)


def most_common(verdicts: pd.Series) -> str:
    """Return the verdict that most replicates give; of equally common ones the less favourable."""
    return max(reversed(VERDICTS), key=lambda verdict: (verdicts == verdict).sum())


def reference_verdicts(verdicts: pd.DataFrame) -> pd.DataFrame:
    """Return by claim: ``verdict`` (of most replicates), ``agreement`` (share that gives it), mean ``score``."""
    replicates = verdicts.assign(score=scores(verdicts))[verdicts["group"] == REFERENCE].groupby("claim", sort=False)
    verdict = replicates["verdict"].agg(most_common)
    agreement = replicates["verdict"].agg(lambda given: float((given == most_common(given)).mean()))
    return pd.DataFrame({"verdict": verdict, "agreement": agreement, "score": replicates["score"].mean()})


def flips(verdicts: pd.DataFrame) -> pd.DataFrame:
    """Return the one-at-a-time settings whose verdict differs from the reference's; undecided ones do not count.

    Returns
    -------
    DataFrame
        Columns claim, unknown, value (JSON), verdict, change (of the score; NaN if the reference has none).
    """
    reference = reference_verdicts(verdicts)
    rows = []
    for row in verdicts.assign(score=scores(verdicts))[verdicts["group"] == ONE_AT_A_TIME].itertuples():
        before = reference.loc[row.claim]
        if row.verdict not in (before["verdict"], UNDECIDED):
            [(unknown, value)] = json.loads(row.changes).items()
            rows.append((row.claim, unknown, json.dumps(value), row.verdict, row.score - before["score"]))
    return pd.DataFrame(rows, columns=["claim", "unknown", "value", "verdict", "change"])


def associations(verdicts: pd.DataFrame, unknowns: Mapping[str, Unknown]) -> pd.DataFrame:
    """Return the rank association of every claim's score with every unknown over the Latin hypercube.

    Returns
    -------
    DataFrame
        Columns claim, unknown, association, signed (whether its sign means anything), p_value, n (decided
        settings). A claim whose score never changes is associated with nothing: 0, p-value 1.
    """
    rows = []
    hypercube = verdicts.assign(score=scores(verdicts))[verdicts["group"] == LATIN_HYPERCUBE]
    for claim, part in hypercube.groupby("claim", sort=False):
        decided = part[part["score"].notna()]
        changes = [json.loads(text) for text in decided["changes"]]
        score = decided["score"].to_numpy()
        for key, unknown in unknowns.items():
            column = [change[key] for change in changes if key in change]
            if column and len(column) == len(score):
                signed = not unknown.options
                association, p_value = _association(column, score, signed)
                rows.append((claim, key, association, signed, p_value, len(score)))
    columns = ["claim", "unknown", "association", "signed", "p_value", "n"]
    return pd.DataFrame(rows, columns=columns)


def _association(values: Sequence[object], score: np.ndarray, signed: bool) -> tuple[float, float]:
    if len(score) < 3 or np.all(score == score[0]):
        return 0.0, 1.0
    if signed:
        numbers = np.asarray(values, dtype=float)
        if np.all(numbers == numbers[0]):
            return 0.0, 1.0
        result = stats.spearmanr(numbers, score)
        return float(result.statistic), float(result.pvalue)
    labels = np.array([json.dumps(value) for value in values])
    samples = [score[labels == label] for label in np.unique(labels)]
    if len(samples) < 2:
        return 0.0, 1.0
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # too few values in a sample
        result = stats.kruskal(*samples)
    return float(np.sqrt(min(1.0, result.statistic / (len(score) - 1)))), float(result.pvalue)


def share_table(verdicts: pd.DataFrame, unknowns: Mapping[str, Unknown]) -> pd.DataFrame:
    """Return the share of settings in which each claim holds, and the unknowns that it depends on.

    Returns
    -------
    DataFrame
        Columns claim, reference (verdict of most replicates), agreement; for each group of settings its
        size, the shares with each verdict (``one_at_a_time_reproduced``, ...) and the mean score;
        flipped_by (unknowns with values, one at a time, greatest change first); associated_with (unknowns of
        the Latin hypercube with their association, strongest first, p-value below `SIGNIFICANT`); most_affected_by
        (the first of these, see `_most_affected_by`).
    """
    reference = reference_verdicts(verdicts)
    turned = flips(verdicts)
    related = associations(verdicts, unknowns)
    rows = []
    for claim, part in verdicts.assign(score=scores(verdicts)).groupby("claim", sort=False):
        row: dict[str, object] = {"claim": claim}
        row["reference"], row["agreement"] = reference.loc[claim, ["verdict", "agreement"]]
        for group in GROUPS:
            own = part[part["group"] == group]
            row[f"{group}_settings"] = len(own)
            for verdict in VERDICTS:
                share = float((own["verdict"] == verdict).mean()) if len(own) else np.nan
                row[f"{group}_{verdict.replace(' ', '_')}"] = share
            row[f"{group}_score"] = own["score"].mean()
        by_flip = _by_unknown(turned[turned["claim"] == claim])
        by_rank = _strongest(related[related["claim"] == claim])
        row["flipped_by"] = "; ".join(_flip_text(unknowns[key], part) for key, part in by_flip.items())
        row["associated_with"] = ", ".join(
            f"{unknowns[item.unknown].symbol} ({_strength(item)})" for item in by_rank.itertuples()
        )
        row["most_affected_by"] = _most_affected_by(list(by_flip), list(by_rank["unknown"]), unknowns)
        rows.append(row)
    return pd.DataFrame(rows)


def _strongest(related: pd.DataFrame) -> pd.DataFrame:
    """Return the associations that are more than chance, strongest first."""
    significant = related[related["p_value"] < SIGNIFICANT]
    return significant.reindex(significant["association"].abs().sort_values(ascending=False, kind="stable").index)


def _strength(item: Any) -> str:
    sign = "+" if item.signed and item.association > 0 else ""
    return sign + number(round(item.association, 2))


def _by_unknown(turned: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """Return the flips of one claim by unknown, the one with the greatest change of score first."""
    parts = {str(key): part for key, part in turned.groupby("unknown", sort=False)}
    return dict(sorted(parts.items(), key=lambda item: -np.nan_to_num(item[1]["change"].abs().max())))


def _flip_text(unknown: Unknown, part: pd.DataFrame) -> str:
    values = ", ".join(f"{value_text(json.loads(row.value))}: {row.verdict}" for row in part.itertuples())
    return f"{unknown.symbol} ({values})"


def _most_affected_by(by_flip: list[str], by_rank: list[str], unknowns: Mapping[str, Unknown]) -> str:
    """Return the hypercube's first unknown that flips too; else the hypercube's first, else the first flip."""
    both = [key for key in by_rank if key in by_flip]
    chosen = (both or by_rank or by_flip)[:1]
    return unknowns[chosen[0]].symbol if chosen else ""


def unknown_table(verdicts: pd.DataFrame, unknowns: Mapping[str, Unknown]) -> pd.DataFrame:
    """Return the unknowns ranked by the number of claims that depend on them.

    Returns
    -------
    DataFrame
        Columns rank, unknown (key), symbol, claims_flipped (number), flipped (their names), claims_associated
        (number with a p-value below `SIGNIFICANT`), associated (names with the association), strongest
        (greatest association); ranked by the two numbers together, then by the strongest association.
    """
    turned = flips(verdicts)
    related = associations(verdicts, unknowns)
    rows = []
    for key, unknown in unknowns.items():
        flipped = list(dict.fromkeys(turned.loc[turned["unknown"] == key, "claim"]))
        own = related[related["unknown"] == key]
        strong = _strongest(own)
        rows.append(
            {
                "unknown": key,
                "symbol": unknown.symbol,
                "claims_flipped": len(flipped),
                "flipped": ", ".join(flipped),
                "claims_associated": len(strong),
                "associated": ", ".join(f"{item.claim} ({_strength(item)})" for item in strong.itertuples()),
                "strongest": float(own["association"].abs().max()) if len(own) else np.nan,
            }
        )
    frame = pd.DataFrame(rows)
    order = frame.assign(total=frame["claims_flipped"] + frame["claims_associated"], top=frame["strongest"].fillna(0))
    frame = frame.loc[order.sort_values(["total", "top"], ascending=False, kind="stable").index]
    return frame.reset_index(drop=True).rename_axis("rank").reset_index().assign(rank=lambda f: f["rank"] + 1)
