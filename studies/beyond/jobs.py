"""The kind of job of the second study: lives of one method on some maps of a family, in one file."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated

import numpy as np
from msgspec import Meta

from ptl import methods
from ptl.errors import UserError
from ptl.files.formats import Array
from ptl.files.job import Job, Number, Positive, Watch, Word, Worlds, register
from ptl.files.outside import learning_code
from ptl.files.provenance import LEARNING
from ptl.world.gridworld import GridWorld
from ptl.world.mazes import FAMILIES
from studies.beyond.lives import NO_CHANGE, last_episodes, lives_on_maps, variant
from studies.beyond.maps import SEQUENCES, checked_map

LIVES = "studies.beyond.lives"
"""Module on which the lives of all methods depend."""


@register
class LivesOnMaps(Job, frozen=True, kw_only=True, tag="map_lives/3"):
    """Lives of one method on some maps of a family: $m$ maps, $s$ lives on each, $t$ tasks.

    Generated maps are made anew; ``maps`` has the digest of each, with increasing tasks, by its seed. A given map is an
    input, and ``maps`` has its digest by its name.
    """

    family: Annotated[Word, Meta(description="family of the maps")]
    size: Annotated[Number, Meta(description="wanted number of states of generated maps, 0 for a given map")]
    sequence: Annotated[Word, Meta(description="order in which the goals come")]
    tasks: Annotated[
        str, Meta(description="goal letters in the order in which they are learned", pattern="^[A-HJ-Z]+$")
    ]
    seeds: Annotated[Positive, Meta(description="lives on each map")]
    method: Annotated[Word, Meta(description="identifier of the method")]
    reference: Annotated[str, Meta(description="where the method is, see `ptl.methods`")]
    per_task: Annotated[Number, Meta(description="skills added after each task, 0 for the method as it is")] = 0
    change: Annotated[Word, Meta(description="rule by which a map changes between tasks, or none")] = NO_CHANGE

    TITLE = "Lives of the second study"
    READS = ("learning", "skills", "subgoals", "policy_reuse", "full_transfer")
    ARRAYS = {  # noqa: RUF012
        "steps": Array("int64", ("m", "s", "t"), "steps of all episodes of each task", 0),
        "first": Array("int64", ("m", "s", "t"), "steps of the first episode", 0),
        "last": Array("int64", ("m", "s", "t"), "steps of the last tenth of the episodes, at least one", 0),
        "truncated": Array("int64", ("m", "s", "t"), "episodes that hit the step limit", 0, "e"),
        "library_size": Array("int64", ("m", "s", "t"), "skills in the library after the task", 0),
        "shortest": Array("int64", ("m", "t"), "shortest path of each task", 1),
        "optimum": Array("float64", ("m", "t"), "expected steps of the best policy of each task", 1),
        "states": Array("int64", ("m",), "states of the map", 2),
        "winding": Array("float64", ("m",), "mean over the goals of shortest path / straight line", 1),
    }

    @property
    def places(self) -> list[str]:
        """Names of the maps in the order of the rows: seeds of generated maps, the name of a given one."""
        return sorted(self.maps, key=int) if self.size else list(self.maps)

    @property
    def place(self) -> str:
        """Path of the file below results/<run>/."""
        method = self.method + (f"_x{self.per_task}" if self.per_task else "")
        harder = f"_slip{self.slip:g}" * bool(self.slip) + f"_{self.change}" * (self.change != NO_CHANGE)
        return f"lives/{self.family}_{self.size}_{self.sequence}{harder}/{method}/{self.places[0]}.h5"

    def sources(self) -> str | None:
        """Return the digest of the present sources; None for a method that only an import would find."""
        known = ":" not in self.reference or self.reference.startswith(LEARNING)
        return learning_code(self.reference, LIVES) if known else None

    def run(self, worlds: Worlds, watch: Watch = iter) -> dict[str, np.ndarray]:
        """Learn the lives, map after map.

        Raises
        ------
        UserError
            If there is no such map or method, or a generated map is not the one that was planned.
        """
        kind = variant(self.reference, self.per_task)
        names = (self.family, self.size, self.sequence)
        made = ((self._name(place), self._world(place, worlds)) for place in watch(self.places))
        with methods.reporting_errors_of(self.reference):
            return lives_on_maps(
                made, self.tasks, kind, self.settings, self.root_seed, self.seeds, *names, change=self.change
            )

    def sizes(self, worlds: Worlds) -> dict[str, int]:
        """Return the numbers of maps, lives, tasks and episodes."""
        return {"m": len(self.maps), "s": self.seeds, "t": len(self.tasks), "e": self.settings.learning.episodes}

    def faults(self, arrays: Mapping[str, np.ndarray], worlds: Worlds) -> Iterator[str]:
        """Yield the impossible values."""
        learning, shortest = self.settings.learning, arrays["shortest"][:, None, :]
        least = np.minimum(shortest, learning.max_steps)
        for name, episodes in (("steps", learning.episodes), ("first", 1), ("last", last_episodes(self.settings))):
            if (arrays[name] < episodes * least).any():
                yield f"{name}: a task took fewer steps than its shortest path"
            if (arrays[name] > episodes * learning.max_steps).any():
                yield f"{name}: a task took more steps than learning.max_steps ({learning.max_steps}) allows"
        for world in worlds.values() if self.change == NO_CHANGE else ():
            paths = [world.shortest_path_length(world.start, world.goal(letter)) for letter in self.tasks]
            if arrays["shortest"].tolist() != [paths] or arrays["states"].tolist() != [world.n_states]:
                yield "its shortest paths or its number of states are not those of its map"

    def _name(self, place: str) -> str | int:
        """Return the name of a map in random streams."""
        return int(place) if self.size else place

    def _world(self, place: str, worlds: Worlds) -> GridWorld:
        if not self.size:
            if place not in worlds:
                raise UserError(f"--map: {place} is missing; give {place}=FILE")
            return worlds[place]
        if self.family not in FAMILIES or self.sequence not in SEQUENCES:
            raise UserError(f"job: there are no maps of the family {self.family!r} with {self.sequence!r} tasks")
        return checked_map(self.family, self.size, int(place), self.maps[place], self.sequence).with_slip(self.slip)
