"""Where the time of a whole run goes, from the log that Snakemake leaves behind."""

from __future__ import annotations

import re
from dataclasses import dataclass
from datetime import datetime, timedelta
from pathlib import Path

import pandas as pd

STAMP = re.compile(r"^\[(\w{3} \w{3} +\d+ \d\d:\d\d:\d\d \d{4})\]$")
STARTED = re.compile(r"^(?:Job (\d+): |    jobid: (\d+)$)")
FINISHED = re.compile(r"^Finished jobid: (\d+) \(Rule: (\w+)\)")
CORES = re.compile(r"^Provided cores: (\d+)")
ELAPSED = re.compile(r"^Elapsed time: (?:(\d+) days?, )?(\d+):(\d\d):(\d\d(?:\.\d+)?)")
COUNT = re.compile(r"^(\w+) +(\d+)$")


@dataclass(frozen=True)
class Run:
    """A whole run.

    Attributes
    ----------
    cores : int
    elapsed : float
        Wall time in seconds from the start of Snakemake to its end.
    until_first_job : float
        Wall time in seconds before the first job: reading the workflow and finding out what to do.
    jobs : DataFrame
        Columns ``rule``, ``seconds`` (wall time of a job; the log's clock has whole seconds).
    """

    cores: int
    elapsed: float
    until_first_job: float
    jobs: pd.DataFrame


def newest_whole_run(folder: Path, learning_jobs: int) -> Path | None:
    """The newest log of a run that made everything, with so many learning jobs, and ended well; None if none is."""
    for path in sorted(folder.glob("*.snakemake.log"), reverse=True):
        lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
        counts = {found[1]: int(found[2]) for found in map(COUNT.match, lines) if found}
        if counts.get("all") == 1 and counts.get("learn") == learning_jobs and _ended_well(lines):
            return path
    return None


def _ended_well(lines: list[str]) -> bool:
    return any(line.endswith("steps (100%) done") for line in lines) and any(map(ELAPSED.match, lines))


def read_run(path: Path) -> Run:
    """Read the log of a run that ended well."""
    cores, elapsed = 0, 0.0
    stamp: datetime | None = None
    first: datetime | None = None
    started: dict[int, datetime] = {}
    rows = []
    for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
        if found := STAMP.match(line):
            stamp = datetime.strptime(found[1], "%a %b %d %H:%M:%S %Y")
        elif found := CORES.match(line):
            cores = int(found[1])
        elif found := ELAPSED.match(line):
            days, hours, minutes, seconds = found.groups()
            span = timedelta(int(days or 0), float(seconds), minutes=int(minutes), hours=int(hours))
            elapsed = span.total_seconds()
        elif (found := STARTED.match(line)) and stamp is not None:
            job = int(found[1] or found[2])
            started.setdefault(job, stamp)
            first = first or stamp
        elif (found := FINISHED.match(line)) and stamp is not None:
            seconds = (stamp - started[int(found[1])]).total_seconds()
            rows.append({"rule": found[2], "seconds": seconds})
    begin = datetime.strptime(path.name.removesuffix(".snakemake.log"), "%Y-%m-%dT%H%M%S.%f")
    waited = max((first - begin).total_seconds(), 0.0) if first else elapsed
    return Run(cores, elapsed, waited, pd.DataFrame(rows, columns=["rule", "seconds"]))


def summarise(run: Run) -> pd.DataFrame:
    """Jobs and wall time of every rule, longest first, then what the whole run took.

    Returns
    -------
    DataFrame
        Columns ``item`` (rule, or ``whole run``), ``quantity``, ``value``; ``share`` of a rule is that of the time
        that all cores together had.
    """
    available = run.cores * run.elapsed
    rows: list[dict] = []
    totals = run.jobs.groupby("rule")["seconds"].agg(["size", "sum"]).sort_values("sum", ascending=False)
    for rule, (jobs, seconds) in totals.iterrows():
        rows += [
            {"item": rule, "quantity": "jobs", "value": jobs},
            {"item": rule, "quantity": "wall seconds of all jobs", "value": seconds},
            {"item": rule, "quantity": "share of core time", "value": seconds / available},
        ]
    idle = available - run.jobs["seconds"].sum()
    for quantity, value in (
        ("cores", run.cores),
        ("wall seconds", run.elapsed),
        ("wall seconds before the first job", run.until_first_job),
        ("share of core time without a job", idle / available),
    ):
        rows.append({"item": "whole run", "quantity": quantity, "value": value})
    return pd.DataFrame(rows)
