"""The tables of the study as pages to read."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping

import numpy as np
import pandas as pd

from ptl.report.table import Table, text_table
from ptl.text import MISSING, interval, number, percent
from studies.robustness.design import GROUPS, LATIN_HYPERCUBE, ONE_AT_A_TIME, REFERENCE, Unknown
from studies.robustness.summary import SIGNIFICANT, changed_text
from studies.robustness.verdicts import NOT_VARIED, TARGETS, Target


def share_table(shares: pd.DataFrame, settings: pd.DataFrame) -> Table:
    """Lay out the share of settings in which each claim holds, and the unknowns that affect it."""
    numbers = {group: int((settings["group"] == group).sum()) for group in GROUPS}
    rows = []
    for row in shares.to_dict("records"):
        agreement = f"{row['reference']} ({percent(row['agreement'])})"
        cells = [row["claim"], agreement]
        for group in GROUPS[1:]:
            parts = [row[f"{group}_{verdict}"] for verdict in ("reproduced", "partly_reproduced", "not_reproduced")]
            cells.append(" / ".join(MISSING if np.isnan(part) else percent(round(part, 2)) for part in parts))
        cells += [row[name] or MISSING for name in ("most_affected_by", "flipped_by", "associated_with")]
        rows.append(cells)
    headings = (
        "claim",
        "reference",
        "one at a time",
        "all at once",
        "most affected by",
        "changed by (one at a time)",
        "associated with (all at once)",
    )
    return text_table(
        "Robustness of the verdicts",
        "Share of settings in which each claim is reproduced / partly reproduced / not reproduced (the rest to 100% is"
        f" undecided), and the unknown that affects it most. Replicates of the reference setting: {numbers[REFERENCE]};"
        f" settings with one unknown moved: {numbers[ONE_AT_A_TIME]}; with all moved at once, on a Latin hypercube:"
        f" {numbers[LATIN_HYPERCUBE]}.",
        headings,
        rows,
        (
            "Reference: the verdict of most replicates and the share of them that agree; the rest shows how far chance"
            " alone moves a verdict at this number of seeds.",
            "Changed by: unknowns that change the verdict when moved alone, greatest change of the share of holding"
            " parts first.",
            "Associated with: Spearman's coefficient of the share of holding parts with the unknown, or the square root"
            f" of H / (n − 1) of Kruskal and Wallis for options (no sign); only p < {number(SIGNIFICANT)}.",
            "Most affected by: an unknown that both name, else the strongest association, else the greatest change. A"
            " change of a claim whose replicates disagree may be chance.",
            *(f"Left out: {claim} ({reason})." for claim, reason in NOT_VARIED.items()),
            *unfinished_notes(settings),
        ),
        (headings[1], *headings[4:]),
    )


def unfinished_notes(settings: pd.DataFrame) -> Iterator[str]:
    """Describe the settings that did not finish, and those with truncated episodes."""
    unfinished = settings[settings["status"] != "complete"]
    yield f"Settings that did not finish: {len(unfinished)} of {len(settings)}."
    for row in unfinished.itertuples():
        yield f"{row.setting}: {row.status}."
    truncated = settings[settings["truncated"] > 0]
    yield (
        f"Episodes truncated at the study's step limit: {number(int(truncated['truncated'].sum()))}, in"
        f" {len(truncated)} settings (numbers in settings.csv)."
    )


def unknown_table(table: pd.DataFrame) -> Table:
    """Rank the unknowns by the number of claims that they affect."""
    rows = [
        (
            row["symbol"],
            str(row["rank"]),
            str(row["claims_flipped"]),
            row["flipped"] or MISSING,
            str(row["claims_associated"]),
            row["associated"] or MISSING,
        )
        for row in table.to_dict("records")
    ]
    return text_table(
        "Unknowns that affect the verdicts",
        "Unknowns ranked by the number of claims whose verdict they change when moved alone, and with which they are"
        " associated when all move at once.",
        ("unknown", "rank", "claims changed", "which", "claims associated", "associations"),
        rows,
        ("Key of each unknown and its values: studies/robustness/config/robustness.yaml; numbers: unknowns.csv.",),
        ("which", "associations"),
    )


def target_tables(targets: pd.DataFrame, verdicts: pd.DataFrame, unknowns: Mapping[str, Unknown]) -> Iterator[Table]:
    """Yield a table for each claim with targeted experiments, a row a setting."""
    judged = verdicts.set_index(["setting", "claim"])["verdict"]
    for target in TARGETS:
        own = targets[targets["claim"] == target.claim]
        if own.empty:
            continue
        jump = target.tasks is None
        main = own[own["method"] == "ptl"] if jump else own
        column = "task" if jump else "method"
        names = list(dict.fromkeys(main[column]))
        rows = []
        for setting, part in main.groupby("setting", sort=False):
            changes = json.loads(part["changes"].iloc[0])
            numbers = part.set_index(column)
            cells = [_with_interval(numbers.loc[name], jump) if name in numbers.index else MISSING for name in names]
            label = changed_text(changes, unknowns) or str(setting).replace("_", " ")
            rows.append((label, str(judged.get((setting, target.claim), MISSING)), *cells))
        yield _target_table(target, names, rows, jump)


def _with_interval(row: pd.Series, jump: bool) -> str:
    name = "jump_start" if jump else "episodes"
    value = row["jump_start_percent"] if jump else row["episodes"]
    return f"{number(value)} {interval(row[f'{name}_low'], row[f'{name}_high'])}"


def _target_table(target: Target, names: list[str], rows: list[tuple[str, ...]], jump: bool) -> Table:
    if jump:
        intro = "Jump start of ptl in % of the mean first episode without transfer, by task, with intervals."
        columns = tuple(f"task {name}" for name in names)
        note = "The article's claim: not improved. Other variants of ptl and raw means: targeted.csv."
    else:
        intro = f"Mean episodes to the threshold on task {target.tasks}, by method, with intervals."
        columns = tuple(names)
        note = "A run that never reaches the threshold counts with all its episodes. Raw means: targeted.csv."
    return text_table(
        f"Targeted settings for {target.claim}",
        f"{intro} One unknown moved at a time, all else as in the reference.",
        ("setting", "verdict", *columns),
        rows,
        (note,),
        ("verdict",),
    )
