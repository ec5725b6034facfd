"""The first page of the report: what was asked, what was found, how to read the rest."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd

VERDICTS = ("reproduced", "partly reproduced", "not reproduced", "undecided")

ASKED = """\
An article (DOI `10.1177/1729881419831555 <https://doi.org/10.1177/1729881419831555>`_) proposes **partial transfer
learning** (PTL): a robot learns navigation tasks one after another, keeps policies that reach bottleneck states in a
growing **skill library**, and draws skills from it when a new task comes. Does that help, against no transfer, full
transfer and probabilistic policy reuse, in three grid worlds? The article's equations, maps and parameters are lost;
they are reconstructed here, and ``docs/reconstruction.md`` says what is the article's and what is ours.
"""

READING = """\
**Verdicts** hold each claim of the article against this run. **Figures** and **Tables** carry the article's numbers.
The **Explorer** shows single learners at work: start there to see why a skill library helps. **Checks** repeat an
experiment of the authors of policy reuse, to show that the strongest rival is implemented rightly. Each item says in
its caption how many runs it shows, what its interval is, and which rule and file made it. Environments and methods keep
their order and colours everywhere.
"""


def compose(
    claims: pd.DataFrame,
    metrics: pd.DataFrame,
    titles: Mapping[str, str],
    last_tasks: Mapping[str, str],
    labels: Mapping[str, str],
) -> str:
    """The page as reStructuredText.

    Parameters
    ----------
    claims : DataFrame
        Columns id, claim, verdict.
    metrics : DataFrame
        The tidy table of estimates.
    titles, last_tasks : mapping
        Title and last task of each environment.
    labels : mapping
        Name of each method as it is shown.
    """  # fmt: skip
    counts = claims["verdict"].value_counts()
    found = ", ".join(f"**{counts[verdict]} {verdict}**" for verdict in VERDICTS if verdict in counts)
    failing = claims.loc[claims["verdict"] == "not reproduced", "id"]
    parts = [
        _heading("Partial transfer learning: a reproduction"),
        "**What was asked.** " + ASKED,
        f"**What was found.** Of {len(claims)} claims, {found}.",
    ]
    if len(failing):
        parts.append("Not reproduced: " + ", ".join(failing) + ".")
    parts += [_main_table(metrics, titles, last_tasks, labels), "**How to read the rest.** " + READING]
    return "\n\n".join(part.strip() for part in parts) + "\n"


def _heading(text: str) -> str:
    rule = "=" * len(text)
    return f"{rule}\n{text}\n{rule}"


def _main_table(
    metrics: pd.DataFrame, titles: Mapping[str, str], last_tasks: Mapping[str, str], labels: Mapping[str, str]
) -> str:
    seeds = int(metrics["seeds"].max())
    rows = [["Method", *(f"{titles[name]}, task {task}" for name, task in last_tasks.items())]]
    chosen = metrics[metrics["metric"] == "transfer_ratio"].set_index(["environment", "task", "method"])
    for method, label in labels.items():
        if method != "no_transfer":
            cells = [_interval(chosen, (name, task, method)) for name, task in last_tasks.items()]
            rows.append([label, *cells])
    lines = [
        f".. list-table:: Transfer ratio on the last task: mean of {seeds} seeds with its interval; above 0 is better"
        " than no transfer, 1 would be perfect",
        "   :header-rows: 1",
        "",
    ]
    for row in rows:
        lines += [f"   {'* - ' if column == 0 else '  - '}{cell}" for column, cell in enumerate(row)]
    return "\n".join(lines)


def _interval(chosen: pd.DataFrame, place: tuple[str, str, str]) -> str:
    if place not in chosen.index:
        return "not in this run"
    row = chosen.loc[place]
    if pd.isna(row["mean"]):
        return "no base in this run"
    if pd.isna(row["ci_low"]):
        return f"{row['mean']:.2f}"
    return f"{row['mean']:.2f} [{row['ci_low']:.2f}, {row['ci_high']:.2f}]"
