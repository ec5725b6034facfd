"""The evidence of a run, read from the files that its workflow has made."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from ptl.claims.evidence import Evidence, settings_of
from ptl.files.store import Result
from ptl.measures import run_files
from ptl.world.gridworld import GridWorld


def read_evidence(
    worlds: Mapping[str, GridWorld],
    groups: Any,
    *,
    per_seed: str | Path,
    steps: str | Path | None = None,
    subgoals: str | Path | None = None,
    growth: str | Path | None = None,
    survey: Iterable[Result] = (),
    selection_cost: str | Path | None = None,
    library_bytes: str | Path | None = None,
) -> Evidence:
    """Read a run's files; those left out make the claims that need them undecided.

    Parameters
    ----------
    worlds : mapping of str to GridWorld
    groups : namespace
        See `ptl.claims.evidence.settings_of`.
    per_seed, steps, subgoals, growth, selection_cost, library_bytes : paths
    survey : iterable of Result
        Subgoal frequencies of each environment.

    Raises
    ------
    UserError
        When a file is missing, unreadable or lacks a column.
    """
    return Evidence(
        per_seed=run_files.read_per_seed(per_seed),
        worlds=worlds,
        steps=None if steps is None else run_files.read_steps(steps),
        subgoals=None if subgoals is None else run_files.read_subgoals(subgoals),
        growth=None if growth is None else run_files.read_sizes(growth),
        frequencies={result.job.environment: result.arrays["counts"] for result in survey},
        selection_cost=None if selection_cost is None else run_files.read_selection(selection_cost),
        library_bytes=None if library_bytes is None else run_files.read_storage(library_bytes),
        **settings_of(groups),
    )
