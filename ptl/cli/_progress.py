"""Progress bars of long commands: on a terminal only, never in a log."""

from __future__ import annotations

import sys
from collections.abc import Collection, Iterator
from typing import TypeVar

import click

Item = TypeVar("Item")


def shown(items: Collection[Item], label: str) -> Iterator[Item]:
    """Yield the items one by one; on a terminal, show a progress bar on stderr."""
    if not sys.stderr.isatty():
        yield from items
        return
    with click.progressbar(items, label=label, file=sys.stderr, show_pos=True) as bar:
        yield from bar
