"""The tables of the study as pages to read."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping

import numpy as np
import pandas as pd

from ptl.pages import Page
from ptl.robustness.design import GROUPS, LATIN_HYPERCUBE, ONE_AT_A_TIME, REFERENCE, Unknown
from ptl.robustness.summary import SIGNIFICANT, changed_text
from ptl.robustness.verdicts import NOT_VARIED, TARGETS, Target

DASH = "–"

GROUP_NAMES = {REFERENCE: "reference", ONE_AT_A_TIME: "one at a time", LATIN_HYPERCUBE: "all at once"}


def share_page(shares: pd.DataFrame, settings: pd.DataFrame) -> Page:
    """For every claim the share of settings in which it holds, and what it hangs on."""
    numbers = {group: int((settings["group"] == group).sum()) for group in GROUPS}
    rows = []
    for row in shares.to_dict("records"):
        agreement = f"{row['reference']} ({row['agreement']:.0%})"
        cells = [row["claim"], agreement]
        for group in GROUPS[1:]:
            parts = [row[f"{group}_{verdict}"] for verdict in ("reproduced", "partly_reproduced", "not_reproduced")]
            cells.append(" / ".join(DASH if np.isnan(part) else f"{part:.0%}" for part in parts))
        cells += [row[name] or DASH for name in ("hangs_on", "flipped_by", "associated_with")]
        rows.append(cells)
    return Page(
        "Robustness of the verdicts",
        "Share of settings in which each claim is reproduced / partly reproduced / not reproduced (what is"
        " missing to 100 % is undecided), and the unknown on which it hangs most. Replicates of the reference"
        f" setting: {numbers[REFERENCE]}; settings with one unknown moved: {numbers[ONE_AT_A_TIME]}; with all"
        f" moved at once, on a Latin hypercube: {numbers[LATIN_HYPERCUBE]}.",
        ("claim", "reference", "one at a time", "all at once", "hangs most on", "flipped by (one at a time)",
         "associated with (all at once)"),
        rows,
        (
            "Reference: the verdict of most replicates and the share of them that agree; the rest shows how"
            " far chance alone moves a verdict at this number of seeds.",
            "Flipped by: unknowns that change the verdict when moved alone, greatest change of the share of"
            " holding parts first.",
            "Associated with: Spearman's coefficient of the share of holding parts with the unknown, or the"
            " square root of H / (n − 1) of Kruskal and Wallis for options (no sign); only"
            f" p < {SIGNIFICANT:g}.",
            "Hangs most on: an unknown that both name, else the strongest association, else the greatest"
            " flip. A flip of a claim whose replicates disagree may be chance.",
            *(f"Left out: {claim} ({reason})." for claim, reason in NOT_VARIED.items()),
            *unfinished_notes(settings),
        ),
        frozenset({1, 4, 5, 6}),
    )  # fmt: skip


def unfinished_notes(settings: pd.DataFrame) -> Iterator[str]:
    """Settings that did not come to their end, and those with truncated episodes, in words."""
    unfinished = settings[settings["status"] != "complete"]
    yield f"Settings that did not finish: {len(unfinished)} of {len(settings)}."
    for row in unfinished.itertuples():
        yield f"{row.setting}: {row.status}."
    truncated = settings[settings["truncated"] > 0]
    yield (
        f"Episodes truncated at the study's step limit: {int(truncated['truncated'].sum())}, in"
        f" {len(truncated)} settings (numbers in settings.csv)."
    )


def unknown_page(table: pd.DataFrame) -> Page:
    """Unknowns ranked by how many claims hang on them."""
    rows = [
        (
            row["symbol"],
            str(row["rank"]),
            str(row["claims_flipped"]),
            row["flipped"] or DASH,
            str(row["claims_associated"]),
            row["associated"] or DASH,
        )
        for row in table.to_dict("records")
    ]
    return Page(
        "What the verdicts hang on",
        "Unknowns ranked by the number of claims whose verdict they flip when moved alone, and with which"
        " they are associated when all move at once.",
        ("unknown", "rank", "claims flipped", "which", "claims associated", "which"),
        rows,
        ("Key of each unknown and its values: config/robustness.yaml; numbers: unknowns.csv.",),
        frozenset({3, 5}),
    )


def target_pages(targets: pd.DataFrame, verdicts: pd.DataFrame, unknowns: Mapping[str, Unknown]) -> Iterator[Page]:
    """One page for each claim with targeted experiments, a row a setting."""
    judged = verdicts.set_index(["setting", "claim"])["verdict"]
    for target in TARGETS:
        own = targets[targets["claim"] == target.claim]
        if own.empty:
            continue
        jump = target.tasks is None
        main = own[own["method"] == "ptl"] if jump else own
        column, unit = ("task", "jump_start_percent") if jump else ("method", "episodes")
        names = list(dict.fromkeys(main[column]))
        rows = []
        for setting, part in main.groupby("setting", sort=False):
            changes = json.loads(part["changes"].iloc[0])
            numbers = part.set_index(column)
            cells = [_with_interval(numbers.loc[name], jump) if name in numbers.index else DASH for name in names]
            label = changed_text(changes, unknowns) or str(setting).replace("_", " ")
            rows.append((label, str(judged.get((setting, target.claim), DASH)), *cells))
        yield _target_page(target, names, rows, jump, unit)


def _with_interval(row: pd.Series, jump: bool) -> str:
    if jump:
        low, high = row["jump_start_low"], row["jump_start_high"]
        return f"{row['jump_start_percent']:.0f} [{low:.0f}, {high:.0f}]".replace("-", "−")
    return f"{row['episodes']:.1f} [{row['episodes_low']:.1f}, {row['episodes_high']:.1f}]"


def _target_page(target: Target, names: list[str], rows: list[tuple[str, ...]], jump: bool, unit: str) -> Page:
    if jump:
        what = "Jump start of ptl in % of the mean first episode without transfer, by task, with intervals."
        columns = tuple(f"task {name}" for name in names)
        note = "The article's claim: not improved. Other variants of ptl and raw means: targeted.csv."
    else:
        what = f"Mean episodes to the threshold on task {target.tasks}, by method, with intervals."
        columns = tuple(names)
        note = "A run that never reaches the threshold counts with all its episodes. Raw means: targeted.csv."
    return Page(
        f"Targeted settings for {target.claim}",
        f"{what} One unknown moved at a time, all else as in the reference.",
        ("setting", "verdict", *columns),
        rows,
        (note,),
        frozenset({1}),
    )
