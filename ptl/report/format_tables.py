"""Tables of ``docs/file-format.md`` and studies' pages: the inputs and the contents of each kind of result file."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any, get_args

import msgspec
from msgspec import Meta

import ptl.jobs  # noqa: F401 - registers its kinds
from ptl.files.formats import Array, Limit, Size
from ptl.files.job import KINDS, Job


def filled(page: str) -> str:
    """Return a page with the tables between each pair of marks made anew, for all kinds that are registered."""
    for kind in KINDS.values():
        name = kind.__name__
        begin, end = (f"<!-- {name}, {word} -->" for word in ("begin", "end"))
        before, mark, rest = page.partition(begin)
        if mark:
            page = f"{before}{begin}\n\n{tables(kind)}\n{end}{rest.partition(end)[2]}"
    return page


def tables(kind: type[Job]) -> str:
    """Return the fields of a kind of job and the arrays of its files as tables in Markdown."""
    config = kind.__struct_config__
    own = [field for field in msgspec.structs.fields(kind) if _description(field.type)]
    lines = [
        f"`kind` is `{config.tag}`; `parameters` has the groups {', '.join(kind.READS)}. Further values of the job:",
        "",
        *_table(("value", "meaning"), ((f"`{field.name}`", _description(field.type)) for field in own)),
        *_table(("array", "shape", "type", "range", "meaning"), map(_row, kind.ARRAYS.items())),
    ]
    return "\n".join(lines)


def _description(annotated: Any) -> str:
    return next(
        (part.description for part in get_args(annotated)[1:] if isinstance(part, Meta) and part.description), ""
    )


def _table(headings: tuple[str, ...], rows: Iterator[tuple[str, ...]]) -> Iterator[str]:
    for row in (headings, ("---",) * len(headings), *rows):
        yield f"| {' | '.join(row)} |"
    yield ""


def _row(item: tuple[str, Array]) -> tuple[str, ...]:
    name, array = item
    shape = f"({', '.join(map(_size, array.shape))}{',' * (len(array.shape) == 1)})"
    meaning = f"{array.meaning} (not in all files)" if array.optional else array.meaning
    return f"`{name}`", shape, array.dtype, _range(array.low, array.high), meaning


def _size(size: Size) -> str:
    return re.sub(r"([+-])", r" \1 ", str(size)).replace("-", "−")


def _range(low: Limit, high: Limit) -> str:
    if low is None and high is None:
        return "–"
    return f"from {_limit(low)}" if high is None else f"{_limit(low)} to {_limit(high)}"


def _limit(limit: Limit) -> str:
    return _size(limit) if isinstance(limit, str) else str(limit).replace("-", "−")
