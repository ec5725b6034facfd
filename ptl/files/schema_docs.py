"""The tables of ``docs/file-format.md``, made from `ptl.files.schema`."""

from __future__ import annotations

import re
from collections.abc import Iterator

from ptl.files.schema import KINDS, Array, Attribute, Group, Limit

CONTENTS = {
    "text": "line of text", "word": "identifier", "name": "name", "digest": "16 hex digits", "map": "map",
    "json": "JSON object",
}  # fmt: skip


def filled(page: str) -> str:
    """Return a page with the tables between each pair of marks made anew."""
    for name in KINDS:
        begin, end = (f"<!-- schema: {name}, {word} -->" for word in ("begin", "end"))
        before, mark, rest = page.partition(begin)
        if mark:
            page = f"{before}{begin}\n\n{tables(name)}\n{end}{rest.partition(end)[2]}"
    return page


def tables(name: str) -> str:
    """Return what a kind of file holds as tables in Markdown."""
    kind = KINDS[name]
    head = f"`results/<run>/{kind.place}`, `format` is `{name}`: {kind.root.meaning}."
    return "\n".join([head, "", *_group(kind.root, "")])


def _group(group: Group, where: str) -> Iterator[str]:
    place = f"{where}{group.name}" if group.name != "/" else ""
    if place:
        yield f"Group `/{place}`: {group.meaning}."
        yield ""
    if group.attributes:
        yield from _table(("attribute", "type", "range", "meaning"), map(_attribute_row, group.attributes))
    if group.arrays:
        yield from _table(("array", "shape", "type", "range", "meaning"), map(_array_row, group.arrays))
    for inner in group.groups:
        yield from _group(inner, f"{place}/" if place else "")


def _table(headings: tuple[str, ...], rows: Iterator[tuple[str, ...]]) -> Iterator[str]:
    for row in (headings, ("---",) * len(headings), *rows):
        yield f"| {' | '.join(row)} |"
    yield ""


def _attribute_row(item: Attribute) -> tuple[str, ...]:
    content = CONTENTS.get(item.content, item.dtype) + (f" {_shape(item.shape)}" if item.shape else "")
    return f"`{item.name}`", content, _range(item.low, item.high), _meaning(item)


def _array_row(item: Array) -> tuple[str, ...]:
    return f"`{item.name}`", _shape(item.shape), item.dtype, _range(item.low, item.high), _meaning(item)


def _shape(shape: tuple[str | int, ...]) -> str:
    return f"({', '.join(map(str, shape))}{',' * (len(shape) == 1)})"


def _range(low: Limit, high: Limit) -> str:
    if low is None and high is None:
        return "–"
    return f"{_limit(low)} to {_limit(high)}" if high is not None else f"from {_limit(low)}"


def _limit(limit: Limit) -> str:
    return re.sub("^-", "−", str(limit).replace(" - ", " − "))


def _meaning(item: Attribute | Array) -> str:
    return f"{item.meaning} (not in all files)" if item.optional else item.meaning
