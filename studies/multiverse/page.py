"""The page of the multiverse: what a reader may conclude, and the figures and tables behind it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from ptl.claims.degrees import CLASSES
from ptl.claims.reading import LAST_TASK, TRANSFER_TASKS
from ptl.report.table import Table, text_table
from ptl.report.templating import render
from ptl.text import MISSING, interval, number, percent
from studies.multiverse.adoption import ABOUT_PTL
from studies.multiverse.design import Multiverse, Unknown
from studies.multiverse.judging import NOT_JUDGED
from studies.multiverse.shares import drawn

TEMPLATES = Path(__file__).parent / "templates"


def ledger_table(ledger: pd.DataFrame) -> Table:
    """Lay out the ledger of degrees."""
    rows = [
        (
            row["claim"],
            row["statement"],
            f"{row['class']}{f': {when}' if isinstance(when := row['holds_when'], str) else ''}",
            _share(row["share"], row["low"], row["high"]),
            _share(row["share_together"], row["low_together"], row["high_together"]),
            _share(row["given_others"], row["given_others_low"], row["given_others_high"]),
            _percent(row["printed"]),
            _percent(row["printed_together"]),
        )
        for row in ledger.to_dict("records")
    ]
    return text_table(
        "Degrees of the claims",
        "How far each of the article's statements holds, instead of a single verdict.",
        (
            "claim", "the article’s statement, in our words", "in the published run", "settings, task F",
            "settings, B to F together", "given the other claims", "30 runs print it, F", "together",
        ),
        rows,
        (
            *(f"{name.capitalize()}: {meaning}." for name, meaning in CLASSES.items()),
            "In the published run: its class by as many runs as a verdict needs.",
            "Settings: share of the drawn settings in which the claim holds as a statement about means, with its Wilson"
            " interval; a claim that names its task or tasks is read so in both columns. Significance is that of the"
            " article's 30 runs.",
            "Given the other claims: the share among the quarter of the settings in which most of the other claims"
            " hold. Far above the share, the claim goes with the others; far below, it speaks against them.",
            "30 runs print it: share of samples of 30 runs of the reference whose means satisfy the statement.",
        ),
        ("the article’s statement, in our words", "in the published run"),
    )  # fmt: skip


def _share(share: float, low: float, high: float) -> str:
    """Show a share with its interval, rounded outwards: that of none or of all the settings is not a point."""
    if np.isnan(share):
        return MISSING
    ends = np.round([100 * low, 100 * high], 9)
    return f"{_percent(share)} {interval(float(np.floor(ends[0])), float(np.ceil(ends[1])))}"


def _percent(share: float) -> str:
    return MISSING if np.isnan(share) else percent(round(share, 2))


def way_table(ways: pd.DataFrame, chosen: str) -> Table:
    """Lay out how many claims hold with each way to use a skill."""
    ids = [claim for claim in ABOUT_PTL if claim in ways]
    rows = [
        (
            f"{str(row['way']).replace('_', ' ')}{' (adopted)' if row['way'] == chosen else ''}",
            number(int(row["settings"])),
            f"{percent(round(row['mean'], 3))} ± {number(round(100 * row['error'], 1))}",
            _percent(row["half"]),
            *(_percent(row[claim]) for claim in ids),
        )
        for row in ways.sort_values("mean", ascending=False, kind="stable").to_dict("records")
    ]
    return text_table(
        "Ways to use a skill",
        "Share of the claims about PTL that hold, read on B to F together, over all else that is unknown.",
        ("way", "settings", "claims that hold", "half of them or more", *ids),
        rows,
        (
            "The rule, fixed beforehand: the highest mean share is adopted; of ways within two standard errors of the"
            " difference, the first in the order of the study's file, simplest first.",
            "± is one standard error over settings.",
        ),
    )


def score_table(scores: pd.DataFrame, named: Mapping[str, str], fitted: Mapping[str, int]) -> Table:
    """Lay out how many claims hold in the named settings and how rare that is among drawn ones."""
    by_setting = scores.set_index("setting")
    rows = []
    for name, title in named.items():
        if name not in by_setting.index:
            continue
        row = by_setting.loc[name]
        cells = [
            text
            for read in (LAST_TASK, TRANSFER_TASKS)
            for text in (
                f"{number(int(row[f'held_{read}']))} of {number(int(row['judged']))}",
                percent(round(float(row[f"rank_{read}"]), 3)),
            )
        ]
        rows.append((title, number(fitted[name]), *cells))
    return text_table(
        "Named settings among the drawn ones",
        "Claims that hold, as statements about means, and the share of the drawn settings in which fewer hold.",
        (
            "setting", "choices made by fit", "hold on F", "fewer hold in", "hold on B to F together",
            "fewer hold together in",
        ),
        rows,
    )  # fmt: skip


def unknown_table(unknowns: Mapping[str, Unknown]) -> Table:
    """Lay out what is drawn, from which range and why."""
    rows = [(unknown.symbol, _range(unknown), name, unknown.reason) for name, unknown in unknowns.items()]
    return text_table(
        "What is drawn",
        "Each unknown with its range, fixed before any setting was learned; that of the slip was added after a first"
        " draw without it.",
        ("unknown", "range", "key", "reason"),
        rows,
        ("A Latin hypercube: every part of every range is drawn equally often.",),
        ("range", "key", "reason"),
    )


def _range(unknown: Unknown) -> str:
    if unknown.range:
        return f"{number(unknown.range[0])} to {number(unknown.range[1])}{', log' if unknown.scale == 'log' else ''}"
    return ", ".join(_value(option) for option in unknown.options)


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"({', '.join(map(str, value))})" if isinstance(value, list | tuple) else str(value).replace("_", " ")


# -- sentences -----------------------------------------------------------------------------------------------------


def conclusions(scores: pd.DataFrame, chosen: str, alike: Sequence[str], reference: str) -> Iterator[str]:
    """Yield what a reader may conclude, from the numbers."""
    row = scores.set_index("setting").loc[reference]
    yield (
        f"More claims hold in the reference than in {percent(round(float(row[f'rank_{LAST_TASK}']), 3))} of the drawn"
        f" settings if claims are read on task F, and than in {percent(round(float(row[f'rank_{TRANSFER_TASKS}']), 3))}"
        " if they are read on B to F together: it was chosen because it fits, and its agreement is no prediction."
    )
    cloud = drawn(scores)
    for read, words in ((LAST_TASK, "on task F"), (TRANSFER_TASKS, "on B to F together")):
        held = cloud[f"held_{read}"]
        yield (
            f"Read {words}, a drawn setting makes {number(round(float(held.mean()), 1))} claims hold on average and"
            f" {number(int(held.max()))} at most."
        )
    others = ", ".join(way.replace("_", " ") for way in alike if way != chosen)
    ways = f" (by its place in the file; not told apart from {others})" if others else ""
    yield f"Of the ways to use a skill within an episode, the rule adopts {chosen.replace('_', ' ')}{ways}."


def method_lines(study: Multiverse, incomplete: int) -> list[str]:
    """Describe the design."""
    effort = ", ".join(
        f"{name.replace('_', ' ')} {number(own.seeds)}{f' in every {own.every}th setting' if own.every > 1 else ''}"
        for name, own in study.methods.items()
    )
    others = [
        f"{number(runs)} of {own.title}"
        for name, own in study.named.items()
        if (runs := study.named_runs(name)) != study.named_seeds
    ]
    named = ", ".join([f"{number(study.named_seeds)} of each method", *others])
    return [
        f"{number(study.settings)} settings, drawn from everything in the table above at once. Learning runs of each"
        f" environment: {effort}. Named settings: {named}.",
        f"In {number(incomplete)} settings a method was given up in an environment after {number(study.step_budget)}"
        " steps for each of its runs; the runs that it finished count.",
        *(f"Not judged: {claim}, which {reason}." for claim, reason in NOT_JUDGED.items()),
        "Every number of each setting: verdicts.csv.gz, estimates.csv.gz and settings.csv.",
    ]


def page(**values: Any) -> str:
    """Fill the page's template."""
    return render(
        "multiverse.html", folder=TEMPLATES, title="What holds, under which readings of the article", **values
    )
