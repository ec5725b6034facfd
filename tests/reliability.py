"""Fills the figures into docs/reliability.md: ``python tests/reliability.py`` runs the tests and measures the jobs.

Everything between the two markers of the page is written anew; the prose around them is not touched. With
``--slurm`` the tests on a Slurm cluster run as well.
"""

from __future__ import annotations

import argparse
import os
import platform
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ElementTree
from contextlib import chdir
from functools import cache
from pathlib import Path

import yaml
from projects import ROOT

from ptl.config import Configuration
from ptl.files.configuration import completed, read_yaml
from ptl.text import number

PAGE = ROOT / "docs/reliability.md"
BEGIN, END = "<!-- figures: python tests/reliability.py -->\n", "<!-- end of figures -->"

SLURM = "test_slurm.py"
SEEDS = 10_000
"""Seeds of the estimate."""


@cache
def published() -> Configuration:
    """The published configuration."""
    with chdir(ROOT):
        return completed(read_yaml("config/config.yaml"))


def run_tests(folder: Path, slurm: bool) -> list[tuple[str, str]]:
    """Run all tests that record a figure, the slow ones too, and add the figures up; a failed test ends everything."""
    counted: dict[str, int] = {}
    said: list[tuple[str, str]] = []
    recording = [path for path in (ROOT / "tests").rglob("test_*.py") if "record_property" in path.read_text("utf-8")]
    jobs = {"not slurm": [path for path in recording if path.name != SLURM]}
    if slurm:
        jobs["slurm"] = [path for path in recording if path.name == SLURM]
    passed = 0
    for marker, paths in jobs.items():
        results = folder / f"{marker}.xml"
        subprocess.run(
            [sys.executable, "-m", "pytest", "-q", "-m", marker, f"--junitxml={results}",
             *map(str, sorted(paths))],
            cwd=ROOT, check=True,
        )  # fmt: skip
        suite = ElementTree.parse(results).getroot()
        passed += len(suite.findall(".//testcase")) - len(suite.findall(".//skipped"))
        for item in suite.iter("property"):
            name, value = item.attrib["name"], item.attrib["value"]
            if name.startswith("hypothesis-"):  # its own statistics
                continue
            if value.isdecimal():
                counted[name] = counted.get(name, 0) + int(value)
            else:
                said.append((name, value))
    rows = [(name, number(count)) for name, count in counted.items()]
    return [*rows, *said, ("tests passed, none failed", str(passed))]


def measure_jobs(folder: Path) -> list[tuple[str, str, float, float, float]]:
    """Environment, method, CPU seconds, MB of memory and kB of file of one learning job each, as published."""
    rows = []
    for environment, entry in published().environments.items():
        for method in published().methods:
            output = folder / f"{environment}_{method}.h5"
            process = subprocess.Popen(
                [sys.executable, "-m", "ptl", "learn", "--map", entry.map, "--environment", environment, "--tasks",
                 entry.tasks, "--method", method, "--seed", "0", "--root-seed", str(published().root_seed),
                 "--output", output],
                cwd=ROOT, env=os.environ | {"OPENBLAS_NUM_THREADS": "1"},
            )  # fmt: skip
            _, status, usage = os.wait4(process.pid, 0)
            if status:
                raise SystemExit(f"ptl learn failed on {environment} with {method}")
            seconds = usage.ru_utime + usage.ru_stime
            rows.append((environment, method, seconds, usage.ru_maxrss / 1024, output.stat().st_size / 1000))
    return rows


def estimate(rows: list[tuple[str, str, float, float, float]]) -> list[tuple[str, str]]:
    """What a run with `SEEDS` seeds takes, from one job of each kind."""
    profile = yaml.safe_load((ROOT / "profiles/slurm/profile.yaml").read_text(encoding="utf-8"))
    per_group = int(dict(entry.split("=") for entry in profile["group-components"])["learning"])
    config = published()
    jobs = SEEDS * len(rows)
    hours = SEEDS * sum(row[2] for row in rows) / 3600
    tasks = sum(len(entry.tasks) for entry in config.environments.values()) * len(config.methods)
    return [
        ("learning jobs, and files", number(jobs)),
        (f"Slurm jobs, {per_group} of them in each", number(-(-jobs // per_group))),
        ("CPU hours of learning", f"{hours:.0f}"),
        ("the same on 200 cores, hours", f"{hours / 200:.1f}"),
        ("memory of a learning job at most, MB", f"{max(row[3] for row in rows):.0f}"),
        ("files of learning, GB", f"{SEEDS * sum(row[4] for row in rows) / 1e6:.0f}"),
        (
            "steps per episode that measuring holds in memory, GB",
            f"{SEEDS * tasks * config.learning.episodes * 8 / 1e9:.1f}",
        ),
    ]


def table(head: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join([*lines, *("| " + " | ".join(row) + " |" for row in rows)]) + "\n"


def main() -> None:
    """Write the figures into the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--slurm", action="store_true", help="run the tests on a Slurm cluster as well")
    slurm = parser.parse_args().slurm
    with tempfile.TemporaryDirectory() as name:
        tried = run_tests(Path(name), slurm)
        rows = measure_jobs(Path(name))
    machine = f"{platform.system()} {platform.machine()}, Python {platform.python_version()}, {os.cpu_count()} cores"
    if not slurm:
        tried.append(("tests on a Slurm cluster", "left out of this run"))
    figures = (
        f"\nMeasured on {machine}.\n\n"
        + table(("tried", "figure"), tried)
        + "\nA learning job of the published configuration, measured once:\n\n"
        + table(
            ("environment", "method", "CPU s", "memory, MB", "file, kB"),
            [(a, b, f"{seconds:.2f}", f"{memory:.0f}", f"{size:.0f}") for a, b, seconds, memory, size in rows],
        )
        + f"\nFrom these, a run with {number(SEEDS)} seeds (estimated, not run):\n\n"
        + table(("item", "estimate"), estimate(rows))
        + "\n"
    )
    before, _, rest = PAGE.read_text(encoding="utf-8").partition(BEGIN)
    _, found, after = rest.partition(END)
    if not found:
        raise SystemExit(f"{PAGE}: the markers of the figures are gone")
    PAGE.write_text(before + BEGIN + figures + END + after, encoding="utf-8")


if __name__ == "__main__":
    main()
