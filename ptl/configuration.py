"""Checks a configuration against its schema and its maps before any job starts."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import yaml
from jsonschema import Draft202012Validator
from jsonschema.exceptions import ValidationError, best_match

from ptl import methods
from ptl.errors import UserError
from ptl.gridworld import GridWorld, load_map


def check(config: Mapping[str, Any], schema_path: str | Path) -> None:
    """Refuse a configuration that breaks the schema or cannot be run.

    Raises
    ------
    UserError
        One line that names the key, what is wrong with it and what is allowed.
    """
    _refuse_non_finite(config, "")
    error = best_match(_validator(Path(schema_path)).iter_errors(config))
    if error is not None:
        raise UserError(_in_one_line(error))
    for identifier in config["methods"]:
        methods.load(identifier)
    growth = {"environment": "env3", "tasks": 30, "breakpoint": 7, **config.get("growth", {})}
    growth_environment = growth["environment"]
    if growth["tasks"] <= growth["breakpoint"]:
        raise UserError(
            f"configuration key growth.tasks: {growth['tasks']} leaves nothing beyond growth.breakpoint"
            f" ({growth['breakpoint']}); give more tasks or an earlier breakpoint"
        )
    if growth_environment not in config["environments"]:
        raise UserError(
            f"configuration key growth.environment: {growth_environment!r} is not among the environments"
            f" ({', '.join(config['environments'])})"
        )
    for world, key, environment in worlds(config):
        for letter in environment["tasks"] + environment.get("discovery_tasks", ""):
            try:
                world.goal(letter)
            except UserError as error:
                raise UserError(f"configuration key {key}.tasks: {error}") from error
        if repeated := sorted({letter for letter in environment["tasks"] if environment["tasks"].count(letter) > 1}):
            raise UserError(f"configuration key {key}.tasks: {''.join(repeated)} stands there twice; name a task once")
        if extra := sorted(set(environment.get("discovery_tasks", "")) - set(environment["tasks"])):
            raise UserError(f"configuration key {key}.discovery_tasks: {''.join(extra)} is not among the tasks")


@cache
def _validator(schema_path: Path) -> Draft202012Validator:
    return Draft202012Validator(yaml.safe_load(schema_path.read_text(encoding="utf-8")))


def _refuse_non_finite(entry: Any, key: str) -> None:
    """JSON schema lets NaN pass every range, because no comparison with it fails."""
    if isinstance(entry, Mapping):
        for name, value in entry.items():
            _refuse_non_finite(value, f"{key}.{name}" if key else str(name))
    elif isinstance(entry, float) and not math.isfinite(entry):
        raise UserError(f"configuration key {key}: {entry} is not allowed; give a finite number")


def worlds(config: Mapping[str, Any]) -> Iterator[tuple[GridWorld, str, Mapping[str, Any]]]:
    """The world of every environment with its configuration key and entry."""
    for name, environment in config["environments"].items():
        yield load_map(environment["map"]), f"environments.{name}", environment


def _in_one_line(error: ValidationError) -> str:
    key = ".".join(str(part) for part in error.absolute_path) or "(top level)"
    if error.validator == "additionalProperties":
        known = ", ".join(error.schema.get("properties", {}))
        unknown = ", ".join(repr(name) for name in error.instance if name not in error.schema.get("properties", {}))
        return f"configuration key {key}: unknown key {unknown}; known are {known}"
    if error.validator == "required":
        return f"configuration key {key}: {error.message}; add it (config/README.md describes it)"
    shown = repr(error.instance)
    shown = shown if len(shown) <= 60 else shown[:57] + "..."
    rule = {
        "minimum": "at least",
        "maximum": "at most",
        "exclusiveMinimum": "greater than",
        "exclusiveMaximum": "less than",
        "type": "a value of type",
        "enum": "one of",
        "const": "exactly",
        "pattern": "text that matches",
        "minItems": "a list of at least this length:",
        "minProperties": "at least this many entries:",
    }.get(error.validator)
    wanted = f"give {rule} {error.validator_value}" if rule else error.message
    return f"configuration key {key}: {shown} is not allowed; {wanted}"
