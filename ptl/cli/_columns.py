"""Tables on a terminal."""

from __future__ import annotations

from collections.abc import Iterator

GAP = "  "


def laid_out(columns: list[list[str]], width: int) -> Iterator[str]:
    """Yield the lines of a table, in several blocks if it is wider than the terminal; numbers are right-aligned."""
    labels, *others = columns
    left = max(map(len, labels))
    while others:
        block: list[list[str]] = []
        used = left
        while others and (not block or used + len(GAP) + max(map(len, others[0])) <= width):
            used += len(GAP) + max(map(len, others[0]))
            block.append(others.pop(0))
        for label, *cells in zip(labels, *block, strict=True):
            shown = [cell.rjust(max(map(len, column))) for cell, column in zip(cells, block, strict=True)]
            yield GAP.join([label.ljust(left), *shown]).rstrip()
        if others:
            yield ""
