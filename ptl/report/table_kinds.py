"""The kinds of tables that each environment has, and their labels; light, because the workflow reads it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

KINDS = {
    "transfer": "Jump start, asymptotic performance and time to threshold",
    "total": "Total performance and transfer ratio",
}
"""Titles by kind (the attribute ``table`` of a measure), in the order of the article."""


def table_labels(environments: Mapping[str, Any]) -> dict[str, str]:
    """Return the name and the label of every table of a run."""
    titles = [table_title(kind, entry["title"]) for entry in environments.values() for kind in KINDS]
    return {f"table{index}": f"Table {index}. {title}" for index, title in enumerate(titles, start=1)}


def table_title(kind: str, place: str) -> str:
    """Return the title of a table of an environment, which is named ``place``."""
    return f"{KINDS[kind]}, {place}"
