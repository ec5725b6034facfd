"""From the schema of the configuration to its description in config/README.md."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import yaml

from ptl.errors import UserError

OWN_NAME = "<name>"
"""Stands for a key that the user chooses, such as the name of an environment."""

INTRODUCTION = """\
# Configuration

`config.yaml` is the published run. `smoke.yaml` is laid over it for a quick look at the whole workflow.
The schema [`workflow/schemas/config.schema.yaml`](../workflow/schemas/config.schema.yaml) checks every key
before any job starts: an unknown key, a wrong type or a value out of range ends the run with one line that
names the key.

This file is made from the schema. After a change of the schema, run

    ptl config-docs workflow/schemas/config.schema.yaml --output config/README.md

## Changing values

Leave `config.yaml` as it is and put what differs into a file of your own, say `patient.yaml`:

```yaml
run: patient
skills: {patience: 3.0}
```

    snakemake -j2 --configfile patient.yaml

Your file is laid over `config.yaml`. Groups merge key by key, so the lines above leave the other keys of
`skills` as they were. Lists and single values are replaced. A key cannot be taken away, so the published
environments stay in the run. Several files after `--configfile` are laid over one another in their order.

Give each setting a `run` name of its own, and it gets folders of its own, `results/<run>/` and
`reports/<run>/`. With the name of an existing run, only what hangs on the changed keys is made again:

| changed | made again |
|---|---|
| `root_seed`, `learning` | all jobs, and what follows from them |
| `skills`, `subgoals` | learning and growth, and what follows from them |
| `policy_reuse` | learning, and what follows from it |
| `seeds`, `methods`, `environments` | only jobs that are new, and what sums up over all jobs |
| `growth`, `subgoal_frequencies` | the jobs of that part, and what follows from them |
| `measures` | measures, tables, figures and verdicts |
| `statistics` | tables, figures and verdicts |

## Marks

The last column says where a default comes from.
[docs/reconstruction.md](../docs/reconstruction.md) gives the reasons.

* **stated**: by the text of the article.
* **source**: by a cited work, or by a public re-implementation of it.
* **chosen**: by this reconstruction.
* **–**: does not touch the science, or is up to you.
"""

BOUNDS = {"minimum": "≥", "exclusiveMinimum": ">", "maximum": "≤", "exclusiveMaximum": "<"}

_MARK = re.compile(r"\s*\[(stated|source|chosen)(?:, ([^\]]+))?\](?=\.?$)")


class _Key(NamedTuple):
    name: str
    schema: Mapping[str, Any]
    required: bool


def document(schema: Mapping[str, Any]) -> str:
    """Markdown text on every key of a schema: its meaning, type and range, default, and the default's mark.

    Raises
    ------
    UserError
        If a key has no description.
    """
    parts = [INTRODUCTION]
    plain = [key for key in _keys(schema) if not _is_group(key.schema)]
    parts.append("## Top level\n\n" + _table(plain))
    for key in _keys(schema):
        if _is_group(key.schema):
            table = _table(list(_leaves(key.name, key.schema)))
            parts.append(f"## {key.name}\n\n{_description(key)[0]}\n\n{table}")
    return "\n".join(parts)


def document_file(path: str | Path) -> str:
    """As `document`, for a schema in a YAML file."""
    try:
        schema = yaml.safe_load(Path(path).read_text(encoding="utf-8"))
    except (OSError, yaml.YAMLError) as error:
        raise UserError(f"{path}: cannot be read as a YAML schema ({error}); check the path") from error
    return document(schema)


def _is_group(schema: Mapping[str, Any]) -> bool:
    return schema.get("type") == "object"


def _keys(schema: Mapping[str, Any]) -> Iterator[_Key]:
    """Keys directly in an object."""
    for name, part in schema.get("properties", {}).items():
        yield _Key(name, part, name in schema.get("required", ()))


def _leaves(prefix: str, schema: Mapping[str, Any]) -> Iterator[_Key]:
    """Keys in an object and in the objects in it, by their full names."""
    for key in _keys(schema):
        name = f"{prefix}.{key.name}"
        if _is_group(key.schema):
            yield from _leaves(name, key.schema)
        else:
            yield _Key(name, key.schema, key.required)
    if isinstance(free := schema.get("additionalProperties"), Mapping):
        yield from _leaves(f"{prefix}.{OWN_NAME}", free)


def _table(keys: list[_Key]) -> str:
    lines = ["| key | meaning | type and range | default | mark |", "|---|---|---|---|---|"]
    for key in keys:
        meaning, mark = _description(key)
        cells = (f"`{key.name}`", meaning, _range(key.schema), _default(key), mark)
        lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return "\n".join(lines) + "\n"


def _description(key: _Key) -> tuple[str, str]:
    """Meaning and mark of a key."""
    text = " ".join(key.schema.get("description", "").split())
    if not text:
        raise UserError(f"schema key {key.name}: has no description; add one")
    found = _MARK.search(text)
    if found is None:
        return text, "–"
    mark, source = found.groups()
    return _MARK.sub("", text), f"{mark} ({source})" if source else mark


def _default(key: _Key) -> str:
    if key.required:
        return "required"
    if "default" not in key.schema:
        return "–"
    value = key.schema["default"]
    return "empty" if value == "" else f"`{yaml.safe_dump(value, default_flow_style=True).splitlines()[0]}`"


def _range(schema: Mapping[str, Any]) -> str:
    """Allowed values in words."""
    if "oneOf" in schema:
        return " or ".join(_range(option) for option in schema["oneOf"])
    if "const" in schema:
        return f"`{schema['const']}`"
    if "enum" in schema:
        return "one of " + ", ".join(f"`{value}`" for value in schema["enum"])
    kind = schema["type"]
    if kind == "boolean":
        return "`true` or `false`"
    if kind == "string":
        return f"text like `{schema['pattern']}`" if "pattern" in schema else "text"
    if kind == "array":
        least = f", at least {schema['minItems']}" if "minItems" in schema else ""
        return f"list{least}, each {_range(schema['items'])}"
    word = {"integer": "whole number", "number": "number"}[kind]
    bounds = [f"{sign} {schema[name]:,}" for name, sign in BOUNDS.items() if name in schema]
    return f"{word} " + " and ".join(bounds) if bounds else word
