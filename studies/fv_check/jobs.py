"""The configuration of the check, and its kind of job: the trials with one library."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from msgspec import Meta

from ptl.config import PATH, RUN_NAME, Statistics
from ptl.files.formats import Array
from ptl.files.job import Job, Positive, Watch, Worlds, register
from ptl.files.outside import sources_of
from ptl.files.store import Result
from ptl.keys import Group, key
from studies.fv_check.experiment import LIBRARIES, PARAMETERS, PLAIN, REUSE, PastTasks, learn_library

MAP = "env3"
"""Name of the map among those of a job."""

SOURCES = ("studies.fv_check.experiment", *(f"ptl.methods.{name}" for name in (REUSE, PLAIN)))
"""Modules that determine what is learned."""


class FvCheck(Group, frozen=True, kw_only=True):
    """The configuration of the check."""

    run: Annotated[str, key("Name of the run.", **RUN_NAME)]
    map: Annotated[str, key("Text file of the map, with goals A to F.", **PATH)]
    seeds: Annotated[int, key("Learning runs with each library.", ge=1, le=10**5)]
    root_seed: Annotated[int, key("Seed from which every random stream derives.", ge=0, le=2**63 - 1)]
    trials: Annotated[int, key("Trials on the new task.", ge=1, le=10**6)]
    library_trials: Annotated[int, key("Trials in which each policy of a library is learned.", ge=1, le=10**6)]
    statistics: Statistics = Statistics()


@register
class Trials(Job, frozen=True, kw_only=True, tag="trials/1"):
    """Trials on the new task with one library of policies: $s$ seeds, $k$ trials, $t$ past tasks."""

    library: Annotated[
        str, Meta(description="past tasks whose policies it holds, none for plain Q-learning", pattern="^[1-5]*$")
    ]
    seeds: Annotated[Positive, Meta(description="learning runs")]
    trials: Annotated[Positive, Meta(description="trials on the new task")]
    library_trials: Annotated[Positive, Meta(description="trials in which each policy of the library is learned")]

    TITLE = "Trials of the check of policy reuse"
    READS = ("learning", "policy_reuse")
    ARRAYS = {  # noqa: RUF012
        "seeds": Array("int64", ("s",), "seeds, in the order of the rows", 0),
        "gain": Array("float64", ("s", "k"), "discounted gain of each trial", 0, 1),
        "policy_quality": Array(
            "float64",
            ("s", "t"),
            "mean gain of each past policy in its own task, as a share of the optimum",
            0,
            1.000001,
        ),
    }

    @property
    def place(self) -> str:
        """Path of the file below results/<run>/."""
        return f"trials/{f'library_{self.library}' if self.library else 'q_learning'}.h5"

    def sources(self) -> str:
        """Return the digest of the present sources."""
        return sources_of(*SOURCES)

    def run(self, worlds: Worlds, watch: Watch = iter) -> dict[str, np.ndarray]:
        """Learn the library's policies and then the new task, seed by seed."""
        seeds = range(self.seeds)
        lives = [
            learn_library(
                worlds[MAP], self.library, self.settings, self.root_seed, seed, self.trials, self.library_trials
            )
            for seed in watch(seeds)
        ]
        return {
            "seeds": np.array(seeds, dtype=np.int64),
            "gain": np.array([gains for gains, _ in lives]),
            "policy_quality": np.array([quality for _, quality in lives]),
        }

    def sizes(self, worlds: Worlds) -> dict[str, int]:
        """Return the numbers of seeds, trials and past tasks."""
        return {"s": self.seeds, "k": self.trials, "t": len(self.library)}

    def faults(self, arrays: Mapping[str, np.ndarray], worlds: Worlds) -> Iterator[str]:
        """Yield the impossible values."""
        if (arrays["seeds"] != np.arange(self.seeds)).any():
            yield "its seeds are not 0, 1, 2, ..."


def trials_jobs(check: FvCheck, map_digest: str) -> dict[str, Trials]:
    """Return the job of each library by place."""
    parameters = {name: getattr(PARAMETERS, name).to_dict() for name in Trials.READS}
    jobs = [
        Trials(
            root_seed=check.root_seed,
            parameters=parameters,
            maps={MAP: map_digest},
            code=sources_of(*SOURCES),
            library=library.tasks,
            seeds=check.seeds,
            trials=check.trials,
            library_trials=check.library_trials,
        )
        for library in LIBRARIES
    ]
    return {job.place: job for job in jobs}


# -- reading ------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Gains:
    """Trials with one library: gains (seeds, trials) and quality of the library's policies (seeds, past tasks)."""

    library: PastTasks
    gain: np.ndarray
    quality: np.ndarray

    @property
    def mean_gain(self) -> np.ndarray:
        """W over the first k trials for k = 1, 2, ..., float array (seeds, trials)."""
        return np.cumsum(self.gain, axis=1) / np.arange(1, self.gain.shape[1] + 1)


def gains_of(results: Iterable[Result]) -> list[Gains]:
    """Return the trials in result files."""
    libraries = {library.tasks: library for library in LIBRARIES}
    return [
        Gains(libraries[result.job.library], result.arrays["gain"], result.arrays["policy_quality"])
        for result in results
    ]
