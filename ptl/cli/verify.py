"""``ptl verify``: check the results and products of a run, or compare them with those of another run."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from ptl.files.job import Job

MAX_LISTED = 5
"""Maximum number of other files that are named."""


@click.command()
@click.argument("paths", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option(
    "--against",
    metavar="REFERENCE",
    help="Compare report folders with another run: a report folder or its manifest, git:REVISION, or 'published'.",
)
@click.option(
    "--exit-zero",
    is_flag=True,
    help="With --against: exit status 0 even if they differ or there is nothing to compare with.",
)
@click.option("--any-code", is_flag=True, help="Accept results made by another version of the code.")
@click.option("--remove", is_flag=True, help="Remove result files with faults, so that the next run makes them again.")
def command(paths: tuple[Path, ...], against: str | None, exit_zero: bool, any_code: bool, remove: bool) -> None:
    """Check result files (HDF5) and report folders with a manifest, or all of them below folders.

    Result files: checksum, arrays as declared, possible values, the job that made them and its code. In results/<run>/
    of a finished run also that the job is one of that run. Report folders: every product against manifest.json. Files
    beside them that the present configuration does not make are named.

    With --against, compare the report folders PATHS with another run instead: which tables are equal, equal within a
    tolerance, or different, which verdicts changed, and which drawings and pages have different bytes. 'published' is
    the published run, as git's HEAD or the copy kept by 'make reproduce' has it.

    Prints one line for each fault; exit status 1 if there is any.
    """
    from ptl.cli._progress import shown
    from ptl.errors import UserError, printable
    from ptl.files.manifest import MANIFEST, damages, products_in, strangers
    from ptl.jobs.kinds import register_studies

    if against is not None:
        _compare(paths, against, exit_zero)
        return
    register_studies()
    files = list(dict.fromkeys(file for path in paths for file in _checkable(path)))
    if not files:
        raise UserError(f"{paths[0]}: nothing there that can be checked; name result files or folders of them")
    faults: list[str] = []
    left: list[Path] = []
    for path in shown(files, "Verifying"):
        try:
            if path.name == MANIFEST:
                faults += damages(path.parent)
                left += strangers(path.parent)
            elif not _check_result(path, any_code):
                left.append(path)
        except UserError as error:
            faults.append(str(error))
            if remove and path.suffix == ".h5":
                path.unlink(missing_ok=True)
    for fault in faults:
        click.echo(printable(fault))
    if left:
        listed = ", ".join(map(str, left[:MAX_LISTED])) + ", ..." * (len(left) > MAX_LISTED)
        click.echo(f"left from another configuration, may be removed: {len(left)} files ({printable(listed)})")
    if faults:
        raise UserError(f"faults found: {len(faults)}, in {len(files)} files checked{'; removed' * remove}")
    named = sum(len(products_in(path.parent)) for path in files if path.name == MANIFEST)
    checked = len(files) + named
    click.echo(f"{checked} files are whole and consistent" if checked > 1 else f"{files[0]}: is whole and consistent")


def _check_result(path: Path, any_code: bool) -> bool:
    """Refuse a result file with a fault; return whether it belongs to the run of its folder, if there is one."""
    from ptl.errors import UserError
    from ptl.files.store import AGAIN, read, read_arrays

    if "job" not in read_arrays(path)[1]:
        return True
    planned = _planned_for(path.absolute())
    wanted = None
    if planned is not None:
        folder, jobs = planned
        wanted = jobs.get(path.absolute().relative_to(folder).as_posix())
    job = read(path, None if any_code else wanted).job
    _, separator, place = path.absolute().as_posix().rpartition("/results/")
    if separator and place.partition("/")[2] != job.place:
        raise UserError(f"{path}: is the file {job.place} of a run; {AGAIN}")
    if not any_code and _present_code(path, job) not in {None, job.code}:
        raise UserError(f"{path}: was made with another version of the code; {AGAIN}")
    return planned is None or wanted is not None


def _present_code(path: Path, job: Job) -> str | None:
    from ptl.errors import UserError

    try:
        return job.sources()
    except UserError as error:
        raise UserError(f"{path}: its code cannot be compared with the present one: {error}") from error


def _planned_for(path: Path) -> tuple[Path, Mapping[str, Job]] | None:
    """Return the folder of a finished run that a file is in, and the run's jobs by place."""
    return next((planned for folder in path.parents if (planned := _planned(folder))), None)


@cache
def _planned(folder: Path) -> tuple[Path, Mapping[str, Job]] | None:
    from ptl.files.aging import jobs_of_run
    from ptl.jobs.kinds import unpacked

    text = jobs_of_run(folder)
    return (folder, {job.place: job for job in unpacked(text)}) if text else None


def _checkable(path: Path) -> Iterator[Path]:
    from ptl.errors import UserError
    from ptl.files import regular
    from ptl.files.atomic import UNFINISHED
    from ptl.files.manifest import MANIFEST

    if path.is_dir():
        candidates = (file for file in regular.below(path) if file.suffix == ".h5" or file.name == MANIFEST)
        yield from sorted(file for file in candidates if not file.name.startswith(UNFINISHED))
    elif path.suffix == ".h5" or path.name == MANIFEST or not path.exists():
        yield path
    else:
        raise UserError(f"{path}: is checked through the manifest of its folder; name the folder, or an .h5 file")


def _compare(paths: tuple[Path, ...], against: str, exit_zero: bool) -> None:
    from ptl.errors import UserError
    from ptl.files.comparison import NothingToCompareError, compare, reference

    try:
        comparisons = [compare(folder, reference(against, folder)) for folder in paths]
    except NothingToCompareError as error:
        if not exit_zero:
            raise
        click.echo(str(error))
        return
    for comparison in comparisons:
        click.echo(str(comparison))
    if not (exit_zero or all(comparison.agrees for comparison in comparisons)):
        raise UserError(f"the tables or verdicts differ from those of {against}")
