"""Time of one learning job and of a whole run."""

from __future__ import annotations

import json
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable
from pathlib import Path

import pandas as pd
import yaml

from ptl.config import Parameters
from ptl.learning.life import learn_life, tasks_of
from ptl.world.map_files import load_map

ROOT = Path(__file__).resolve().parents[1]


def measure_jobs(map_path: str, methods: Iterable[str], repeats: int) -> pd.DataFrame:
    """Time ``ptl learn`` on all tasks of a map, all methods in turn.

    Learning is timed in this process, after the imports; the rest of a job's time is start-up, checks and writing
    the file.

    Returns
    -------
    DataFrame
        Columns ``part``, ``item`` (method), ``quantity``, ``value`` (CPU seconds, user and system).
    """
    world, rows = load_map(map_path), []
    tasks = tasks_of(world, "".join(world.goals))
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(repeats):
            python = cpu_seconds([sys.executable, "-c", "pass"])
            for method in methods:
                arguments = ["--map", map_path, "--method", method, "--seed", str(seed), "--root-seed", "0"]
                job = cpu_seconds([_script("ptl"), "learn", *arguments, "--output", f"{folder}/job.h5"])
                begin = time.process_time()
                learn_life(world, tasks, method, Parameters(), 0, Path(map_path).stem, seed)
                learning = time.process_time() - begin
                phases = {"start of Python": python, "imports, checks and files": job - python - learning}
                for phase, seconds in {**phases, "learning": learning, "all": job}.items():
                    rows.append(("startup", method, f"CPU seconds, {phase}", seconds))
    return pd.DataFrame(rows, columns=["part", "item", "quantity", "value"])


def measure_run(configuration: str | None = None) -> pd.DataFrame:
    """Make all products in a temporary folder on all cores, with as few runs behind each verdict as in `make smoke`.

    Parameters
    ----------
    configuration : str, optional
        A file that is laid over the published configuration.

    Returns
    -------
    DataFrame
        Columns ``part``, ``item`` (rule, or ``whole run``), ``quantity``, ``value``; wall times of jobs are those that
        Snakemake records for every product.
    """
    cores = os.cpu_count() or 1
    smoke = yaml.safe_load((ROOT / "config/smoke.yaml").read_text(encoding="utf-8"))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for part in ("config", "profiles"):
            shutil.copytree(ROOT / part, folder / part)
        (folder / "few.yaml").write_text(yaml.safe_dump({"decision": smoke["decision"]}), encoding="utf-8")
        files = ["few.yaml", *([configuration] if configuration else [])]
        command = [_script("snakemake"), "--snakefile", str(ROOT / "Snakefile"), "--cores", str(cores), "--notemp"]
        begin = time.time()
        cpu = cpu_seconds([*command, "--configfile", *files], folder)
        wall = time.time() - begin
        jobs = read_jobs(folder / ".snakemake/metadata")
    rows = [
        (rule, quantity, value)
        for rule, seconds in sorted(jobs.groupby("rule")["seconds"], key=lambda group: -group[1].sum())
        for quantity, value in (
            ("jobs", len(seconds)),
            ("wall seconds of all jobs", seconds.sum()),
            ("share of core time", seconds.sum() / (cores * wall)),
        )
    ]
    rows += [("whole run", "cores", cores), ("whole run", "wall seconds", wall), ("whole run", "CPU seconds", cpu)]
    return pd.DataFrame(rows, columns=["item", "quantity", "value"]).assign(part="run")


def read_jobs(metadata: Path) -> pd.DataFrame:
    """Return rule and wall seconds of every job from Snakemake's records of its products.

    Each product has a record; those of one job share its log file.
    """
    records = [json.loads(path.read_text(encoding="utf-8")) for path in metadata.rglob("*") if path.is_file()]
    products = pd.DataFrame(
        [(record["rule"], record["log"][0], record["starttime"], record["endtime"]) for record in records],
        columns=["rule", "log", "start", "end"],
    )
    jobs = products.groupby(["rule", "log"], as_index=False).agg(start=("start", "min"), end=("end", "max"))
    return jobs.assign(seconds=jobs["end"] - jobs["start"])[["rule", "seconds"]]


def cpu_seconds(command: list[str], folder: Path | None = None) -> float:
    """Run a command; return the user and system time of its process and of those that it waited for.

    Raises
    ------
    RuntimeError
        With the end of what the command wrote to its standard error, if it fails.
    """
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode:
        raise RuntimeError(f"{' '.join(command)} failed: {done.stderr[-2000:]}")
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


def _script(name: str) -> str:
    """Return the path of a script in the environment of this Python."""
    return str(Path(sys.executable).with_name(name))
