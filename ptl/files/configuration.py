"""Read configuration files and check the keys that depend on the maps they name."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Mapping
from pathlib import Path
from typing import Any, get_args

import msgspec
import yaml

from ptl import methods
from ptl.config import Configuration, Environment, ForeignResults, Learning, check_tasks
from ptl.errors import UserError
from ptl.files.foreign import Expected, read_foreign
from ptl.files.outside import configured
from ptl.files.regular import NotReadable, read_bytes
from ptl.keys import ConfigurationError, Group, keys_of
from ptl.learning.trial import check_method
from ptl.world.map_files import read_map

MAX_BYTES = 2**20
"""Maximum size of a configuration file."""

MAX_DEPTH = 20
"""Maximum levels of nesting in a configuration file; the keys need four."""


def completed(config: Mapping[str, Any]) -> Configuration:
    """Check a configuration and fill in the defaults.

    Environments that are null are left out, so that an overlay can remove environments. The article's
    environments come first, independent of the order of merging.

    Raises
    ------
    UserError
        One line that names the key, the value and the constraint.
    """
    if isinstance(environments := config.get("environments"), Mapping):
        kept = {name: entry for name, entry in environments.items() if entry is not None}
        config = {**config, "environments": kept}
    configuration = Configuration.from_dict(config)
    references = methods.by_identifier(configuration.methods)
    for name in configuration.method_parameters:
        if name not in references:
            known = ", ".join(references)
            raise ConfigurationError(f"method_parameters.{name}", f"is not compared; give parameters of {known}")
    own = {}
    for name, reference in references.items():
        check_method(reference)
        check_text(f"methods: label of {name}", methods.load(reference).label)
        chosen = configured(reference, configuration.method_parameters.get(name, {}))
        if isinstance(declared := getattr(chosen, "own", None), Group):
            own[name] = declared.to_dict()
            for key, value in own[name].items():
                if "<" in str(value):  # as in titles
                    raise ConfigurationError.of_value(f"method_parameters.{name}.{key}", value, "text without <")
        if configuration.method_parameters.get(name):
            check_method(chosen)
    entries = {name: _completed_entry(name, entry) for name, entry in configuration.environments.items()}
    names = sorted(entries, key=lambda name: entries[name].article_items.map or "~")
    growth = configuration.growth
    environments = {name: entries[name] for name in names}
    return msgspec.structs.replace(
        configuration,
        environments=environments,
        method_parameters=own,
        foreign_results=_completed_foreign(configuration, environments),
        growth=msgspec.structs.replace(growth, environment=growth.environment or names[-1]),
    )


def expected_of(environments: Mapping[str, Environment], seeds: int, learning: Learning) -> Expected:
    """Return the episodes that results of other programs need for a comparison with a run."""
    return Expected(
        worlds={name: read_map(entry.map, entry.map_options).world for name, entry in environments.items()},
        tasks={name: entry.tasks for name, entry in environments.items()},
        seeds=seeds,
        episodes=learning.episodes,
        max_steps=learning.max_steps,
    )


def _completed_foreign(
    configuration: Configuration, environments: Mapping[str, Environment]
) -> dict[str, ForeignResults]:
    """Check the results of other programs and give each a label."""
    given = configuration.foreign_results
    if not given:
        return {}
    expected = expected_of(environments, configuration.seeds, configuration.learning)
    for name, foreign in given.items():
        if name in methods.names() or name in methods.by_identifier(configuration.methods):
            raise ConfigurationError(f"foreign_results.{name}", "is a method of this package; give another name")
        check_text(f"foreign_results.{name}.label", foreign.label)
        read_foreign(foreign.file, name, expected)
    return {
        name: msgspec.structs.replace(foreign, label=foreign.label or name.replace("_", " ").capitalize())
        for name, foreign in given.items()
    }


def _completed_entry(name: str, entry: Environment) -> Environment:
    check_text(f"environments.{name}.title", entry.title)
    goals = read_map(entry.map, entry.map_options).world.goals
    tasks = entry.tasks or "".join(goals)
    check_tasks(tasks, goals, f"environments.{name}.tasks")
    discovery_tasks = entry.discovery_tasks or tasks[-3:]
    check_tasks(discovery_tasks, list(tasks), f"environments.{name}.discovery_tasks")
    return msgspec.structs.replace(entry, title=entry.title or name, tasks=tasks, discovery_tasks=discovery_tasks)


def check_text(key: str, text: str) -> None:
    """Refuse a text that cannot be displayed unchanged: written to a file, on one line, read from left to right."""
    unfit = [
        character
        for character in text
        if unicodedata.category(character) in {"Cc", "Cs", "Zl", "Zp"}
        or unicodedata.bidirectional(character) in {"LRE", "RLE", "LRO", "RLO", "PDF", "LRI", "RLI", "FSI", "PDI"}
        or ord(character) & 0xFFFE == 0xFFFE
    ]
    if unfit or text.startswith("_"):  # matplotlib leaves labels with an underscore out of legends
        raise ConfigurationError.of_value(
            key, text, "text without control characters and marks of direction, not starting with _"
        )


def read_yaml(path: str | Path) -> dict[str, Any]:
    """Read a configuration file; ambiguous files are refused.

    YAML readers keep the last of equal keys without a message, and take ``010`` for 8, ``1:30`` for 90 and ``NO`` for
    false.

    Raises
    ------
    UserError
        One line that names the file and the key or the line: unreadable, not YAML, a key given twice, a value that is
        not read as it is written, an alias, or nested too deep.
    """
    try:
        text = read_bytes(path, MAX_BYTES).decode("utf-8")
        _refuse_bombs(text, path)
        root = yaml.compose(text, Loader=yaml.SafeLoader)
        if not isinstance(root, yaml.MappingNode):
            raise UserError(f"{path}: holds no keys; write 'key: value' lines (config/README.md describes them)")
        _check_nodes(root, str(path), "")
        return yaml.safe_load(text)
    except UnicodeDecodeError as error:
        raise UserError(f"{path}: byte {error.start + 1} is not UTF-8 text; save it as plain text") from error
    except NotReadable as error:
        raise UserError(f"{path}: cannot be read ({error.reason}); check the path") from error
    except (yaml.YAMLError, ValueError) as error:  # a ValueError: a number that is too long
        mark = getattr(error, "problem_mark", None)
        where = f"line {mark.line + 1}: " if mark else ""
        what = getattr(error, "problem", None) or getattr(error, "reason", error)
        if mark and text.split("\n")[mark.line].lstrip(" ").startswith("\t"):
            raise UserError(f"{path}: {where}is indented with a tab; use blanks") from error
        raise UserError(f"{path}: {where}is not YAML ({what}); correct it there") from error


def _refuse_bombs(text: str, path: str | Path) -> None:
    """Refuse texts that would take too long to read: aliases, which multiply, and deep nesting."""
    depth = 0
    for event in yaml.parse(text, Loader=yaml.SafeLoader):
        line = event.start_mark.line + 1
        if isinstance(event, yaml.AliasEvent):
            raise UserError(f"{path}: line {line}: *{event.anchor} is an alias; write the value out")
        depth += isinstance(event, yaml.CollectionStartEvent) - isinstance(event, yaml.CollectionEndEvent)
        if depth > MAX_DEPTH:
            raise UserError(f"{path}: line {line}: nested more than {MAX_DEPTH} deep; correct it there")


def _check_nodes(node: yaml.Node, path: str, parent: str) -> None:
    """Refuse keys that are given twice, and keys and values that are read as something else than is written."""
    if isinstance(node, yaml.SequenceNode):
        for entry in node.value:
            _check_nodes(entry, path, parent)
    elif isinstance(node, yaml.ScalarNode):
        _check_scalar(node, path, parent.removesuffix("."))
    elif isinstance(node, yaml.MappingNode):
        seen: dict[str, int] = {}
        for name, value in node.value:
            line = name.start_mark.line + 1
            if not isinstance(name, yaml.ScalarNode):
                raise UserError(f"{path}: line {line}: a key must be a word; correct it there")
            key = f"{parent}{name.value}"
            if name.value in seen:
                raise UserError(f"{path}: key {key} is given in lines {seen[name.value]} and {line}; keep one of them")
            seen[name.value] = line
            if not name.tag.endswith(":str"):
                kind = name.tag.rpartition(":")[2]
                raise UserError(f"{path}: line {line}: key {key} is read as {kind}, not as text; write '{name.value}'")
            _check_nodes(value, path, f"{key}.")


SWITCHES = {key.name.rpartition(".")[2] for key in keys_of(Configuration) if bool in get_args(key.type)}
"""Last parts of the keys that are true or false."""


def _check_scalar(node: yaml.ScalarNode, path: str, key: str) -> None:
    """Refuse a value that YAML 1.1 takes for what few expect.

    These are octal numbers, numbers in base 60 or with underscores, dates, and words for true or false.
    """
    text, kind = node.value, node.tag.rpartition(":")[2]
    as_text = f"'{text}' for the text"
    octal = re.fullmatch("([-+]?)0([0-9_]+)", text)
    if kind in ("int", "float") and ":" in text:
        number = yaml.safe_load(text)
        remark = f"{number}, a number in base 60; write {number}, or {as_text}"
    elif kind == "int" and octal:
        decimal = int(octal[1] + octal[2].replace("_", "") or "0")
        remark = f"{yaml.safe_load(text)}, an octal number; write {decimal}, or {as_text}"
    elif kind in ("int", "float") and "_" in text:
        remark = f"{yaml.safe_load(text)}, without the underscores; write {text.replace('_', '')}, or {as_text}"
    elif kind == "timestamp":
        remark = f"a date; write {as_text}"
    elif kind == "bool" and text.lower() not in ("true", "false") and key.rpartition(".")[2] not in SWITCHES:
        value = str(yaml.safe_load(text)).lower()
        remark = f"{value}; write {as_text}, or {value}"
    else:
        return
    raise UserError(f"{path}: line {node.start_mark.line + 1}: key {key}: {text} is read as {remark}")
