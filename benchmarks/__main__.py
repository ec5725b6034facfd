"""Measure speed and cost on this machine: ``python -m benchmarks [--quick] [--output FOLDER]``."""

from __future__ import annotations

import argparse
import sys
from importlib.util import find_spec
from pathlib import Path

import pandas as pd
import yaml

from benchmarks import jobs, pages, scaling, speed, surveys
from benchmarks.learners import Problem
from ptl.files.atomic import write_text
from ptl.files.csv import write_csv
from ptl.report.figures import saving
from ptl.world.map_files import load_map

PEERS = {"gymnasium": "gymnasium", "jax": "jax", "mdp": "mdplib", "numba": "numba"}
"""Modules of the libraries that some learners come from, with their packages."""


def main(arguments: list[str] | None = None) -> None:
    """Measure everything and write the pages, tables and figures."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__.partition(":")[0] + ".")
    parser.add_argument("--quick", action="store_true", help="tiny sizes, to try the program; the numbers mean nothing")
    parser.add_argument("--output", type=Path, default=jobs.ROOT / "reports/published", help="folder of the products")
    options = parser.parse_args(arguments)
    missing = [package for module, package in PEERS.items() if find_spec(module) is None]
    if missing:
        sys.exit(f"error: {', '.join(missing)} not installed; run 'make benchmark', which installs them first")
    computer = pages.machine()
    config = yaml.safe_load((jobs.ROOT / "config/config.yaml").read_text(encoding="utf-8"))
    maps = {name: str(jobs.ROOT / entry["map"]) for name, entry in config["environments"].items()}
    place, letter, rounds, repeats, plan, overlay = "env1", "F", 11, 5, scaling.Sizes(), None
    trajectories = scaling.TRAJECTORIES
    if options.quick:
        place, letter, rounds, repeats, plan = "env2", "A", 2, 2, scaling.QUICK
        maps, trajectories, overlay = {place: maps[place]}, 1, str(jobs.ROOT / "config/smoke.yaml")
    task = Problem(load_map(maps[place]), letter)
    summary = pages.summarise(
        pd.concat(
            [
                speed.measure(task, speed.all_entries(), rounds, min_seconds=0.001 if options.quick else 0.25, say=say),
                speed.published(),
                surveys.measure(maps, trajectories),
                jobs.measure_jobs(maps[place], config["methods"], repeats),
                jobs.measure_run(overlay),
            ]
        )
    )
    growth = scaling.measure(plan, say)
    options.output.mkdir(parents=True, exist_ok=True)
    write_text(options.output / "benchmark.md", pages.benchmark_page(computer, summary, place, letter))
    write_csv(pages.benchmark_csv(computer, summary), options.output / "benchmark.csv")
    saving.save(scaling.draw(growth), growth, options.output / "scaling.png")
    write_text(options.output / "scaling.md", pages.scaling_page(computer, growth))


def say(line: str) -> None:
    """Write a line of progress to standard error."""
    print(line, file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
