"""Learn the lives of one cell of the second study in one process, to one file."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import msgspec
import numpy as np

from ptl import methods
from ptl.config import Parameters, check_tasks
from ptl.errors import UserError
from ptl.files.arrays import write_arrays
from ptl.files.schema import LIVES
from ptl.learning.life import learn_life, tasks_of
from ptl.methods.ptl import Method as PartialTransfer
from ptl.world.gridworld import GridWorld, load_map
from studies.beyond.methods import reference
from studies.beyond.methods._sized import sized
from studies.beyond.population import (
    SEQUENCES,
    Entry,
    load_entry,
    place_tasks,
    read_moving_ai,
    read_population,
    winding,
)

MOVING_AI = "moving_ai"
"""Family of the maps read from Moving AI files."""


SOME = msgspec.Meta(min_length=1)
FROM_0, FROM_1 = msgspec.Meta(ge=0), msgspec.Meta(ge=1, le=10**5)


@dataclass(frozen=True)
class Cell:
    """The lives of one job: one method on some maps of a family.

    Attributes
    ----------
    family, sequence : str
    size : int
        Wanted number of states; 0 where the map is given.
    maps : list
        Seeds of the maps, or the map's file.
    seeds : int
        Lives on each map.
    method : str
    per_task : int
        Skills added after each task (`studies.beyond.methods._sized`), 0 for the method as it is.
    tasks : str
        Goal letters on a given map, in order.
    """

    family: str
    size: Annotated[int, FROM_0]
    sequence: str
    maps: Annotated[list[int | str], SOME]
    seeds: Annotated[int, FROM_1]
    method: str
    per_task: Annotated[int, FROM_0] = 0
    tasks: str = ""

    @property
    def name(self) -> str:
        """Path of its file below the folder of lives, without the suffix."""
        method = methods.identifier(reference(self.method)) + (f"_x{self.per_task}" if self.per_task else "")
        first = self.maps[0] if self.size else Path(str(self.maps[0])).stem
        return f"{self.family}_{self.size}_{self.sequence}/{method}/{first}"


def run_cell(job: Mapping[str, Any], output: str | Path, code: str) -> None:
    """Learn the lives of a cell and write its file.

    Parameters
    ----------
    job : mapping
        As `studies.beyond.design.job_of` makes it.
    output : path
        HDF5 file of the kind `ptl.files.schema.LIVES`.
    code : str
        Digest of the sources, kept in the file.
    """
    cell = msgspec.convert(job["cell"], Cell)
    parameters = Parameters.from_dict(job["parameters"])
    kind = methods.load(reference(cell.method))
    if cell.per_task:
        if not issubclass(kind, PartialTransfer):
            raise UserError(f"per_task: {cell.per_task} skills a task need a variant of ptl, not {cell.method}")
        kind = sized(kind, methods.identifier(kind), cell.per_task)
    arrays: dict[str, list[Any]] = {name: [] for name in ("steps", "first", "truncated", "library_size")}
    arrays |= {"shortest": [], "states": [], "winding": []}
    for place, world in worlds(cell, job["population"]):
        tasks = tasks_of(world, cell.tasks or "".join(world.goals))
        names = (cell.family, cell.size, cell.sequence, place)
        with methods.blamed(cell.method):
            lives = [
                learn_life(world, tasks, kind, parameters, job["root_seed"], *names, seed).records
                for seed in range(cell.seeds)
            ]
        arrays["steps"].append([[record.steps.sum() for record in life] for life in lives])
        arrays["first"].append([[record.steps[0] for record in life] for life in lives])
        arrays["truncated"].append([[record.truncated.sum() for record in life] for life in lives])
        arrays["library_size"].append([[record.library_size for record in life] for life in lives])
        arrays["shortest"].append(world.distances_to(world.start)[[task.goal for task in tasks]])
        arrays["states"].append(world.n_states)
        arrays["winding"].append(winding(world))
    origin = {"place": cell.name, "job": dict(job), "method": methods.identifier(kind), "code": code}
    made = {
        name: np.array(values, dtype="float64" if name == "winding" else "int64") for name, values in arrays.items()
    }
    write_arrays(output, LIVES, made, origin)


def worlds(cell: Cell, population: str | Path) -> Iterator[tuple[int | str, GridWorld]]:
    """Yield the maps of a cell, each with its seed or name."""
    if cell.size:
        rows: dict[tuple[str, int, int], Entry] = {
            (entry.family, entry.size, entry.seed): entry for entry in read_population(population)
        }
        for seed in cell.maps:
            if (cell.family, cell.size, seed) not in rows or cell.sequence not in SEQUENCES:
                raise UserError(
                    f"{population}: has no map of the family {cell.family}, size {cell.size} and seed {seed} with"
                    f" {cell.sequence} tasks"
                )
            yield seed, load_entry(rows[cell.family, cell.size, int(seed)], cell.sequence)
        return
    for path in map(str, cell.maps):
        if cell.family == MOVING_AI:
            yield Path(path).stem, load_moving_ai(path, cell.sequence)
        else:
            world = load_map(path)
            check_tasks(cell.tasks, world.goals, f"article_maps.{cell.family}.tasks")
            yield cell.family, world


def load_moving_ai(path: str | Path, sequence: str = "increasing") -> GridWorld:
    """Read a Moving AI map and place its tasks."""
    return place_tasks(read_moving_ai(path), Path(path).stem, 0, sequence)
