"""``ptl config-docs``: the tables of all configuration keys, made from their definitions."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from ptl.keys import Group, Key

MARK = "<!-- The rest of this page is made from ptl/config.py by: ptl config-docs -->\n"
PAGE = Path("config/README.md")
FORMATS = Path("docs/file-format.md")
MOST_BYTES = 2**24
"""Most bytes of a page."""


@click.command()
@click.argument("page", type=click.Path(dir_okay=False, path_type=Path), default=PAGE)
@click.option("--schema", is_flag=True, help="Print a JSON schema for editors instead.")
def command(page: Path, schema: bool) -> None:
    """Bring the tables of keys in PAGE (config/README.md), and those of docs/file-format.md, up to date."""
    from ptl.errors import UserError
    from ptl.files.atomic import write_text
    from ptl.files.schema_docs import filled

    if schema:
        click.echo(json_schema())
        return
    introduction, mark, _ = _read(page).partition(MARK)
    if not mark:
        raise UserError(f"{page}: has no line {MARK.strip()!r}; add it where the tables shall begin")
    write_text(page, introduction + MARK + "\n" + tables())
    if page == PAGE and FORMATS.is_file():
        write_text(FORMATS, filled(_read(FORMATS)))


def _read(page: Path) -> str:
    from ptl.errors import UserError
    from ptl.files.regular import NotReadable, read_bytes

    try:
        return read_bytes(page, MOST_BYTES).decode("utf-8")
    except UnicodeDecodeError as error:
        raise UserError(f"{page}: byte {error.start + 1} is not UTF-8 text; save it as plain text") from error
    except NotReadable as error:
        raise UserError(f"{page}: cannot be read ({error.reason}); check the path") from error


def json_schema() -> str:
    """Return a JSON schema of the configuration, for completion and hints in editors."""
    import msgspec

    from ptl.config import Configuration

    return msgspec.json.format(msgspec.json.encode(msgspec.json.schema(Configuration))).decode()


def tables() -> str:
    """Return tables of all keys of the configuration and of the robustness study's file, in Markdown."""
    from ptl.config import Configuration
    from ptl.keys import keys_of
    from studies.robustness.design import Study

    return "\n".join(
        [*_sections(Configuration), _section("The file of the robustness study", Study, list(keys_of(Study)))]
    )


def _sections(definition: type[Group]) -> Iterator[str]:
    """Yield a section on the keys outside groups, and one on each group."""
    import msgspec

    from ptl.keys import inner_group, keys_of

    keys = list(keys_of(definition))
    yield _section("Top level", definition, [key for key in keys if "." not in key.name])
    for field in msgspec.structs.fields(definition):
        if group := inner_group(field.type):
            yield _section(field.name, group, [key for key in keys if key.name.startswith(f"{field.name}.")])


def _section(heading: str, group: type[Group], keys: list[Key]) -> str:
    from ptl.keys import allowed

    rows = [("key", "meaning", "allowed values", "default", "mark"), ("---",) * 5]
    for key in keys:
        rows.append(
            (
                f"`{key.name}`",
                (key.meta.description or "").replace("<", r"\<"),
                allowed(key.type),
                _default(key),
                key.mark or "–",
            )
        )
    lines = ["| " + " | ".join(cell.replace("|", r"\|") for cell in row) + " |" for row in rows]
    return "\n".join([f"## {heading}", "", (group.__doc__ or "").partition("\n")[0], "", *lines, ""])


def _default(key: Key) -> str:
    import msgspec

    if key.default is msgspec.NODEFAULT:
        return "required"
    if key.default in ("", None, ()):
        return "empty"
    return f"`{str(key.default).lower() if isinstance(key.default, bool) else key.default}`"
