"""``ptl workflow``: snakemake, without the lock that a killed run leaves behind."""

from __future__ import annotations

import fcntl
import os
import subprocess
import sys
from pathlib import Path

import click

GUARD = Path(".snakemake/running")
"""The operating system drops the lock on this file with the last process of the run, however that ended."""


@click.command(context_settings={"ignore_unknown_options": True, "help_option_names": []})
@click.argument("arguments", nargs=-1, type=click.UNPROCESSED)
def command(arguments: tuple[str, ...]) -> None:
    """Run snakemake with ARGUMENTS in this folder; if an earlier run was killed, go on where it stopped.

    Snakemake marks its folder as locked and a run that is killed cannot take the mark away. Here the mark is taken
    away, but only after making sure that no other run started by this command is alive.
    """
    from ptl.errors import UserError

    GUARD.parent.mkdir(exist_ok=True)
    guard = os.open(GUARD, os.O_RDWR | os.O_CREAT)
    try:
        fcntl.flock(guard, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError as error:
        raise UserError("another run is under way in this folder; wait for it or stop it") from error
    os.set_inheritable(guard, True)  # as long as snakemake lives, the guard holds
    snakemake = [sys.executable, "-m", "snakemake"]
    if any(Path(".snakemake/locks").glob("*")):
        subprocess.run([*snakemake, "--unlock"], check=False, capture_output=True)
    sys.exit(subprocess.run([*snakemake, *arguments], check=False, close_fds=False).returncode)
