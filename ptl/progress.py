"""Progress of long commands, for a person who watches: a bar on a terminal, nothing in a log."""

from __future__ import annotations

import sys
from collections.abc import Collection, Iterator
from typing import TypeVar

import click

Item = TypeVar("Item")


def shown(items: Collection[Item], label: str) -> Iterator[Item]:
    """Pass items on one by one; on a terminal, a bar on stderr says how many are done and how long the rest takes."""
    if not sys.stderr.isatty():
        yield from items
        return
    with click.progressbar(items, label=label, file=sys.stderr, show_pos=True) as bar:
        yield from bar
