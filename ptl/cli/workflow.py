"""``ptl workflow``: run snakemake after removing the lock of a killed run."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import click

LOCKS = Path(".snakemake/locks")
SNAKEMAKE = (sys.executable, "-m", "snakemake")
PATIENCE = 600.0
"""Seconds to wait for the jobs of a killed run to end."""


@click.command(context_settings={"ignore_unknown_options": True, "help_option_names": []})
@click.argument("arguments", nargs=-1, type=click.UNPROCESSED)
def command(arguments: tuple[str, ...]) -> None:
    """Run snakemake with ARGUMENTS in this folder; continue where a killed run stopped.

    A run that is killed cannot remove Snakemake's lock on the folder, and Snakemake cannot tell such a lock from that
    of a run that is still going on. This command looks at the processes of this machine: it refuses while a Snakemake
    is at work here, waits for the jobs that a killed run left behind, and then removes the lock.
    """
    from ptl.cli._surroundings import environment

    variables = environment()
    _remove_stale_lock()
    os.execve(SNAKEMAKE[0], [*SNAKEMAKE, *arguments], variables)


def _remove_stale_lock() -> None:
    from ptl.errors import UserError

    if not any(LOCKS.glob("*.lock")):
        return
    deadline = time.monotonic() + PATIENCE
    told = False
    while running := _at_work(Path.cwd()):
        numbers = ", ".join(str(number) for number in running)
        if "snakemake" in running.values():
            raise UserError(f"snakemake is running in this folder (process {numbers}); wait for it or end it first")
        if time.monotonic() > deadline:
            raise UserError(f"jobs of a killed run are still at work (process {numbers}); end them first")
        if not told:
            click.echo(f"waiting for jobs of a killed run to end (process {numbers})", err=True)
            told = True
        time.sleep(0.2)
    done = subprocess.run([*SNAKEMAKE, "--unlock"], check=False, capture_output=True, text=True)
    if any(LOCKS.glob("*.lock")):
        raise UserError(f"'snakemake --unlock' failed: {done.stderr.strip()}")


def _at_work(folder: Path) -> dict[int, str]:
    """Return the processes that run snakemake or one of its jobs in this folder, without this one and its parents."""
    import psutil

    own = psutil.Process()
    spared = {own.pid, *(parent.pid for parent in own.parents())}
    found = {}
    for process in psutil.process_iter():
        try:
            arguments = process.cmdline()
            if process.pid in spared or Path(process.cwd()) != folder:
                continue
        except (psutil.Error, OSError):  # ended meanwhile, or another user's
            continue
        names = {Path(argument).name for argument in arguments[:3]}
        if "snakemake" in names:
            found[process.pid] = "snakemake"
        elif "ptl" in names:
            found[process.pid] = "ptl"
    return found
