"""``ptl verify``: check integrity, location and invariants of the products of a run."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from ptl.files.question import Question

LISTED = 5
"""Unchecked files that are named."""


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
@click.option("--any-code", is_flag=True, help="Accept files made by another version of the code.")
def command(paths: tuple[Path, ...], against: str | None, exit_zero: bool, any_code: bool) -> None:
    """Check HDF5 files, sealed tables and report folders with a manifest, or all of them below folders.

    HDF5 files: checksum, content as declared, place, invariants, version of the code. Files that come with a checksum
    (<file>.sha256): that. Results: also the configuration and maps of their run, in the copy of its manifest
    (results/<run>/made.json), except with --any-code. Report folders: every product against the folder's
    manifest.json. Files below folders that nothing is known about are counted as not checked.

    With --against, say instead how the report folders PATHS compare with another run: which tables are equal, equal
    within a tolerance, or different, which verdicts changed, and which drawings and pages have different bytes.
    'published' is the published run, as git's HEAD or the copy kept by 'make reproduce' has it.

    Prints one line for each fault, with the command that mends it; exit status 1 if there is any.
    """
    from ptl.cli._progress import shown
    from ptl.errors import UserError, printable
    from ptl.files.comparison import NothingToCompareError, compare, reference
    from ptl.files.manifest import MADE, MANIFEST, read
    from ptl.files.question import asking
    from ptl.files.verification import checkable, faults_of, made_beside, unchecked

    if against is not None:
        try:
            found = [compare(folder, reference(against, folder)) for folder in paths]
        except NothingToCompareError as error:
            if not exit_zero:
                raise
            click.echo(str(error))
            return
        for comparison in found:
            click.echo(str(comparison))
        if not (exit_zero or all(comparison.agrees for comparison in found)):
            raise UserError(f"the tables or verdicts differ from those of {against}")
        return
    files = list(dict.fromkeys(file for path in paths for file in checkable(path)))
    if not files:
        raise UserError(f"{paths[0]}: nothing there that can be checked; name result files or folders of them")
    faults: dict[str, None] = {}
    runs: dict[Path | None, Question] = {None: {}}
    alone = []
    for path in shown(files, "Verifying"):
        made = None if any_code or path.suffix != ".h5" else made_beside(path)
        if made is not None and made not in runs:
            runs[made] = _question_of(made)
        if path.suffix == ".h5" and not runs[made]:
            alone.append(path)
        with asking(runs[made]):
            faults.update(dict.fromkeys(faults_of(path, current_code=not any_code)))
    for fault in faults:
        click.echo(printable(fault))
    if faults:
        raise UserError(f"faults found: {len(faults)}, in {len(files)} files checked")
    click.echo(f"{len(files)} files are whole, in place and consistent")
    for path in files:
        if path.name == MANIFEST:
            click.echo(printable(f"{len(read(path)['products'])} products are those of {path}"))
    left = list(dict.fromkeys(file for path in paths for file in unchecked(path, files)))
    if alone:
        click.echo(printable(f"not held against the configuration of a run ({MADE}): {_named(alone)}"))
    if left:
        click.echo(printable(f"not checked, because no checksum is kept of them: {_named(left)}"))


def _named(files: list[Path]) -> str:
    more = ", ..." if len(files) > LISTED else ""
    return f"{len(files)} files ({', '.join(map(str, files[:LISTED]))}{more})"


def _question_of(made: Path) -> Question:
    """Return what the results of a run must have been made from, by the copy of its manifest.

    Empty if methods are named by import paths: nothing that a file names is imported.
    """
    from ptl.config import Configuration
    from ptl.errors import UserError
    from ptl.files.manifest import read
    from ptl.files.question import SIDE_MAPS, asked_jobs, question_of
    from ptl.files.schema import SETTING
    from ptl.keys import ConfigurationError
    from ptl.study.decision import decision_jobs
    from ptl.study.population import design
    from ptl.study.robustness import design as robustness

    manifest = read(made)
    config, maps = manifest["config"], manifest.get("maps", {})
    if any(":" in str(name) for name in config.get("methods", ())):
        return {}
    try:
        if "population" in config:
            return design.question_of(design.Study.from_dict(config), maps)
        settings = config.pop("study", None)
        run = Configuration.from_dict(config)
        own = {name: maps[name] for name in run.environments}
        if settings is not None:
            jobs = robustness.jobs_of(robustness.Study.from_dict(settings), run.to_dict())
            return asked_jobs(SETTING, jobs, maps=own)
        question = question_of(run.to_dict(), {**own, **{name: maps[name] for name in SIDE_MAPS if run.article}})
        return {**question, **(asked_jobs(SETTING, decision_jobs(run.to_dict()), maps=own) if run.article else {})}
    except KeyError as error:
        raise UserError(f"{made}: names no map of {error.args[0]}; remove it and run the workflow again") from error
    except ConfigurationError as error:
        raise UserError(f"{made}: cannot be a run's ({error}); remove it and run the workflow again") from error
