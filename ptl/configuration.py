"""Checks a configuration against its schema and its maps before any job starts."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import yaml
from jsonschema import Draft202012Validator, validators
from jsonschema.exceptions import ValidationError, best_match

from ptl import methods
from ptl.errors import UserError
from ptl.gridworld import GridWorld, load_map

DEEPEST = 20
"""Levels of nesting that a configuration file may have; the schema knows four."""


def check(config: Mapping[str, Any], schema_path: str | Path) -> None:
    """Refuse a configuration that breaks the schema or cannot be run.

    Raises
    ------
    UserError
        One line that names the key, what is wrong with it and what is allowed.
    """
    _refuse_what_is_no_json(config, "")
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


def check_text(path: str | Path) -> None:
    """Refuse a configuration file that cannot mean what it says: unreadable, or with a key given twice.

    YAML readers keep the last of equal keys and say nothing.

    Raises
    ------
    UserError
        One line that names the file, the key and both lines.
    """
    try:
        text = Path(path).read_text(encoding="utf-8")
        _refuse_bombs(text, path)
        root = yaml.compose(text, Loader=yaml.SafeLoader)
    except UnicodeDecodeError as error:
        raise UserError(f"{path}: byte {error.start + 1} is not UTF-8 text; save it as plain text") from error
    except OSError as error:
        raise UserError(f"{path}: cannot be read ({error.strerror}); check the path") from error
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        where = f"line {mark.line + 1}: " if mark else ""
        what = getattr(error, "problem", None) or getattr(error, "reason", "see there")
        raise UserError(f"{path}: {where}is not YAML ({what}); correct it there") from error
    if not isinstance(root, yaml.MappingNode):
        raise UserError(f"{path}: holds no keys; write 'key: value' lines (config/README.md describes them)")
    _refuse_repeated_keys(root, str(path), "")


def _refuse_bombs(text: str, path: str | Path) -> None:
    """Refuse what would take a reader for ever: aliases, which multiply, and deep nesting."""
    depth = 0
    for event in yaml.parse(text, Loader=yaml.SafeLoader):
        line = event.start_mark.line + 1
        if isinstance(event, yaml.AliasEvent):
            raise UserError(f"{path}: line {line}: *{event.anchor} is an alias; write the value out")
        depth += isinstance(event, yaml.CollectionStartEvent) - isinstance(event, yaml.CollectionEndEvent)
        if depth > DEEPEST:
            raise UserError(f"{path}: line {line}: nested more than {DEEPEST} deep; correct it there")


def _refuse_repeated_keys(node: yaml.Node, path: str, parent: str) -> None:
    if isinstance(node, yaml.SequenceNode):
        for entry in node.value:
            _refuse_repeated_keys(entry, path, parent)
    elif isinstance(node, yaml.MappingNode):
        seen: dict[str, int] = {}
        for name, value in node.value:
            line = name.start_mark.line + 1
            if not isinstance(name, yaml.ScalarNode):
                raise UserError(f"{path}: line {line}: a key must be a word; correct it there")
            key = f"{parent}{name.value}"
            if name.value in seen:
                raise UserError(f"{path}: key {key} stands in lines {seen[name.value]} and {line}; keep one of them")
            seen[name.value] = line
            _refuse_repeated_keys(value, path, f"{key}.")


@cache
def _validator(schema_path: Path) -> Draft202012Validator:
    strict = validators.extend(Draft202012Validator, {"pattern": _whole_pattern})
    return strict(yaml.safe_load(schema_path.read_text(encoding="utf-8")))


def _whole_pattern(_: Any, pattern: str, instance: Any, __: Any) -> Iterator[ValidationError]:
    """In Python's regular expressions $ also stands before a last line end; in those of JSON schema it does not."""
    if isinstance(instance, str) and not re.search(pattern.replace("$", r"\Z"), instance):
        yield ValidationError(f"{instance!r} does not match {pattern!r}")


def _refuse_what_is_no_json(entry: Any, key: str) -> None:
    """JSON schema knows neither: NaN passes every range, and keys that are no text cannot be told apart."""
    if isinstance(entry, Mapping):
        for name, value in entry.items():
            if not isinstance(name, str):
                where = f"configuration key {key or '(top level)'}"
                raise UserError(
                    f"{where}: {_shortened(repr(name), 60)} is not allowed as a key; give a word, or quote it"
                )
            _refuse_what_is_no_json(value, f"{key}.{name}" if key else name)
    elif isinstance(entry, list):
        for value in entry:
            _refuse_what_is_no_json(value, key)
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
        unknown = ", ".join(
            _shortened(repr(name), 60) for name in error.instance if name not in error.schema.get("properties", {})
        )
        return f"configuration key {key}: unknown key {unknown}; known are {known}"
    if error.validator == "required":
        return f"configuration key {key}: {error.message}; add it (config/README.md describes it)"
    shown = _shortened(repr(error.instance), 60)
    rule = {
        "minimum": "at least",
        "maximum": "at most",
        "exclusiveMinimum": "greater than",
        "exclusiveMaximum": "less than",
        "type": "a value of type",
        "enum": "one of",
        "const": "exactly",
        "pattern": "text that matches",
        "maxLength": "at most this many characters:",
        "minItems": "a list of at least this length:",
        "minProperties": "at least this many entries:",
    }.get(error.validator)
    wanted = f"give {rule} {error.validator_value}" if rule else _shortened(error.message, 300)
    return f"configuration key {key}: {shown} is not allowed; {wanted}"


def _shortened(text: str, length: int) -> str:
    return text if len(text) <= length else text[: length - 3] + "..."
