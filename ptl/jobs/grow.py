"""A growth job: one life of many tasks with random start and goal."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated

import numpy as np
from msgspec import Meta

from ptl.files.formats import Array
from ptl.files.job import Job, Number, Positive, Watch, Word, Worlds, register
from ptl.files.outside import learning_code
from ptl.jobs.learn import LIBRARY, library_arrays, library_faults
from ptl.learning.growth import METHOD, grow_library


@register
class Grow(Job, frozen=True, kw_only=True, tag="growth/2"):
    """One life of many random tasks; Q-tables are left out."""

    environment: Annotated[Word, Meta(description="name of the environment")]
    tasks: Annotated[Positive, Meta(description="tasks in the life")]
    seed: Annotated[Number, Meta(description="number of the life")]

    TITLE = "Growth files"
    READS = ("learning", "skills", "subgoals", "policy_reuse")
    ARRAYS = {  # noqa: RUF012
        "starts": Array("int32", ("t",), "start of each task", 0, "n-1"),
        "goals": Array("int32", ("t",), "goal of each task", 0, "n-1"),
        "library_size": Array("int64", ("t+1",), "skills before the first task and after each", 0, "t"),
        "total_steps": Array("int64", ("t",), "steps of all episodes of each task", 0),
        **LIBRARY,
    }

    @property
    def place(self) -> str:
        """Path of the file below results/<run>/."""
        return f"growth/run_{self.seed:03d}.h5"

    def sources(self) -> str:
        """Return the digest of the present sources."""
        return learning_code(METHOD, "ptl.learning.growth")

    def run(self, worlds: Worlds, watch: Watch = iter) -> dict[str, np.ndarray]:
        """Learn the tasks with a library that starts empty."""
        world = worlds[self.environment]
        life = grow_library(world, self.tasks, self.settings, self.root_seed, self.environment, self.seed, watch=watch)
        assert life.library is not None
        records = life.records
        added = [record.update.subgoal >= 0 for record in records]
        return {
            "starts": np.array([record.task.start for record in records], dtype=np.int32),
            "goals": np.array([record.task.goal for record in records], dtype=np.int32),
            "library_size": np.concatenate([[0], np.cumsum(added)]).astype(np.int64),
            "total_steps": np.array([record.steps.sum() for record in records], dtype=np.int64),
            **library_arrays(life.library, world.n_states),
        }

    def sizes(self, worlds: Worlds) -> dict[str, int]:
        """Return the numbers of states and of tasks."""
        return {"n": worlds[self.environment].n_states, "t": self.tasks}

    def faults(self, arrays: Mapping[str, np.ndarray], worlds: Worlds) -> Iterator[str]:
        """Yield the impossible values."""
        world, learning = worlds[self.environment], self.settings.learning
        if not grows(arrays["library_size"]):
            yield "its library does not grow from 0 by at most one skill a task"
        if len(arrays["library/subgoals"]) != arrays["library_size"][-1]:
            yield "its library is not of the size that it says"
        pairs = zip(arrays["starts"], arrays["goals"], strict=True)
        shortest = np.array([world.shortest_path_length(*pair) for pair in pairs])
        least = learning.episodes * np.minimum(shortest, learning.max_steps)
        if (shortest <= 0).any() or (arrays["total_steps"] < least).any():
            yield "a task took fewer steps than its shortest path in every episode, or has none"
        yield from library_faults(arrays, world, self.tasks)


def grows(sizes: np.ndarray) -> bool:
    """Return whether libraries (last axis) grow from 0 by at most one skill a task."""
    return not sizes[..., 0].any() and bool(np.isin(np.diff(sizes), (0, 1)).all())
