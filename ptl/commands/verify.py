"""``ptl verify``: are the result files whole, in place and possible?"""

from __future__ import annotations

from pathlib import Path

import click


@click.command()
@click.argument("paths", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("--any-code", is_flag=True, help="Accept files made by another version of the code.")
def command(paths: tuple[Path, ...], any_code: bool) -> None:
    """Check HDF5 files, or all of them below folders: checksum, place, invariants, version of the code.

    Prints one line for each fault, with the command that mends it; exit status 1 if there is any.
    """
    from ptl.errors import UserError
    from ptl.verification import faults_of

    files: list[Path] = []
    for path in paths:
        if path.is_dir():
            files.extend(sorted(path.rglob("*.h5")))
        else:
            files.append(path)
    if not files:
        raise UserError(f"{paths[0]}: no HDF5 file there; name result files or folders of them")
    damaged = 0
    with click.progressbar(files, label="Verifying", file=click.get_text_stream("stderr")) as bar:
        for path in bar:
            faults = faults_of(path, current_code=not any_code)
            damaged += bool(faults)
            for fault in faults:
                click.echo(fault)
    if damaged:
        raise UserError(f"{damaged} of {len(files)} files are not as they should be")
    click.echo(f"{len(files)} files are whole, in place and consistent")
