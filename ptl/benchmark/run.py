"""Wall and CPU time of a whole run, rule by rule.

The run is made for the measurement, in a temporary folder. The times of its jobs are those that Snakemake records
beside every product.
"""

from __future__ import annotations

import json
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from ptl.config import Decision

DECIDING_RUNS = 3
"""Runs behind each verdict instead of the study's thousands, which would hide all else and take most of an hour."""

NOTE = f"The verdicts rest on {DECIDING_RUNS} runs of each method instead of the study's thousands."


@dataclass(frozen=True)
class Run:
    """A whole run.

    Attributes
    ----------
    cores : int
    wall, cpu : float
        Seconds from the start of Snakemake to its end; user and system time of Snakemake and all its jobs.
    until_first_job : float
        Wall seconds before the first job.
    jobs : DataFrame
        Columns ``rule``, ``seconds`` (wall time of a job until its last product was written).
    """

    cores: int
    wall: float
    cpu: float
    until_first_job: float
    jobs: pd.DataFrame


def measure(project: Path, config: Mapping[str, Any]) -> Run:
    """Make all products in a temporary folder on all cores, with `DECIDING_RUNS` runs behind each verdict.

    Parameters
    ----------
    project : path
        Folder with the Snakefile.
    config : mapping
        The whole configuration; maps are named by paths from ``project``.
    """
    cores = os.cpu_count() or 1
    config = {**config, "decision": dict.fromkeys(Decision.__struct_fields__, DECIDING_RUNS)}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for part in ("config", "profiles"):
            shutil.copytree(project / part, folder / part)
        for entry in config["environments"].values():
            (folder / entry["map"]).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(project / entry["map"], folder / entry["map"])
        (folder / "config/config.yaml").write_text(json.dumps(config), encoding="utf-8")  # JSON is YAML
        command = [sys.executable, "-m", "snakemake", "--snakefile", str(project / "Snakefile"), "--cores", str(cores)]
        cpu, begin = _cpu_seconds_of_children(), time.time()
        subprocess.run([*command, "--notemp"], cwd=folder, check=True, stdout=subprocess.DEVNULL)
        wall, cpu = time.time() - begin, _cpu_seconds_of_children() - cpu
        jobs = read_jobs(folder / ".snakemake/metadata")
    return Run(cores, wall, cpu, jobs["start"].min() - begin, jobs[["rule", "seconds"]])


def _cpu_seconds_of_children() -> float:
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def read_jobs(metadata: Path) -> pd.DataFrame:
    """Return rule, start (seconds since 1970) and wall seconds of every job from Snakemake's records of its products.

    Each product has a record; those of one job share its log file.
    """
    records = [json.loads(path.read_text(encoding="utf-8")) for path in metadata.rglob("*") if path.is_file()]
    products = pd.DataFrame(
        [
            {"rule": record["rule"], "job": record["log"][0], "start": record["starttime"], "end": record["endtime"]}
            for record in records
        ]
    )
    jobs = products.groupby(["rule", "job"], as_index=False).agg(start=("start", "min"), end=("end", "max"))
    return jobs.assign(seconds=jobs["end"] - jobs["start"])


def summarise(run: Run) -> pd.DataFrame:
    """Return number and wall time of the jobs of each rule, longest first, and the time of the whole run.

    Returns
    -------
    DataFrame
        Columns ``item`` (rule, or ``whole run``), ``quantity``, ``value``; a share is of the time that all cores
        together had.
    """
    available = run.cores * run.wall
    rows: list[dict] = []
    totals = run.jobs.groupby("rule")["seconds"].agg(["size", "sum"]).sort_values("sum", ascending=False)
    for rule, (jobs, seconds) in totals.iterrows():
        rows += [
            {"item": rule, "quantity": "jobs", "value": jobs},
            {"item": rule, "quantity": "wall seconds of all jobs", "value": seconds},
            {"item": rule, "quantity": "share of core time", "value": seconds / available},
        ]
    for quantity, value in (
        ("cores", run.cores),
        ("wall seconds", run.wall),
        ("CPU seconds", run.cpu),
        ("wall seconds before the first job", run.until_first_job),
        ("share of core time without a job", 1 - run.jobs["seconds"].sum() / available),
    ):
        rows.append({"item": "whole run", "quantity": quantity, "value": value})
    return pd.DataFrame(rows)
