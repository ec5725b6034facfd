"""Arguments that several commands take, with the ranges that result files can hold."""

from __future__ import annotations

import json
from typing import Any

import click

LARGEST = 2**63 - 1
"""Largest whole number of a result file."""

SEED = click.IntRange(0, LARGEST)


class Json(click.ParamType):
    """A JSON object with some keys.

    Parameters
    ----------
    keys : dict
        Type of the value that each key must have; the text may hold further ones.
    """

    name = "json"

    def __init__(self, **keys: type) -> None:
        self.keys = keys

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> dict[str, Any]:
        """Return the object, or refuse the text in one line."""
        from ptl.errors import UserError
        from ptl.keys import shortened

        where = f"{param.opts[0]}: " if param else ""
        try:
            found = json.loads(value)
        except (ValueError, RecursionError) as error:
            raise UserError(f"{where}{shortened(value)} is not JSON ({error}); the workflow passes it") from error
        if not isinstance(found, dict):
            raise UserError(f"{where}{shortened(value)} is no JSON object; the workflow passes one")
        for key, kind in self.keys.items():
            if not isinstance(found.get(key), kind):
                raise UserError(
                    f"{where}{key}: {found.get(key)!r:.60} is not allowed; give a value of type {kind.__name__}"
                )
        if "root_seed" in self.keys and not 0 <= found["root_seed"] <= LARGEST:
            raise UserError(f"{where}root_seed: {found['root_seed']} is not in the range 0 to {LARGEST}")
        return found
