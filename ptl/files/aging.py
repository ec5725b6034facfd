"""Age files that do not belong to a run when it is planned, so that Snakemake makes them again.

Snakemake decides by times and by what it remembers. Both can be lost: folders are copied, `.snakemake` is removed,
clocks are wrong. A result file contains its job, and `made.json` in the folder of results lists the products that
belong to it; files that do not match get the time `OLD` and are thus older than all their inputs.
"""

from __future__ import annotations

import json
import os
from base64 import urlsafe_b64encode
from collections.abc import Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from ptl.files.atomic import write_text
from ptl.files.job import Job, digest_of_text, packed
from ptl.files.manifest import products_in
from ptl.files.regular import NotReadable, sha256
from ptl.files.store import digest_in

MADE = "made.json"
"""File in results/<run>/ that records what the products of the run were made from."""

OLD = 1
"""Time of files that are to be made again; Snakemake ignores a time of 0."""

MEMORY = Path(".snakemake/metadata")
"""Where Snakemake remembers parameters, code and inputs, a file for each output."""


def age_results(folder: Path, jobs: Iterable[Job]) -> None:
    """Age the result files that other jobs have made; ``folder`` is results/<run>/."""
    for job in jobs:
        path = folder / job.place
        if (stored := digest_in(path)) is None:
            continue
        if stored != job.digest:
            _age(path)
        elif path.stat().st_mtime == OLD:  # another configuration was tried in between
            path.touch()


def age_products(results: Path, reports: Path, asked: Any, code: Any) -> None:
    """Age the products in a report folder that were not made from the present configuration, maps and code.

    Parameters
    ----------
    results, reports : path
        results/<run>/ and reports/<run>/.
    asked, code
        Configuration and code that determine the products, serializable as JSON. Changed code counts only without
        records of Snakemake, which show more precisely which products depend on it.
    """
    known = _made(results)
    fits = known.get("asked") == digest(asked) and (MEMORY.is_dir() or known.get("code") == digest(code))
    products = known.get("products", {}) if fits else dict.fromkeys(products_in(reports), "")
    for name, checksum in products.items():
        path = reports / name
        with suppress(NotReadable):
            if sha256(path) != checksum:
                _age(path)


def write_made(path: str | Path, asked: Any, code: Any, jobs: Iterable[Job], products: Mapping[str, str]) -> None:
    """Write `MADE`; ``jobs`` are those of the run, ``products`` checksums by path below the report folder."""
    content = {"asked": digest(asked), "code": digest(code), "jobs": packed(jobs), "products": dict(products)}
    write_text(path, json.dumps(content, indent=1) + "\n")


def jobs_of_run(results: Path) -> str:
    """Return the jobs of the finished run in results/<run>/ as they were packed, empty if there is no such run."""
    return str(_made(results).get("jobs", ""))


def products_made(results: Path) -> dict[str, str]:
    """Return the checksums of the products of the finished run in results/<run>/, none if there is no such run."""
    return dict(_made(results).get("products", {}))


def digest(value: Any) -> str:
    """Return a digest of a value that is serializable as JSON."""
    return digest_of_text(json.dumps(value, sort_keys=True))


def _made(results: Path) -> dict[str, Any]:
    try:
        content = json.loads((results / MADE).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return content if isinstance(content, dict) and isinstance(content.get("products"), dict) else {}


def _age(path: Path) -> None:
    """Give a file the time `OLD`, and remove what Snakemake remembers of the job that made it."""
    with suppress(OSError):
        os.utime(path, (OLD, OLD))
        (MEMORY / urlsafe_b64encode(path.as_posix().encode()).decode()).unlink(missing_ok=True)
