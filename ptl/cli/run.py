"""``ptl run``: one job of the workflow."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from ptl.config import MapOptions


class _Given(dict[str, Any]):
    """The maps that are given; the first one that a job misses is named."""

    def __missing__(self, environment: str) -> Any:
        from ptl.errors import UserError

        raise UserError(f"--map: {environment}: is missing; give {environment}=FILE")


@click.command()
@click.option("--job", "text", required=True, help="The job as JSON, as the workflow passes it.")
@click.option("--map", "maps", multiple=True, help="ENVIRONMENT=FILE: the map of an environment.")
@click.option("--map-options", multiple=True,
              help="ENVIRONMENT=JSON: what its file leaves open, as map_options of the configuration.")  # fmt: skip
@click.option("--output", required=True, type=click.Path(path_type=Path), help="HDF5 file to write.")
def command(text: str, maps: tuple[str, ...], map_options: tuple[str, ...], output: Path) -> None:
    """Do the work that a job describes, and write its result file."""
    from ptl.cli._progress import shown
    from ptl.errors import UserError
    from ptl.files import store
    from ptl.jobs.kinds import job_from
    from ptl.world.gridworld import map_digest
    from ptl.world.map_files import read_map

    job = job_from(text)
    options = {name: _options(given) for name, _, given in (item.partition("=") for item in map_options)}
    worlds = _Given(
        (name, read_map(path, options.get(name)).world.with_slip(job.slip))
        for name, _, path in (given.partition("=") for given in maps)
    )
    for name, digest in job.maps.items():
        if name in worlds and map_digest(worlds[name].text) != digest:
            raise UserError(f"--map: {name}: is not the map of the job; it was changed during the run, so run it again")
    store.write(output, job, job.run(worlds, lambda parts: shown(parts, "Working")), worlds)


def _options(text: str) -> MapOptions:
    import msgspec

    from ptl.config import MapOptions
    from ptl.errors import UserError

    try:
        return MapOptions.from_dict(msgspec.json.decode(text))
    except msgspec.DecodeError as error:
        raise UserError(f"--map-options: {text!r:.60} is not JSON ({error}); give ENVIRONMENT={{...}}") from None
