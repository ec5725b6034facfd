"""``ptl workflow``: run snakemake after removing the lock of a killed run."""

from __future__ import annotations

import fcntl
import os
import socket
import subprocess
import sys
import time
from pathlib import Path

import click
import psutil

from ptl.errors import UserError

LOCKS = Path(".snakemake/locks")
HELD = Path(".snakemake/ptl.lock")
SNAKEMAKE = (sys.executable, "-m", "snakemake")
PATIENCE = 600.0
"""Seconds to wait for the jobs of a killed run to end."""


class _PassedOn(click.Command):
    """Takes its arguments as they are; click would keep the first ``--`` to itself."""

    def parse_args(self, context: click.Context, arguments: list[str]) -> list[str]:
        return super().parse_args(context, ["--", *arguments])


@click.command(cls=_PassedOn, context_settings={"help_option_names": []})
@click.argument("arguments", nargs=-1, type=click.UNPROCESSED)
def command(arguments: tuple[str, ...]) -> None:
    """Run snakemake with ARGUMENTS in this folder; continue where a killed run stopped.

    A run that is killed cannot remove Snakemake's lock on the folder, and Snakemake cannot tell such a lock from that
    of a run that is still going on. This command holds a lock of the operating system for as long as its Snakemake
    lives, looks at the processes of this machine for others, refuses while one is at work here, waits for the jobs that
    a killed run left behind, and then removes Snakemake's lock.
    """
    from ptl.cli._surroundings import environment

    variables = environment()
    _hold_folder()
    _remove_stale_lock()
    os.execve(SNAKEMAKE[0], [*SNAKEMAKE, *arguments], variables)


def _hold_folder() -> None:
    """Lock the folder until this process and the Snakemake that takes its place have ended, however they end."""
    try:
        HELD.parent.mkdir(exist_ok=True)
        held = os.open(HELD, os.O_RDWR | os.O_CREAT, 0o666)
    except OSError as error:
        raise UserError(f"{HELD}: cannot be written ({error.strerror}); make this folder writable") from error
    try:
        fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise _running(os.read(held, 100).decode().strip()) from None
    os.truncate(held, 0)
    os.write(held, f"{os.getpid()} on {socket.gethostname()}\n".encode())
    os.set_inheritable(held, True)


def _running(processes: str) -> UserError:
    return UserError(f"snakemake is running in this folder (process {processes}); wait for it or end it first")


def _remove_stale_lock() -> None:
    owners = {path.stat().st_uid for path in LOCKS.glob("*.lock")}
    if not owners:
        return
    deadline = time.monotonic() + PATIENCE
    told = False
    while running := _at_work(Path.cwd(), owners):
        numbers = ", ".join(str(number) for number in running)
        if "snakemake" in running.values():
            raise _running(numbers)
        if time.monotonic() > deadline:
            raise UserError(f"jobs of a killed run are still at work (process {numbers}); end them first")
        if not told:
            click.echo(f"waiting for jobs of a killed run to end (process {numbers})", err=True)
            told = True
        time.sleep(0.2)
    done = subprocess.run([*SNAKEMAKE, "--unlock"], check=False, capture_output=True, text=True)
    if any(LOCKS.glob("*.lock")):
        raise UserError(f"'snakemake --unlock' failed: {done.stderr.strip()}")


def _at_work(folder: Path, owners: set[int]) -> dict[int, str]:
    """Return the processes, "snakemake" or "job", that work in this folder, without this one and its parents.

    Where a process of another user works cannot be seen: it counts if one of the locks belongs to that user.
    """
    own = psutil.Process()
    spared = {own.pid, *(parent.pid for parent in own.parents())}
    found = {}
    for process in psutil.process_iter():
        try:
            arguments = process.cmdline()
            names = {Path(argument).name for argument in arguments[:3]}
            if process.pid in spared or not names & {"snakemake", "ptl"}:
                continue
            try:
                here = Path(process.cwd()) == folder
            except psutil.AccessDenied:
                here = process.uids().real in owners
        except (psutil.Error, OSError):  # ended meanwhile
            continue
        if here:
            # Snakemake starts a Snakemake of its own, with this option, for a job that is a script.
            job = "ptl" in names or "--target-jobs" in arguments
            found[process.pid] = "job" if job else "snakemake"
    return found
