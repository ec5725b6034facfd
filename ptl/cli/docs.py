"""``ptl docs``: the parts of the documentation that are made from the code and the published run."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import click

CONFIG, FORMATS, README = Path("config/README.md"), Path("docs/file-format.md"), Path("README.md")
RESCIENCE = Path("metadata.yaml")
PUBLISHED, STUDIES = Path("reports/published"), Path("studies")


@click.command()
@click.option("--schema", is_flag=True, help="Print a JSON schema of the configuration for editors instead.")
def command(schema: bool) -> None:
    """Bring config/README.md, docs/file-format.md, README.md, the pages of studies and the records up to date.

    They follow the code and the published run. The records are ro-crate-metadata.json of the published run,
    metadata.yaml for ReScience C, and those of studies.
    """
    from ptl.files.atomic import write_text
    from ptl.jobs.kinds import modules_of_studies, register_studies
    from ptl.report import config_page, format_tables, readme, records

    if schema:
        click.echo(config_page.json_schema())
        return
    _rewrite(CONFIG, _with_tables)
    register_studies()
    for path in (FORMATS, *sorted(STUDIES.glob("*/README.md"))):
        _rewrite(path, format_tables.filled)
    _rewrite(README, lambda page: readme.filled(page, PUBLISHED))
    write_text(PUBLISHED / records.CRATE, records.ro_crate(PUBLISHED))
    write_text(RESCIENCE, records.rescience())
    for module in modules_of_studies("record"):
        write_text(module.RECORD, module.record())


def _with_tables(page: str) -> str:
    from ptl.errors import UserError
    from ptl.report.config_page import MARK, tables

    introduction, mark, _ = page.partition(MARK)
    if not mark:
        raise UserError(f"{CONFIG}: has no line {MARK.strip()!r}; add it where the tables should begin")
    return introduction + MARK + "\n" + tables()


def _rewrite(path: Path, filled: Callable[[str], str]) -> None:
    from ptl.errors import UserError
    from ptl.files.atomic import write_text

    try:
        page = path.read_text(encoding="utf-8")
    except OSError as error:
        raise UserError(f"{path}: cannot be read ({error.strerror}); run the command in the checkout") from error
    write_text(path, filled(page))
