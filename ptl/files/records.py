"""What each product of a run was made from: a record of the job that made it, held against the run by its last job.

Snakemake makes a product anew when an input is newer or when it remembers other parameters. Both can be lost: folders
are copied, clocks are wrong. A record holds the parameters of a job and the checksums of its inputs and outputs, so
that the manifest of a run names products only that were made from the results and for the configuration beside it.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from ptl.errors import UserError
from ptl.files.atomic import write_text
from ptl.files.manifest import DIGEST
from ptl.files.question import RULES, Question, about
from ptl.files.regular import NotReadable, read_bytes, sha256
from ptl.files.remedies import force
from ptl.files.schema import Misfit, parse_json
from ptl.methods import identifier

MOST_BYTES = 2**24
"""Most bytes of a record."""

FOLDER = "records"
"""Folder of the records in results/<run>/."""

SUFFIX = ".record.json"

FIGURES = "draw_figure"
"""Rule that draws every figure."""

PARTS = {"rule": str, "params": dict, "inputs": dict, "outputs": dict}

PARAMS = ("asked", "groups", "study", "environments", "foreign")
"""Parameters that are mappings, where a job has them."""

ASKED = ("maps", "methods", "jobs")
"""The same of what was asked of the files of each kind."""

RULE = re.compile("[a-z][a-z0-9_]*")


def write_record(
    folder: Path, name: str, rule: str, params: Mapping[str, Any], inputs: Iterable[str], outputs: Iterable[str]
) -> None:
    """Write the record of a job that has just made its outputs.

    Parameters
    ----------
    folder : path
        results/<run>/ of the run.
    name : str
        Name of the job, its rule and wildcards.
    """
    record = {
        "rule": rule,
        "params": params,
        "inputs": {path: sha256(path) for path in inputs},
        "outputs": {path: sha256(path) for path in outputs},
    }
    # Keys keep their order, which is that of environments and methods in tables and figures.
    write_text(folder / FOLDER / f"{name}{SUFFIX}", json.dumps(record, indent=1) + "\n")


@dataclass(frozen=True)
class _Record:
    rule: str
    params: dict[str, Any]
    inputs: dict[str, str]
    outputs: dict[str, str]


def codes_of(rules: Iterable[Any]) -> dict[str, str]:
    """Return the digest of the code of those of Snakemake's rules that have one for all their jobs, by name."""
    found = {rule.name: rule.params.get("code") for rule in rules}
    return {name: code for name, code in found.items() if isinstance(code, str)}


def check_records(
    folder: Path,
    products: Iterable[str],
    config: Mapping[str, Any],
    question: Question,
    codes: Mapping[str, str],
) -> None:
    """Refuse products that were not made from the files and for the configuration that are there now.

    Parameters
    ----------
    folder : path
        results/<run>/ of the run.
    products : paths
    config : mapping
        The completed configuration.
    question : mapping
        The question of the run.
    codes : mapping
        Digest of the code of each rule.

    Raises
    ------
    UserError
        Naming the first such product, how many there are, and the command that makes them again.
    """
    by_product = {path: record for record in _read_all(folder) for path in record.outputs}
    digest = cache(sha256)
    faults: list[tuple[str, str]] = []
    rules: dict[str, None] = {}
    waiting, seen = list(products), set()
    while waiting:
        product = waiting.pop(0)
        if product in seen:
            continue
        seen.add(product)
        if product not in by_product:
            faults.append((product, "no record says what it was made from"))
            continue
        record = by_product[product]
        waiting.extend(path for path in record.inputs if path in by_product)
        found = [*_other_files(product, record, digest), *_other_settings(record, config, question, codes)]
        faults.extend((product, fault) for fault, _ in found)
        rules.update(dict.fromkeys(rule for _, rule in found))
    if faults:
        product, fault = faults[0]
        others = len({path for path, _ in faults}) - 1
        more = f", and {others} more products are not of this run either" if others else ""
        raise UserError(f"{product}: {fault}{more}; {force(product, *rules)}")


def _other_files(product: str, record: _Record, digest: Callable[[str], str]) -> Iterator[tuple[str, str]]:
    """Yield what is wrong with a product and the files that it was made from, and the rule that has to run again."""
    try:
        if digest(product) != record.outputs[product]:
            yield "is not what its job made", record.rule
        for path, known in record.inputs.items():
            if digest(path) != known:
                yield f"was made from another {path}", record.rule
    except NotReadable as error:
        yield str(error), record.rule


