"""The tables of all configuration keys, made from their definitions."""

from __future__ import annotations

from collections.abc import Iterator

import msgspec

from ptl.config import Configuration
from ptl.keys import Group, Key, allowed, inner_group, keys_of

MARK = "<!-- The rest of this page is made from ptl/config.py by: ptl docs -->\n"


def json_schema() -> str:
    """Return a JSON schema of the configuration, for completion and hints in editors."""
    return msgspec.json.format(msgspec.json.encode(msgspec.json.schema(Configuration))).decode()


def tables() -> str:
    """Return tables of all keys of the configuration, in Markdown."""
    return "\n".join(_sections(Configuration))


def _sections(definition: type[Group]) -> Iterator[str]:
    """Yield a section on the keys outside groups, and one on each group."""
    keys = list(keys_of(definition))
    yield section("Top level", definition, [key for key in keys if "." not in key.name])
    for field in msgspec.structs.fields(definition):
        if group := inner_group(field.type):
            yield section(field.name, group, [key for key in keys if key.name.startswith(f"{field.name}.")])


def section(heading: str, group: type[Group], keys: list[Key]) -> str:
    """Return a table of keys below a heading and the first line of their group's docstring."""
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
    if key.default is msgspec.NODEFAULT:
        return "required"
    if key.default in ("", None, ()):
        return "empty"
    return f"`{str(key.default).lower() if isinstance(key.default, bool) else key.default}`"
