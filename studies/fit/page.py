"""The tables of the search for a reading that fits."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd

from ptl.report.table import Table, text_table

RULE = (
    "Rule, fixed before the search: most claims reproduced, then fewest failing parts, then fewest changes against the"
    " first reference, then the earlier entry of config/fit.yaml."
)

FINAL, SCREEN = "final", "screen"


def setting_text(learner: str, drawings: str) -> str:
    """Describe a setting by its changes, one a line; JSON of the two columns of ``tried.csv``."""
    changes = [f"{name} = {value}" for name, value in json.loads(learner).items()]
    for environment, drawing in json.loads(drawings).items():
        changes += [f"{environment}: {_drawing_text(changed)}" for changed in [drawing] if changed]
    return "\n".join(changes) or "first reference"


def _drawing_text(drawing: Mapping[str, Any]) -> str:
    [(kind, values)] = drawing.items()
    if isinstance(values, dict):
        return f"{kind}, " + ", ".join(f"{name} {value}" for name, value in values.items())
    return f"{kind} {values}"


def settings_table(tried: pd.DataFrame, stage: str) -> Table:
    """Lay out the settings of a stage that were judged on all claims, the best first."""
    own = tried[tried["stage"] == stage].fillna({"chosen_by": ""})
    own = own.sort_values(["reproduced", "parts_failing", "changes"], ascending=[False, True, True], kind="stable")
    rows = [
        (
            str(rank), setting_text(row["learner"], row["drawings"]), f"{row['reproduced']} of {row['claims']}",
            str(row["parts_failing"]), str(row["changes"]), row["chosen_by"],
        )
        for rank, row in enumerate(own.to_dict("records"), start=1)
    ]  # fmt: skip
    title, what = {
        FINAL: ("Settings decided", "The finalists, with random numbers that the search had not used"),
        SCREEN: ("Settings screened", "Each learner with its best drawings"),
    }[stage]
    headings = ("rank", "setting", "claims reproduced", "parts failing", "changes", "chosen by")
    return text_table(
        title,
        f"{what}: {own['seeds'].iloc[0]} seeds each. {RULE} Claims that no setting can change are left out.",
        headings,
        rows,
        ("Every setting of every stage: tried.csv. The numbers behind the settings decided: parts.csv.",),
        (headings[1], headings[-1]),
    )


def halves_table(halves: pd.DataFrame) -> Table:
    """Lay out what a choice by one half of the claims is worth on the other half."""
    rows = [
        (
            row["half"], setting_text(row["learner"], row["drawings"]),
            *(
                f"{row[f'{who}_{where}']} of {row[f'claims_{where}']}"
                for where in ("chosen_on", "checked_on")
                for who in ("reference", "choice")
            ),
        )
        for row in halves.to_dict("records")
    ]  # fmt: skip
    headings = (
        "chosen by the",
        "setting",
        "that half: first reference",
        "that half: choice",
        "other half: first reference",
        "other half: choice",
    )
    return text_table(
        "What the choice is worth on claims that it had not seen",
        "The search, done again with one half of the claims only, and its choice judged on the other half: claims"
        " reproduced. Where the choice gains on its own half only, it fits the claims and explains nothing.",
        headings,
        rows,
        ("The halves are in config/fit.yaml: every second claim of the ledger.",),
        (headings[1],),
    )


def claims_table(tried: pd.DataFrame, halves: Sequence[Sequence[str]]) -> Table:
    """Lay out the verdict on each claim by settings that were chosen with it and by the one that was chosen without it.

    Parameters
    ----------
    tried : DataFrame
        ``tried.csv``: settings judged on all claims in the final stage, with ``chosen_by``.
    halves : two sequences of str
        Claims of either half.
    """
    final = tried[(tried["stage"] == FINAL)].fillna({"chosen_by": ""})
    reference = final[(final["changes"] == 0)]
    names = ("all claims", "first half", "second half")
    choices = [
        final[final["chosen_by"].str.split("; ").apply(lambda chosen, name=name: name in chosen)] for name in names
    ]
    first, everything, by_first, by_second = (json.loads(rows["verdicts"].iloc[0]) for rows in (reference, *choices))
    rows = [
        (claim, half, first[claim], everything[claim], (by_first if half == "second" else by_second)[claim])
        for half, claims in zip(("first", "second"), halves, strict=True)
        for claim in claims
    ]
    order = list(everything)
    headings = ("claim", "half", "first reference", "chosen by all claims", "chosen without this claim")
    return text_table(
        "Each claim with and without a say in the choice",
        "The last column is the check: the setting there was chosen by the half to which the claim does not belong.",
        headings,
        sorted(rows, key=lambda row: order.index(row[0])),
        ("Verdicts of the final stage of the search; those of the published run rest on more seeds and others.",),
        headings[1:],
    )
