"""A job of the workflow, as its script sees it: files, and the groups of the configuration that it depends on."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from types import SimpleNamespace
from typing import Any, get_type_hints

from ptl.config import Configuration, Environment, ForeignResults
from ptl.errors import UserError
from ptl.files.question import asking
from ptl.files.records import write_record
from ptl.world.gridworld import GridWorld, load_map

GROUPS = get_type_hints(Configuration)
"""Type of each group of the configuration."""


@dataclass(frozen=True)
class Job:
    """The files and settings of one job.

    Attributes
    ----------
    input, output : namespace
        Files by the names that the rule gives them.
    groups : namespace
        Groups of the configuration (``groups.statistics.confidence``); only those that the rule passes on.
    environments : mapping
        Entry of the configuration of each environment, in the order of the report.
    methods : list of str
        Methods in the order of the report.
    foreign : mapping
        Entry of the configuration of each method that another program has run.
    own_looks : mapping
        Label and colour of each method of the run.
    """

    input: Any
    output: Any
    groups: SimpleNamespace
    environments: Mapping[str, Environment]
    methods: list[str]
    foreign: Mapping[str, ForeignResults] = field(default_factory=dict)
    own_looks: Mapping[str, tuple[str, str]] = field(default_factory=dict)

    @classmethod
    def of(cls, snakemake: Any) -> Job:
        """Read the job from the object that Snakemake gives to a script."""
        given = dict(snakemake.params.items())
        return cls(
            snakemake.input,
            snakemake.output,
            SimpleNamespace(**{name: GROUPS[name].from_dict(group) for name, group in given.get("groups", {}).items()}),
            {name: Environment.from_dict(entry) for name, entry in given.get("environments", {}).items()},
            list(given.get("methods", ())),
            {name: ForeignResults.from_dict(entry) for name, entry in given.get("foreign", {}).items()},
            {name: (label, colour) for name, (label, colour) in given.get("looks", {}).items()},
        )

    @property
    def worlds(self) -> dict[str, GridWorld]:
        """The world of each environment, read from its map."""
        return {name: load_map(entry.map) for name, entry in self.environments.items()}

    @property
    def looks(self) -> dict[str, tuple[str, str]]:
        """Label and colour of each method, those of other programs last."""
        from ptl.report.figures.style import CATEGORIES

        return {
            **self.own_looks,
            **{
                name: (entry.label, entry.colour or CATEGORIES[place % len(CATEGORIES)])
                for place, (name, entry) in enumerate(self.foreign.items())
            },
        }

    @property
    def titles(self) -> dict[str, str]:
        """The name of each environment as readers see it."""
        return {name: entry.title for name, entry in self.environments.items()}

    @property
    def last_tasks(self) -> dict[str, str]:
        """The task that each environment teaches last."""
        return {name: entry.tasks[-1] for name, entry in self.environments.items()}


@contextmanager
def running(snakemake: Any) -> Iterator[Job]:
    """Run a script's block with stderr in the log file of the rule; end with one line and status 1 on a `UserError`.

    Result files that the block reads must answer the question in the parameter ``asked``. When the block has ended, a
    record of the job is kept for the run's manifest.
    """
    with Path(snakemake.log[0]).open("w", encoding="utf-8") as log:
        os.dup2(log.fileno(), sys.stderr.fileno())
    try:
        params = dict(snakemake.params.items())
        with asking(params.get("asked", {})):
            yield Job.of(snakemake)
        write_record(
            Path("results", str(snakemake.config.get("run", snakemake.rule))),
            ".".join([snakemake.rule, *snakemake.wildcards]),
            snakemake.rule,
            params,
            snakemake.input,
            snakemake.output,
        )
    except UserError as error:
        sys.exit(f"error: {error}")
