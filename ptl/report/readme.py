"""The parts of the README that follow from the published run."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from ptl.files.csv import read_csv
from ptl.study.claims.verdict import Verdict
from ptl.text import number


def verdicts(published: Path) -> str:
    """Return the claims by verdict as a Markdown table."""
    claims = read_csv(published / "claims.csv")
    lines = ["| verdict | number | claims |", "|---|---|---|"]
    for verdict in map(str, Verdict):
        names = list(claims.loc[claims["verdict"] == verdict, "id"])
        if names:
            lines.append(f"| {verdict} | {len(names)} | {', '.join(names)} |")
    return "\n".join(lines)


def speed(published: Path) -> str:
    """Return the speed of the learners as a Markdown table."""
    benchmark = read_csv(published / "benchmark.csv")
    machine = benchmark[benchmark["part"] == "machine"].set_index("item")["quantity"]
    rates: pd.Series = benchmark[benchmark["quantity"] == "steps per CPU second"].set_index("item")["value"]
    ratios = benchmark[benchmark["quantity"] == "ratio to plain Python"].set_index("item")["value"]
    lines = ["| learner | million steps with update per CPU second | times plain Python |", "|---|---:|---:|"]
    lines += [f"| {learner} | {number(rate / 1e6)} | {number(ratios[learner])} |" for learner, rate in rates.items()]
    lines += ["", f"Measured on {machine['processor']}, {machine['cores']} cores, {machine['memory']}."]
    return "\n".join(lines)


PARTS = {"verdicts": verdicts, "speed": speed}


def filled(text: str, published: Path) -> str:
    """Return a page with the text between each pair of marks made anew from the published products."""
    for name, part in PARTS.items():
        begin, end = (f"<!-- published: {name}, {word} -->" for word in ("begin", "end"))
        before, mark, rest = text.partition(begin)
        if mark:
            text = f"{before}{begin}\n\n{part(published)}\n\n{end}{rest.partition(end)[2]}"
    return text
