"""A survey job: subgoals over all pairs of start and goal, or over those to some of the goals."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, Literal

import msgspec
import numpy as np
from msgspec import Meta

from ptl.files.formats import Array
from ptl.files.job import Job, Number, Positive, Watch, Word, Worlds, register
from ptl.files.outside import sources_of
from ptl.files.store import Result
from ptl.learning.starts import chosen_starts
from ptl.learning.survey import ARRAYS, add_up, subgoal_frequencies


@register
class Survey(Job, frozen=True, kw_only=True, tag="frequencies/2"):
    """Subgoals over all pairs of start and goal."""

    environment: Annotated[Word, Meta(description="name of the environment")]
    trajectories: Annotated[Positive, Meta(description="successful episodes of each task")]
    starts: Annotated[Literal["all"] | Positive, Meta(description="start states: all, or a random sample of this size")]
    batch: Annotated[Number | None, Meta(description="number of the batch; none in a file of all goals")] = None
    batches: Annotated[Positive, Meta(description="batches that the goals are shared out to")] = 1

    TITLE = "Frequency files"
    READS = ("learning",)
    ARRAYS = {  # noqa: RUF012
        "counts": Array("int64", ("n",), "pairs of start and goal whose subgoal is the state", 0),
        "unresolved": Array("int64", (), "pairs whose metric is 0 everywhere (adjacent cells)", 0),
        "pairs": Array("int64", (), "pairs in all", 0),
        "simulated_steps": Array("int64", (), "steps simulated, a small part of all steps", 0),
    }

    @property
    def place(self) -> str:
        """Path of the file below results/<run>/."""
        folder = f"subgoal_frequencies/{self.environment}"
        return f"{folder}.h5" if self.batch is None else f"{folder}/batch_{self.batch}.h5"

    @property
    def whole(self) -> Survey:
        """The job of the file in which all batches are added up."""
        return msgspec.structs.replace(self, batches=1, batch=None)

    def parts(self, batches: int) -> list[Survey]:
        """Return the jobs of the batches."""
        return [msgspec.structs.replace(self, batches=batches, batch=batch) for batch in range(batches)]

    def sources(self) -> str:
        """Return the digest of the present sources."""
        return sources_of("ptl.learning.survey")

    def run(self, worlds: Worlds, watch: Watch = iter) -> dict[str, np.ndarray]:
        """Learn all tasks to every ``batches``-th state."""
        world, name = worlds[self.environment], self.environment
        origins = self._starts(worlds)
        goals = watch(range(world.n_states)[self.batch or 0 :: self.batches])
        learning = self.settings.learning
        return subgoal_frequencies(world, origins, goals, self.trajectories, learning, self.root_seed, name)

    def sizes(self, worlds: Worlds) -> dict[str, int]:
        """Return the number of states."""
        return {"n": worlds[self.environment].n_states}

    def faults(self, arrays: Mapping[str, np.ndarray], worlds: Worlds) -> Iterator[str]:
        """Yield the impossible values."""
        if (self.batch or 0) >= self.batches:
            yield f"its batch {self.batch} is none of its {self.batches} batches"
        elif int(arrays["counts"].sum()) + int(arrays["unresolved"]) != int(arrays["pairs"]):
            yield "its counts do not add up to the number of pairs"

    def _starts(self, worlds: Worlds) -> np.ndarray:
        number = None if self.starts == "all" else self.starts
        return chosen_starts(worlds[self.environment], number, self.root_seed, self.environment)


def merged(parts: Sequence[Result]) -> dict[str, np.ndarray]:
    """Return the sums over the batches of an environment."""
    return add_up([{name: part.arrays[name] for name in ARRAYS} for part in parts])
