"""Compare the products of a run with those of another: the published one, or any other report folder.

Numbers and the classes of claims decide. Tables (CSV) are compared cell by cell: they are equal within a tolerance
(ours) if nothing differs but the last printed digit of numbers that are not whole, because processors round
differently. Drawings, pages and all other products are compared by their bytes; those that differ are named but not
judged.
"""

from __future__ import annotations

import csv
import gzip
import io
import os
import re
import subprocess
import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from decimal import Decimal
from itertools import zip_longest
from pathlib import Path
from typing import Any

from ptl.errors import UserError, printable
from ptl.files.aging import MADE, products_made
from ptl.files.manifest import MANIFEST, parse, products_in, read
from ptl.files.regular import NotReadable, read_bytes, sha256
from ptl.keys import shortened

PUBLISHED = "published"
"""Name of the published products: those of git's HEAD, or the copy made of them before the first run."""

KEPT = ".published"
"""Folder of that copy, made by ``make reproduce`` where there is no git."""

MAX_BYTES = 2**26
"""Maximum size of a table that is compared."""

MAX_NAMED = 6
"""Maximum number of products, keys or claims that are named; the rest is counted."""

_NUMBER = re.compile(r"([-−]?\d+(?:\.\d+)?(?:e[-+]?\d{1,3})?)")


class NothingToCompareError(UserError):
    """The products of the other run do not exist."""


@dataclass(frozen=True)
class Reference:
    """The other run: its name, and a function that returns the content of a product, None if it cannot be read."""

    name: str
    read: Callable[[str], bytes | None]


def reference(text: str, folder: Path) -> Reference:
    """Return the reference with which a report folder is compared.

    Parameters
    ----------
    text : str
        A report folder, its manifest, ``git:REVISION`` (the same folder there), or `PUBLISHED`.
    folder : path
        Report folder of the run.

    Raises
    ------
    UserError
        If the reference does not exist, or a run would be compared with itself.
    """
    if text != PUBLISHED and not text.startswith("git:"):
        other = Path(text).parent if Path(text).name == MANIFEST else Path(text)
        if other.resolve() == folder.resolve():
            raise UserError(f"{folder}: would be compared with itself; give another report folder, or git:HEAD")
        return Reference(text, lambda product: _content(other / product))
    revision = "HEAD" if text == PUBLISHED else text.removeprefix("git:")
    commit = (_git(folder, "rev-parse", "--short", revision) or b"no commit").decode().strip()
    result = Reference(
        f"git {revision} ({commit})", lambda product: _git(folder, "cat-file", "blob", f"{revision}:./{product}")
    )
    if result.read(MANIFEST) is None and (reason := _reason(folder)):
        raise NothingToCompareError(f"{folder}: git does not read the repository around it ({reason})")
    if text == PUBLISHED and result.read(MANIFEST) is None:
        if folder.name != PUBLISHED or not Path(KEPT, MANIFEST).is_file():
            raise NothingToCompareError(
                f"{folder}: neither git's HEAD nor {KEPT} holds the published products to compare with; 'make"
                " reproduce' in a fresh copy of the package keeps them"
            )
        result = Reference(f"{KEPT} (kept before the first run)", lambda product: _content(Path(KEPT, product)))
    results = folder.parent.parent / "results" / folder.name
    own = products_in(folder)
    if own and own != products_made(results):
        raise UserError(
            f"{folder}: has the products that came with the package, not those of a run made here ({results / MADE}"
            " does not name them), which would be compared with themselves; run 'make reproduce'"
        )
    return result


def _content(file: Path) -> bytes | None:
    try:
        return read_bytes(file, MAX_BYTES)
    except NotReadable:
        return None


def _git(folder: Path, *arguments: str) -> bytes | None:
    done = _run_git(folder, *arguments)
    return done.stdout if done and done.returncode == 0 else None


def _run_git(folder: Path, *arguments: str) -> subprocess.CompletedProcess[bytes] | None:
    try:
        environment = os.environ | {"LC_ALL": "C"}  # for `_reason`
        return subprocess.run(["git", "-C", str(folder), *arguments], check=False, capture_output=True, env=environment)
    except OSError:  # no git, or no such folder
        return None


def _reason(folder: Path) -> str:
    """Return why git does not read a repository, say because it belongs to another user; empty if there is none."""
    done = _run_git(folder, "rev-parse", "--git-dir")
    message = done.stderr.decode(errors="replace") if done and done.returncode else ""
    return "" if "not a git repository" in message else " ".join(message.split())


@dataclass(frozen=True)
class Comparison:
    """The outcome in a few lines, and whether all tables and classes agree and no product is missing."""

    lines: list[str]
    agrees: bool

    def __str__(self) -> str:
        return "\n".join(map(printable, self.lines))


