"""The parts of the README that follow from the published run."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from ptl.claims.verdict import Verdict
from ptl.files.csv import read_csv
from ptl.text import estimate, number, percent

TASK = "F"
"""Task of the first table: the last one of each environment."""

PAGES = {"report": "index.html", "explorer of single runs": "explorer.html", "verdicts": "claims.md"}
"""Pages of a checkout by title."""


def result(published: Path) -> str:
    """Return the result in one sentence, and the article's statements on task F with our numbers."""
    metrics = read_csv(published / "tables/metrics.csv")
    estimates = metrics[metrics["task"] == TASK].set_index(["environment", "method", "metric"])

    def ours(environment: str, metric: str, method: str = "ptl", as_percent: bool = False) -> str:
        row = estimates.loc[environment, method, metric]
        factor = 100 if as_percent and metric == "transfer_ratio" else 1
        value, low, high = (round(factor * row[name], 1) for name in ("mean", "ci_low", "ci_high"))
        return estimate(value, low, high, "%" if as_percent else "")

    def mean(environment: str, metric: str, method: str) -> str:
        return number(round(estimates.loc[environment, method, metric]["mean"]))

    runs = int(estimates["seeds"].max())
    counts = read_csv(published / "claims.csv")["verdict"].value_counts()
    verdicts = ", ".join(f"{counts[verdict]} {verdict}" for verdict in map(str, Verdict) if verdict in counts)
    first, second, third = (
        f"{ours(f'env{i}', 'transfer_ratio', as_percent=True)} in environment {i}" for i in (1, 2, 3)
    )
    sentence = (
        f"**Result.** On task {TASK}, the last of six, PTL saves {first}, {second} and {third} of the steps that"
        f" learning from nothing takes (mean of {runs} runs). Of the article's {counts.sum()} claims, judged on"
        f" [many more runs](#results): {verdicts}. Two maps and a width of the method were [chosen because they fit"
        " these claims](docs/reconstruction.md#choices-made-because-they-fit)."
    )
    others = f"{mean('env1', 'asymptotic', 'no_transfer')} and {mean('env1', 'asymptotic', 'full_transfer')}"
    reached = percent(round(estimates.loc["env1", "ptl", "threshold_episode"]["reached"], 2))
    rows = [
        ("1", "PTL: first episode shorter", "about 80 to 90%", ours("env1", "jump_start_percent", as_percent=True)),
        ("1", "PTL: episodes until learned", "about 80", f"{ours('env1', 'threshold_episode')}, {reached} of runs"),
        ("1", "PTL: total steps saved", "more than 90%", ours("env1", "transfer_ratio", as_percent=True)),
        ("1", "PTL: steps per episode at the end", "fewer than with no and with full transfer",
         f"{ours('env1', 'asymptotic')}; {others}"),
        ("1", "full transfer: total steps saved", "negative", ours("env1", "transfer_ratio", "full_transfer", True)),
        ("2", "full transfer: total steps saved", "positive", ours("env2", "transfer_ratio", "full_transfer", True)),
        ("3", "PTL: first episode shorter", "not improved", ours("env3", "jump_start_percent", as_percent=True)),
        ("3", "PTL: total steps saved", "more than 50%", ours("env3", "transfer_ratio", as_percent=True)),
    ]  # fmt: skip
    pages = [f"[{name}](reports/published/{file})" for name, file in PAGES.items() if (published / file).is_file()]
    look = [f"Look without building anything: {', '.join(pages)}.", ""] if pages else []
    header = f"| environment | task {TASK} | the article | this package, {runs} runs |"
    lines = [sentence, "", *look, header, "|---|---|---|---|"]
    return "\n".join(lines + [f"| {' | '.join(row)} |" for row in rows])


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
    others = benchmark[benchmark["part"] == "published"].to_dict("records")
    mark = "published, not measured here"
    lines += [f"| {row['item']} ({mark}) | {number(row['value'] / 1e6)} | – |" for row in others]
    lines += ["", f"Measured on {machine['processor']}, {machine['cores']} cores, {machine['memory']}."]
    lines += [f"Published, {row['item']}: {row['source']}." for row in others]
    return "\n".join(lines)


PARTS = {"result": result, "verdicts": verdicts, "speed": speed}


def filled(text: str, published: Path) -> str:
    """Return a page with the text between each pair of marks made anew from the published products."""
    for name, part in PARTS.items():
        begin, end = (f"<!-- published: {name}, {word} -->" for word in ("begin", "end"))
        before, mark, rest = text.partition(begin)
        if mark:
            text = f"{before}{begin}\n\n{part(published)}\n\n{end}{rest.partition(end)[2]}"
    return text
