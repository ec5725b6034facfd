"""The parts of the README that follow from the published run."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pandas as pd

from ptl.claims.comparisons import FULL, PTL, saved_percent
from ptl.claims.degrees import CLASSES
from ptl.claims.evidence import Evidence, settings_of
from ptl.claims.reading import LAST_TASK, TRANSFER_TASKS
from ptl.config import Configuration
from ptl.files.configuration import completed, read_yaml
from ptl.files.csv import read_csv
from ptl.jobs.kinds import modules_of_studies
from ptl.measures import relative_steps
from ptl.measures.run_files import read_per_seed
from ptl.report.ledger import class_counts, counts_text
from ptl.text import estimate, number, percent
from ptl.world.map_files import load_map

CONFIG = Path("config/config.yaml")
"""Configuration of the published run in a checkout."""

PAGES = {"report": "index.html", "explorer of single runs": "explorer.html", "claims": "claims.md"}
"""Pages of a checkout by title."""


def result(published: Path) -> str:
    """Return the result in a few sentences, and the article's statements with our numbers."""
    run: Configuration = completed(read_yaml(published.parents[1] / CONFIG))
    worlds = {name: load_map(published.parents[1] / entry.map) for name, entry in run.environments.items()}
    per_seed = read_per_seed(published / "tables/per_seed.csv")
    evidence = Evidence(per_seed=per_seed, worlds=worlds, **settings_of(run))
    tasks = {name: entry.tasks for name, entry in run.environments.items()}
    steps = relative_steps.relative_steps(per_seed, tasks, evidence.how)
    totals = {(row["environment"], row["tasks"], row["method"]): row for row in steps.to_dict("records")}
    metrics = read_csv(published / "tables/metrics.csv").set_index(["environment", "task", "method", "metric"])

    def saved(environment: str, tasks: str, method: str = PTL) -> str:
        return relative_steps.saved_text(totals[environment, tasks, method])

    def first(environment: str, tasks: str) -> str:
        found = saved_percent(evidence, environment, tasks, PTL, "first_episode")
        return estimate(found.value, found.low, found.high, "%")

    def ours(metric: str, method: str = PTL) -> pd.Series:
        return metrics.loc["env1", LAST_TASK, method, metric]

    def times(environment: str, tasks: str) -> str:
        row = totals[environment, tasks, FULL]
        return estimate(row["ratio"], row["low"], row["high"])

    def in_each(tasks: str, form: Callable[[str, str], str]) -> str:
        texts = [f"{form(f'env{i}', tasks)} in environment {i}" for i in (1, 2, 3)]
        return f"{texts[0]}, {texts[1]} and {texts[2]}"

    runs = int(per_seed["seed"].nunique())
    claims = read_csv(published / "claims.csv")
    lines = [
        f"**Result.** Over tasks {TRANSFER_TASKS[0]} to {TRANSFER_TASKS[-1]} together, the five that have something to"
        f" transfer, PTL saves {in_each(TRANSFER_TASKS, saved)} of the steps that learning from nothing takes; on task"
        f" {LAST_TASK}, the last one, it saves {in_each(LAST_TASK, saved)}. Full transfer's steps over all five,"
        f" as multiples of those of learning from nothing: {in_each(TRANSFER_TASKS, times)}. (Ratio of the means over"
        f" {runs} runs.)",
        "",
        f"Of the article's {len(claims)} claims, judged on [many more runs](#results) and under all readings of their"
        f" words: {counts_text(claims['class'])}. One choice of the method, what a skill does within an episode, was"
        " [made because more claims come out with it](docs/reconstruction.md#the-choice-made-because-it-fits).",
        "",
        "![Total steps relative to no transfer in three environments, for each task and method, and the classes of the"
        " claims](reports/published/figures/front.png)",
        "",
    ]
    pages = [f"[{name}](reports/published/{file})" for name, file in PAGES.items() if (published / file).is_file()]
    lines += [f"Look without building anything: {', '.join(pages)}.", ""] if pages else []
    at_end, none, full = (ours("asymptotic", method) for method in (PTL, "no_transfer", FULL))
    learned = ours("threshold_episode")
    together = f"tasks {TRANSFER_TASKS[0]} to {TRANSFER_TASKS[-1]} together"
    rows = [
        ("1", "PTL: first episode shorter", "about 80 to 90%", first("env1", TRANSFER_TASKS), first("env1", LAST_TASK)),
        ("1", "PTL: episodes until learned", "about 80 (task F)", "",
         f"{_text(learned)}, {percent(round(learned['reached'], 2))} of runs"),
        ("1", "PTL: steps saved", "more than 90%", saved("env1", TRANSFER_TASKS), saved("env1", LAST_TASK)),
        ("1", "PTL: steps per episode at the end", "fewer than with no and with full transfer", "",
         f"{_text(at_end)}; {number(round(none['mean']))} and {number(round(full['mean']))}"),
        ("1", "full transfer: steps saved", "negative", saved("env1", TRANSFER_TASKS, FULL),
         saved("env1", LAST_TASK, FULL)),
        ("2", "full transfer: steps saved", "positive", saved("env2", TRANSFER_TASKS, FULL),
         saved("env2", LAST_TASK, FULL)),
        ("3", "PTL: first episode shorter", "not improved", first("env3", TRANSFER_TASKS), first("env3", LAST_TASK)),
        ("3", "PTL: steps saved", "more than 50%", saved("env3", TRANSFER_TASKS), saved("env3", LAST_TASK)),
    ]  # fmt: skip
    header = f"| environment | {runs} runs | the article | {together} | task {LAST_TASK} alone |"
    return "\n".join([*lines, header, "|---|---|---|---|---|", *(f"| {' | '.join(row)} |" for row in rows)])


def _text(row: pd.Series) -> str:
    return estimate(row["mean"], row["ci_low"], row["ci_high"])


def classes(published: Path) -> str:
    """Return the claims by class as a Markdown table."""
    claims = read_csv(published / "claims.csv", keep_default_na=False)
    lines = ["| class | meaning | claims |", "|---|---|---|"]
    for name, count in class_counts(claims["class"]):
        own = claims[claims["class"] == name]
        texts = [
            f"{row['id']} ({row['holds_when']})" if row["holds_when"] else row["id"] for row in own.to_dict("records")
        ]
        lines.append(f"| {name} ({count}) | {CLASSES[name]} | {'; '.join(texts)} |")
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
    lines += ["", *(f"* {row['item']}: {row['source']}." for row in others)]
    return "\n".join(lines)


PARTS: dict[str, Callable[[Path], str]] = {"result": result, "classes": classes, "speed": speed}
"""What makes each part of the page, by the name in its marks."""

_PART = re.compile(r"(<!-- published: ([a-z ]+), begin -->).*?(<!-- published: \2, end -->)", re.DOTALL)


def filled(text: str, published: Path) -> str:
    """Return a page with the text between each pair of marks made anew from the published products.

    A study adds parts by a dictionary ``PARTS`` in its module ``readme``; a part that nothing makes is left empty.
    """
    parts = dict(PARTS)
    for module in modules_of_studies("readme"):
        parts |= module.PARTS

    def made(match: re.Match[str]) -> str:
        begin, name, end = match.groups()
        text = parts[name](published) if name in parts else ""
        lines = ["", text, ""] if "\n" in text else [text] if text else []
        return "\n".join([begin, *lines, end])

    return _PART.sub(made, text)