def _other_settings(
    record: _Record, config: Mapping[str, Any], question: Question, codes: Mapping[str, str]
) -> Iterator[tuple[str, str]]:
    """Yield settings of a job that differ from those of the run, and the rule that has to run again."""
    for kind, asked in record.params.get("asked", {}).items():
        if kind not in question:
            yield f"was made from files of the kind {kind}, which the run does not have", record.rule
            continue
        wanted, learned_by = about(question[kind], asked.get("maps", ()), asked.get("methods")), RULES[kind]
        if gone := sorted({*asked.get("methods", ())} - {*wanted.get("methods", ())}):
            yield f"was made from lives under {gone[0]}, which is not in the run", record.rule
            asked = {**asked, "methods": {name: asked["methods"][name] for name in wanted.get("methods", ())}}
        if record.rule == "judge_settings":  # each judges some of the study's settings
            wanted = {**wanted, "jobs": {name: wanted.get("jobs", {}).get(name) for name in asked.get("jobs", ())}}
            learned_by = "learn_setting"
        if asked != wanted:
            yield _difference(asked, wanted), learned_by
    whole = {
        "groups": config,
        "study": config,
        "environments": config.get("environments", {}),
        "foreign": config.get("foreign_results", {}),
    }
    for name, wanted in whole.items():
        for key, value in record.params.get(name, {}).items():
            if value != wanted.get(key):
                yield _difference({key: value}, {key: wanted.get(key)}), record.rule
    compared = [identifier(reference) for reference in config["methods"]]
    known = {**whole, "seeds": config.get("seeds"), "looks": compared, "methods": compared}
    for name in ("environments", "looks", "methods", "foreign", "seeds"):
        found, there = _names(record.params.get(name)), _names(known[name])
        if record.rule == FIGURES and isinstance(found, list):  # each shows some environments and methods
            # "methods" may have some of the article's that are not compared
            there = found if name == "methods" else [part for part in found if part in there]
        if found is not None and found != there:
            yield f"was made for other {'methods' if name == 'looks' else name}", record.rule
    if record.params.get("code") != codes.get(record.rule, record.params.get("code")):
        yield "was made by another version of the code", record.rule


def _names(value: Any) -> Any:
    """Return the keys of a mapping in order, or what else there is."""
    return list(value) if isinstance(value, Mapping) else value


def _difference(found: Any, wanted: Any, name: str = "") -> str:
    if isinstance(found, Mapping) and isinstance(wanted, Mapping):
        for key in {**found, **wanted}:
            if found.get(key) != wanted.get(key):
                return _difference(found.get(key), wanted.get(key), f"{name}.{key}" if name else key)
    return f"was made with {name} {found!r}, not {wanted!r}"


def _read_all(folder: Path) -> Iterator[_Record]:
    for path in sorted((folder / FOLDER).glob(f"*{SUFFIX}")):
        try:
            found = parse_json(read_bytes(path, MOST_BYTES).decode("utf-8"))
            _check(found)
        except (Misfit, UnicodeDecodeError, NotReadable) as error:
            raise UserError(f"{path}: is not a record ({error}); remove it and run 'snakemake' again") from error
        yield _Record(**{name: found[name] for name in PARTS})


def _check(record: Any) -> None:
    """Refuse what no job writes, in all parts that are used."""
    if not isinstance(record, dict) or {name: type(record.get(name)) for name in PARTS} != PARTS:
        raise Misfit(f"must have the keys {', '.join(PARTS)}")
    if not RULE.fullmatch(record["rule"]):
        raise Misfit("names no rule")
    for name in ("inputs", "outputs"):
        for path, digest in record[name].items():
            if not isinstance(digest, str) or not DIGEST.fullmatch(digest):
                raise Misfit(f"{name}: {path!r} has no sha256")
    _check_mappings(record["params"], PARAMS, "params")
    for kind, asked in record["params"].get("asked", {}).items():
        if not isinstance(asked, dict):
            raise Misfit(f"params.asked: {kind!r} must be a mapping")
        _check_mappings(asked, ASKED, f"params.asked: {kind!r}")


def _check_mappings(values: Mapping[str, Any], names: Iterable[str], where: str) -> None:
    for name in names:
        if name in values and not isinstance(values[name], dict):
            raise Misfit(f"{where}: {name} must be a mapping")
