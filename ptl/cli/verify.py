"""``ptl verify``: check integrity, location and invariants of the products of a run."""

from __future__ import annotations

from pathlib import Path

import click


@click.command()
@click.argument("paths", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option(
    "--against",
    type=click.Path(dir_okay=False, path_type=Path),
    help="Compare report folders with this manifest.",
)
@click.option("--any-code", is_flag=True, help="Accept files made by another version of the code.")
def command(paths: tuple[Path, ...], against: Path | None, any_code: bool) -> None:
    """Check HDF5 files, sealed tables and report folders with a manifest, or all of them below folders.

    HDF5 files: checksum, place, invariants, version of the code. Tables that come with a checksum
    (<table>.sha256): that. Report folders: every product against the folder's manifest.json.

    With --against, check instead that every product in the report folders PATHS equals the one in the manifest,
    apart from measured times.

    Prints one line for each fault, with the command that mends it; exit status 1 if there is any.
    """
    from ptl.cli._progress import shown
    from ptl.errors import UserError
    from ptl.files.manifest import MANIFEST, differences, read
    from ptl.files.verification import checkable, faults_of

    if against is not None:
        lines = [line for folder in paths for line in differences(folder, against)]
        for line in lines:
            click.echo(line)
        if lines:
            raise UserError(f"{len(lines)} products differ from {against}")
        click.echo(f"all products equal those of {against}")
        return
    files = list(dict.fromkeys(file for path in paths for file in checkable(path)))
    if not files:
        raise UserError(f"{paths[0]}: nothing there that can be checked; name result files or folders of them")
    found: dict[str, None] = {}
    for path in shown(files, "Verifying"):
        found.update(dict.fromkeys(faults_of(path, current_code=not any_code)))
    for fault in found:
        click.echo(fault)
    if found:
        raise UserError(f"faults found: {len(found)}, in {len(files)} files checked")
    click.echo(f"{len(files)} files are whole, in place and consistent")
    for path in files:
        if path.name == MANIFEST:
            click.echo(f"{len(read(path)['products'])} products are those of {path}")