def compare(folder: Path, other: Reference) -> Comparison:
    """Compare a report folder with the products of another run.

    Raises
    ------
    UserError
        If a manifest is missing or damaged.
    """
    own, text = read(folder / MANIFEST), other.read(MANIFEST)
    if text is None:
        raise UserError(f"{other.name}: has no {MANIFEST}; give a report folder, or a git:REVISION, that has one")
    theirs = parse(text, Path(other.name))
    outcomes: dict[str, list[str]] = {name: [] for name in ("equal", "close", "different", "pages", "bytes", "missing")}
    for name, digest in theirs.products.items():
        outcome, place = _outcome(folder / name, digest, name, other)
        outcomes[outcome].append(name + place)
    before, after = _classes(other.read("claims.csv")), _classes(_content(folder / "claims.csv"))
    changed, claims = _changes(before, after), {*before, *after}
    number = {name: len(products) for name, products in outcomes.items()}
    lines = [
        f"{folder} compared with {other.name}:",
        f"  tables: {number['equal']} equal, {number['close']} within the tolerance, {number['different']} different",
        f"  drawings and pages: {number['pages']} equal, {number['bytes']} with different bytes (not judged)",
        *[f"  classes of claims: {len(claims) - len(changed)} of {len(claims)} equal"] * bool(claims),
    ]
    named = {
        "missing": outcomes["missing"],
        "different tables": outcomes["different"],
        "pages with different bytes": outcomes["bytes"],
        "changed classes": changed,
        "changed settings": _changes(_flat(theirs.config), _flat(own.config)),
        "changed versions": _changes(theirs.versions, own.versions),
    }
    for title, names in named.items():
        more = f" and {len(names) - MAX_NAMED} more" if len(names) > MAX_NAMED else ""
        lines += [f"  {title}: {', '.join(names[:MAX_NAMED])}{more}"] * bool(names)
    agrees = not (outcomes["different"] or outcomes["missing"] or changed)
    if not agrees:
        lines.append(f"  where to look: 'git diff {folder}', and docs/reliability.md on what may differ")
    return Comparison(lines, agrees)


def _outcome(path: Path, digest: str, name: str, other: Reference) -> tuple[str, str]:
    """Return how a product compares, and the first difference of a table."""
    table = name.endswith((".csv", ".csv.gz"))
    try:
        if sha256(path) == digest:
            return "equal" if table else "pages", ""
    except NotReadable as error:
        if error.missing:
            return "missing", ""
    if not table:
        return "bytes", ""
    ours, theirs = _content(path), other.read(name)
    if name.endswith(".gz"):  # its bytes depend on the version of zlib
        ours, theirs = _unpacked(ours), _unpacked(theirs)
    place = first_difference(ours, theirs)
    return ("different", f" ({place})") if place else ("close", "")


def _unpacked(content: bytes | None) -> bytes | None:
    """Return the content of a compressed file, None if it cannot be read."""
    try:
        return None if content is None else gzip.decompress(content)
    except (EOFError, gzip.BadGzipFile, zlib.error):
        return None


def first_difference(ours: bytes | None, theirs: bytes | None) -> str:
    """Return where two tables differ by more than the tolerance, and how; an empty text if they do not."""
    mine, others = _rows(ours), _rows(theirs)
    if mine is None or others is None:
        return "no table" if mine is None else "no table in the other run"
    for line, (row, counterpart) in enumerate(zip_longest(mine, others, fillvalue=list[str]()), 1):
        for column, (cell, other) in enumerate(zip_longest(row, counterpart, fillvalue="no cell"), 1):
            if not _close(cell, other):
                return f"line {line}, column {column}: {shortened(other)}, here {shortened(cell)}"
    return ""


def _rows(content: bytes | None) -> list[list[str]] | None:
    """Return the cells of a table, None if it cannot be read."""
    try:
        return None if content is None else list(csv.reader(io.StringIO(content.decode(), newline=""), strict=True))
    except (UnicodeDecodeError, csv.Error):
        return None


def _close(one: str, other: str) -> bool:
    """Return whether two cells differ in nothing but the last printed digit of numbers that are not whole."""
    parts, counterparts = _NUMBER.split(one), _NUMBER.split(other)  # text and numbers in turn
    if parts[::2] != counterparts[::2]:
        return False
    for texts in zip(parts[1::2], counterparts[1::2], strict=True):
        a, b = (Decimal(text.replace("−", "-")) for text in texts)
        digit = min(int(number.as_tuple().exponent) for number in (a, b))
        if a != b and (digit >= 0 or abs(a - b) > Decimal(1).scaleb(digit)):
            return False
    return True


def _classes(content: bytes | None) -> dict[str, str]:
    """Return the class of each claim, and the readings under which it holds, by its id; none without a table."""
    header, *rows = _rows(content) or [[]]
    cells = [dict(zip(header, row, strict=False)) for row in rows]
    wanted = ("class", "holds_when")
    return {row["id"]: ": ".join(filter(None, map(row.get, wanted))) for row in cells if {"id", *wanted} <= {*row}}


def _changes(before: Mapping[str, Any], after: Mapping[str, Any]) -> list[str]:
    """Return the names with another value, with the other run's and ours ("-" if one has none)."""
    pairs = {name: (before.get(name, "-"), after.get(name, "-")) for name in {**before, **after}}
    return [f"{name} ({old}, here {new})" for name, (old, new) in pairs.items() if str(old) != str(new)]


def _flat(config: Mapping[str, Any], parent: str = "") -> dict[str, Any]:
    flat: dict[str, Any] = {}
    for name, value in config.items():
        flat |= _flat(value, f"{parent}{name}.") if isinstance(value, Mapping) else {f"{parent}{name}": value}
    return flat
