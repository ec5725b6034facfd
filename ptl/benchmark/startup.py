"""What one learning job costs from the start of Python to its end, phase by phase."""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import tempfile
from collections.abc import Iterable
from pathlib import Path

import pandas as pd

JOB = """
import time
marks = [("start of Python", time.process_time())]
import gc, json, sys
import ptl.cli.learn, ptl.learning.life, ptl.files.results
marks.append(("imports", time.process_time()))
import ptl.files.outside
from ptl.world.gridworld import load_map
from ptl.config import Parameters
path, method, output = sys.argv[1:]
world = load_map(path)
tasks = ptl.learning.life.tasks_of(world, "".join(world.goals))
marks.append(("reading the map", time.process_time()))
life = ptl.learning.life.learn_life(world, tasks, method, Parameters(), 0, "benchmark", 0)
marks.append(("learning", time.process_time()))
digest = ptl.files.outside.learning_code(method)
origin = dict(environment="benchmark", method=method, seed=0, root_seed=0, parameters=Parameters().to_dict(),
              code=digest)
ptl.files.results.write_learning(output, life, world, origin)
marks.append(("writing the file", time.process_time()))
from ptl.benchmark.memory import peak_mebibytes
print(json.dumps({"marks": marks, "peak": peak_mebibytes()}))
gc.freeze()  # as the command line does
"""
"""What ``ptl learn`` does, with the clock read between its phases; a process of its own."""

PHASES = ("start of Python", "imports", "reading the map", "learning", "writing the file", "end of Python")


def measure(map_path: Path, methods: Iterable[str], repeats: int) -> pd.DataFrame:
    """Run learning jobs on a map, all methods in turn, several times.

    Returns
    -------
    DataFrame
        Columns ``round``, ``method``, the `PHASES` and ``all`` (CPU seconds), ``peak`` (MiB).
    """
    methods = list(methods)
    with tempfile.TemporaryDirectory() as folder:
        rows = [
            {"round": number, "method": method, **run_job(map_path, method, Path(folder) / "job.h5")}
            for number in range(repeats)
            for method in methods
        ]
    return pd.DataFrame(rows)


def run_job(map_path: Path, method: str, output: Path) -> dict[str, float]:
    """CPU seconds of each phase of one job, user and system time together, and its peak memory in MiB."""
    before = _seconds_of_children()
    command = [sys.executable, "-c", JOB, str(map_path), method, str(output)]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    total = _seconds_of_children() - before
    report = json.loads(done.stdout)
    seconds, last = {}, 0.0
    for phase, mark in report["marks"]:
        seconds[phase] = mark - last
        last = mark
    return {**seconds, "end of Python": max(total - last, 0.0), "all": total, "peak": report["peak"]}


def _seconds_of_children() -> float:
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def summarise(measured: pd.DataFrame) -> pd.DataFrame:
    """Median, least and greatest over the rounds; columns as `ptl.benchmark.speed.summarise`."""
    rows = []
    for method, group in measured.groupby("method", sort=False):
        for column in (*PHASES, "all", "peak"):
            rows.append(
                {
                    "item": method,
                    "quantity": "peak MiB" if column == "peak" else f"CPU seconds, {column}",
                    "value": group[column].median(),
                    "low": group[column].min(),
                    "high": group[column].max(),
                    "repeats": len(group),
                }
            )
    return pd.DataFrame(rows)
