"""Many lives in one job, stored as the few arrays that verdicts need."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated, ClassVar

import numpy as np
from msgspec import Meta

from ptl.files.formats import Array
from ptl.files.job import Job, Number, Positive, Watch, Word, Worlds, register
from ptl.files.outside import learning_code
from ptl.jobs.grow import grows
from ptl.jobs.learn import episode_faults
from ptl.learning.growth import METHOD
from ptl.learning.lives import grow_lives, learn_lives
from ptl.world.gridworld import GridWorld

STREAM = "robustness"
"""First name of the random streams, so that lives which decide claims differ from those of the tables."""

LIVES = {
    "seeds": Array("int64", ("s",), "seeds, in the order of the rows", 0),
    "steps": Array("int64", ("s", "t", "e"), "steps of each task and episode", 0),
    "truncated": Array("int64", ("s", "t"), "episodes that hit the step limit", 0, "e"),
    "subgoal": Array("int64", ("s", "t"), "state added to the library, −1 if none", -1, "n-1", True),
    "novelty": Array("float64", ("s", "t"), "mean length of the unknown rests of the paths", 0, None, True),
    "metric_value": Array("float64", ("s", "t"), "greatest value of the incremental metric", 0, 1, True),
    "reason": Array("bytes", ("s", "t"), "why a state was added, or why not", optional=True),
    "incremental_peak": Array("int64", ("s", "t"), "state where the incremental metric is greatest", -1, "n-1", True),
    "original_peak": Array("int64", ("s", "t"), "state where the original metric is greatest", -1, "n-1", True),
}
"""Arrays of `ptl.learning.lives.learn_lives`; the last six only of methods that keep a library."""

LIBRARY_SIZE = Array("int64", ("r", "g"), "skills after 0, 1, ... tasks of each life", 0)


@register
class Lives(Job, frozen=True, kw_only=True, tag="lives/3"):
    """Lives of one method in one environment that one look adds to those of the looks before."""

    name: Annotated[Word, Meta(description="name of the job, and of its random streams")]
    environment: Annotated[Word, Meta(description="name of the environment")]
    tasks: Annotated[
        str, Meta(description="goal letters in the order in which they are learned", pattern="^[A-HJ-Z]+$")
    ]
    method: Annotated[str, Meta(description="identifier of the method")]
    look: Annotated[Positive, Meta(description="look that needs them, from 1")]
    first: Annotated[Number, Meta(description="first seed")]
    seeds: Annotated[Positive, Meta(description="lives")]

    TITLE = "Lives that decide claims"
    READS = ("learning", "skills", "subgoals", "policy_reuse", "full_transfer")
    ARRAYS = LIVES

    @property
    def place(self) -> str:
        """Path of the file below results/<run>/."""
        return f"decision/{self.name}_{self.look}.h5"

    @property
    def pair(self) -> tuple[str, str]:
        """Environment and method."""
        return self.environment, self.method

    def sources(self) -> str:
        """Return the digest of the present sources."""
        return learning_code(self.method, "ptl.learning.lives")

    def run(self, worlds: Worlds, watch: Watch = iter) -> dict[str, np.ndarray]:
        """Learn the lives."""
        names = STREAM, self.name, self.environment
        seeds = watch(range(self.first, self.first + self.seeds))
        world = worlds[self.environment]
        return learn_lives(world, self.tasks, self.method, self.settings, self.root_seed, seeds, *names)

    def sizes(self, worlds: Worlds) -> dict[str, int]:
        """Return the numbers of lives, tasks, episodes and states."""
        states, episodes = worlds[self.environment].n_states, self.settings.learning.episodes
        return {"s": self.seeds, "t": len(self.tasks), "e": episodes, "n": states}

    def faults(self, arrays: Mapping[str, np.ndarray], worlds: Worlds) -> Iterator[str]:
        """Yield the impossible values."""
        limit = self.settings.learning.max_steps
        yield from lives_faults(arrays, worlds[self.environment], self.tasks, limit, self.first)


def lives_faults(
    arrays: Mapping[str, np.ndarray], world: GridWorld, tasks: str, limit: int, first: int = 0
) -> Iterator[str]:
    """Yield the impossible values in the arrays `LIVES`."""
    if (arrays["seeds"] != first + np.arange(len(arrays["seeds"]))).any():
        yield f"its seeds are not {first}, {first + 1}, {first + 2}, ..."
    shortest = world.distances_to(world.start)[[world.goal(letter) for letter in tasks]]
    for place, steps in enumerate(np.moveaxis(arrays["steps"], 1, 0)):
        yield from (f"task {tasks[place]}: {fault}" for fault in episode_faults(steps, int(shortest[place]), limit))
    if (arrays["truncated"] > (arrays["steps"] == limit).sum(axis=2)).any():
        yield f"more episodes are truncated than have learning.max_steps ({limit}) steps"


@register
class Libraries(Job, frozen=True, kw_only=True, tag="libraries/3"):
    """Growth of the libraries of many lives of random tasks that one look adds."""

    environment: Annotated[Word, Meta(description="name of the environment")]
    tasks: Annotated[Positive, Meta(description="tasks in one life")]
    look: Annotated[Positive, Meta(description="look that needs them, from 1")]
    first: Annotated[Number, Meta(description="number of the first life")]
    runs: Annotated[Positive, Meta(description="lives")]

    TITLE = "Libraries that decide claims"
    READS = ("learning", "skills", "subgoals", "policy_reuse")
    ARRAYS = {"library_size": LIBRARY_SIZE}  # noqa: RUF012
    NAME: ClassVar[str] = "growth"

    @property
    def place(self) -> str:
        """Path of the file below results/<run>/."""
        return f"decision/{self.NAME}_{self.look}.h5"

    @property
    def pair(self) -> tuple[str, str]:
        """Environment, and the name that stands for the growing library."""
        return self.environment, self.NAME

    def sources(self) -> str:
        """Return the digest of the present sources."""
        return learning_code(METHOD, "ptl.learning.lives")

    def run(self, worlds: Worlds, watch: Watch = iter) -> dict[str, np.ndarray]:
        """Learn the tasks, with a library that starts empty in each life."""
        world, runs = worlds[self.environment], watch(range(self.first, self.first + self.runs))
        names = STREAM, self.NAME
        sizes = grow_lives(world, self.environment, self.tasks, self.settings, self.root_seed, runs, *names)
        return {"library_size": sizes}

    def sizes(self, worlds: Worlds) -> dict[str, int]:
        """Return the numbers of lives and of sizes in each."""
        return {"r": self.runs, "g": self.tasks + 1}

    def faults(self, arrays: Mapping[str, np.ndarray], worlds: Worlds) -> Iterator[str]:
        """Yield the impossible values."""
        if not grows(arrays["library_size"]):
            yield "a library does not grow from 0 by at most one skill a task"
