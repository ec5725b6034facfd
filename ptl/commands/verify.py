"""``ptl verify``: are the result files whole, in place and possible?"""

from __future__ import annotations

import sys
from pathlib import Path

import click


@click.command()
@click.argument("paths", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option(
    "--against", type=click.Path(dir_okay=False, path_type=Path), help="Compare report folders with this manifest."
)
@click.option("--any-code", is_flag=True, help="Accept files made by another version of the code.")
def command(paths: tuple[Path, ...], against: Path | None, any_code: bool) -> None:
    """Check HDF5 files, or all of them below folders: checksum, place, invariants, version of the code.

    With --against, check instead that every product in the report folders PATHS equals the one in the manifest,
    apart from measured times.

    Prints one line for each fault, with the command that mends it; exit status 1 if there is any.
    """
    from ptl.errors import UserError
    from ptl.manifest import differences
    from ptl.verification import faults_of

    if against is not None:
        lines = [line for folder in paths for line in differences(folder, against)]
        for line in lines:
            click.echo(line)
        if lines:
            raise UserError(f"{len(lines)} products differ from {against}")
        click.echo(f"all products equal those of {against}")
        return
    files: list[Path] = []
    for path in paths:
        if path.is_dir():
            files.extend(sorted(path.rglob("*.h5")))
        else:
            files.append(path)
    if not files:
        raise UserError(f"{paths[0]}: no HDF5 file there; name result files or folders of them")
    damaged = 0
    with click.progressbar(files, label="Verifying", file=sys.stderr) as bar:
        for path in bar:
            faults = faults_of(path, current_code=not any_code)
            damaged += bool(faults)
            for fault in faults:
                click.echo(fault)
    if damaged:
        raise UserError(f"{damaged} of {len(files)} files are not as they should be")
    click.echo(f"{len(files)} files are whole, in place and consistent")
