"""A script of the workflow: its files, and the groups of the configuration that its rule passes on."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from types import SimpleNamespace
from typing import Any, get_type_hints

from ptl.config import Configuration, Environment, ForeignResults, Parameters
from ptl.errors import INTERRUPTED, UserError
from ptl.files.job import Job
from ptl.files.store import Result, read
from ptl.jobs.kinds import unpacked
from ptl.world.gridworld import GridWorld, map_digest
from ptl.world.map_files import read_map

GROUPS = get_type_hints(Configuration)
"""Type of each group of the configuration."""


@dataclass(frozen=True)
class Script:
    """The files and settings of one job that is a script.

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
    maps : mapping
        Digest of the map of each environment when the run was planned.
    jobs : list of Job
        Jobs that must have made the result files among the inputs.
    """

    input: Any
    output: Any
    groups: SimpleNamespace
    environments: Mapping[str, Environment]
    methods: list[str]
    foreign: Mapping[str, ForeignResults] = field(default_factory=dict)
    own_looks: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    maps: Mapping[str, str] = field(default_factory=dict)
    jobs: list[Job] = field(default_factory=list)

    @classmethod
    def of(cls, snakemake: Any) -> Script:
        """Read them from the object that Snakemake gives to a script."""
        given = dict(snakemake.params.items())
        return cls(
            snakemake.input,
            snakemake.output,
            SimpleNamespace(**{name: GROUPS[name].from_dict(group) for name, group in given.get("groups", {}).items()}),
            {name: Environment.from_dict(entry) for name, entry in given.get("environments", {}).items()},
            list(given.get("methods", ())),
            {name: ForeignResults.from_dict(entry) for name, entry in given.get("foreign", {}).items()},
            {name: (label, colour) for name, (label, colour) in given.get("looks", {}).items()},
            given.get("maps", {}),
            unpacked(given["jobs"]) if "jobs" in given else [],
        )

    @cached_property
    def worlds(self) -> dict[str, GridWorld]:
        """The world of each environment, read from its map.

        Raises
        ------
        UserError
            If a map has changed since the run was planned.
        """
        worlds = {name: read_map(entry.map, entry.map_options).world for name, entry in self.environments.items()}
        for name, world in worlds.items():
            if map_digest(world.text) != self.maps.get(name, map_digest(world.text)):
                raise UserError(
                    f"{self.environments[name].map}: was changed during the run; run the same command again"
                )
        return worlds

    def results(self, paths: Iterable[str | os.PathLike[str]]) -> Iterator[Result]:
        """Yield the result files at these paths, each made by the job of its place.

        Raises
        ------
        UserError
            If a file cannot be used, or was made by another job.
        """
        for path in paths:
            parts = Path(path).parts
            places = ("/".join(parts[start:]) for start in range(len(parts)))
            yield read(path, next(self._by_place[place] for place in places if place in self._by_place))

    @cached_property
    def _by_place(self) -> dict[str, Job]:
        return {job.place: job for job in self.jobs}

    @property
    def parameters(self) -> Parameters:
        """Hyper-parameters, with defaults for groups that the rule does not pass on."""
        return Parameters(**{name: own for name, own in vars(self.groups).items() if hasattr(Parameters, name)})

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
def running(snakemake: Any) -> Iterator[Script]:
    """Run a script's block with stderr in the log file of the rule; end with one line and status 1 on a `UserError`."""
    with Path(snakemake.log[0]).open("w", encoding="utf-8") as log:
        os.dup2(log.fileno(), sys.stderr.fileno())
    try:
        yield Script.of(snakemake)
    except UserError as error:
        sys.exit(f"error: {error}")
    except KeyboardInterrupt:
        sys.exit(f"error: {INTERRUPTED}")
