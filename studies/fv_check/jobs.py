"""The configuration of the check, and its kinds of jobs: trials with one library, and readings of the experiment."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal

import numpy as np
from msgspec import Meta

from ptl.config import PATH, RUN_NAME, Statistics
from ptl.files.formats import Array
from ptl.files.job import Job, Positive, Watch, Worlds, register
from ptl.files.outside import sources_of
from ptl.files.store import Result
from ptl.keys import Group, key
from studies.fv_check import readings
from studies.fv_check.experiment import LIBRARIES, PARAMETERS, PLAIN, REUSE, PastTasks, learn_library
from studies.fv_check.readings import SHOWN, TASKS, Reading
from studies.fv_check.simulator import MOTIONS, TIES

MAP = "env3"
"""Name of the map among those of a job."""

SOURCES = ("studies.fv_check.experiment", *(f"ptl.methods.{name}" for name in (REUSE, PLAIN)))
"""Modules that determine what the package's class learns."""

SIMULATED = ("studies.fv_check.readings",)
"""Modules that determine what is learned under the readings."""

ARMS = 1 + max(len(library.tasks) for library in SHOWN)
"""Arms of the largest library: the new policy and past ones."""


class FvCheck(Group, frozen=True, kw_only=True):
    """The configuration of the check."""

    run: Annotated[str, key("Name of the run.", **RUN_NAME)]
    map: Annotated[str, key("Text file of the map, with goals A to F.", **PATH)]
    seeds: Annotated[int, key("Learning runs with each library.", ge=1, le=10**5)]
    root_seed: Annotated[int, key("Seed from which every random stream derives.", ge=0, le=2**63 - 1)]
    trials: Annotated[int, key("Trials on the new task.", ge=1, le=10**6)]
    library_trials: Annotated[int, key("Trials in which each policy of a library is learned.", ge=1, le=10**6)]
    reading_runs: Annotated[int, key("Runs with each library under each reading.", ge=1, le=10**4)]
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


@register
class Readings(Job, frozen=True, kw_only=True, tag="readings/1"):
    """Trials under one reading of the motion: $c$ rules for ties, $l$ libraries, $s$ runs, $a$ arms, $p$ past tasks."""

    motion: Annotated[
        Literal["exact", "noisy", "noisy_end"], Meta(description="how the robot moves: exact, noisy or noisy_end")
    ]
    runs: Annotated[Positive, Meta(description="runs with each library and each rule for ties")]
    trials: Annotated[Positive, Meta(description="trials on the new task")]

    TITLE = "Readings of the check of policy reuse"
    READS = ("learning", "policy_reuse")
    ARRAYS = {  # noqa: RUF012
        "gain": Array("float64", ("c", "l", "s"), "mean gain over all trials", 0, 1),
        "arm_gain": Array(
            "float64", ("c", "l", "s", "a"), "mean gain of the trials of each arm, the new policy first", 0, 1
        ),
        "arm_trials": Array("int64", ("c", "l", "s", "a"), "trials of each arm; 0 for arms that a library lacks", 0),
        "policy_quality": Array(
            "float64",
            ("c", "p"),
            "mean gain of each past policy in its own task, relative to the optimum without noise",
            0,
        ),
    }

    @property
    def place(self) -> str:
        """Path of the file below results/<run>/."""
        return f"readings/{self.motion}.h5"

    def sources(self) -> str:
        """Return the digest of the present sources."""
        return sources_of(*SIMULATED)

    def run(self, worlds: Worlds, watch: Watch = iter) -> dict[str, np.ndarray]:
        """Learn the new task in all runs at once."""
        return readings.simulate(worlds[MAP], self.motion, self.settings, self.root_seed, self.runs, self.trials, watch)

    def sizes(self, worlds: Worlds) -> dict[str, int]:
        """Return the numbers of rules, libraries, runs, arms and past policies."""
        return {"c": len(TIES), "l": len(SHOWN), "s": self.runs, "a": ARMS, "p": len(TASKS)}

    def faults(self, arrays: Mapping[str, np.ndarray], worlds: Worlds) -> Iterator[str]:
        """Yield the impossible values."""
        if (arrays["arm_trials"].sum(axis=-1) != self.trials).any():
            yield f"the trials of the arms are not {self.trials} in all"


def jobs_of(check: FvCheck, map_digest: str) -> dict[str, Job]:
    """Return all jobs by place: the trials of the package's class with each library, and the readings."""
    parameters = {name: getattr(PARAMETERS, name).to_dict() for name in Trials.READS}
    given: dict[str, Any] = {
        "root_seed": check.root_seed,
        "parameters": parameters,
        "maps": {MAP: map_digest},
        "trials": check.trials,
    }
    jobs: list[Job] = [
        Trials(
            **given,
            code=sources_of(*SOURCES),
            library=library.tasks,
            seeds=check.seeds,
            library_trials=check.library_trials,
        )
        for library in LIBRARIES
    ]
    code = sources_of(*SIMULATED)
    jobs += [
        Readings(**given, code=code, motion=motion, runs=check.reading_runs)  # type: ignore[arg-type]
        for motion in MOTIONS
    ]
    return {job.place: job for job in jobs}


# -- reading ------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Gains:
    """Trials with one library: gains (seeds, trials) and quality of the library's policies (seeds, past tasks)."""

    job: Trials
    library: PastTasks
    gain: np.ndarray
    quality: np.ndarray


def gains_of(results: Iterable[Result]) -> list[Gains]:
    """Return the trials in result files of the kind `Trials`."""
    libraries = {library.tasks: library for library in LIBRARIES}
    return [
        Gains(result.job, libraries[result.job.library], result.arrays["gain"], result.arrays["policy_quality"])
        for result in results
        if isinstance(result.job, Trials)
    ]


def readings_of(results: Iterable[Result]) -> list[Reading]:
    """Return the readings in result files of the kind `Readings`, one for each motion and rule for ties."""
    return [
        Reading(
            result.job.motion,
            ties,
            *(result.arrays[name][index] for name in ("gain", "arm_gain", "arm_trials", "policy_quality")),
        )
        for result in results
        if isinstance(result.job, Readings)
        for index, ties in enumerate(TIES)
    ]
