"""``ptl workflow``: run snakemake in an environment in which it works."""

from __future__ import annotations

import getpass
import os
import sys
import threading
from pathlib import Path

import click

from ptl.errors import UserError

THREADS = 8
"""Threads that a run needs at once."""

KEPT = Path(".snakemake")
"""Folder of Snakemake's own files; caches go there too, so that a run touches nothing outside its folder."""


class _PassedOn(click.Command):
    """Takes its arguments as they are; click would keep the first ``--`` to itself."""

    def parse_args(self, context: click.Context, arguments: list[str]) -> list[str]:
        return super().parse_args(context, ["--", *arguments])


@click.command(cls=_PassedOn, context_settings={"help_option_names": []})
@click.argument("arguments", nargs=-1, type=click.UNPROCESSED)
def command(arguments: tuple[str, ...]) -> None:
    """Run snakemake with ARGUMENTS in this folder.

    Caches stay in the folder. An account without home or name is no hindrance; what Snakemake cannot work with ends in
    one line.
    """
    variables = environment()
    os.execve(sys.executable, [sys.executable, "-m", "snakemake", *arguments], variables)


def environment() -> dict[str, str]:
    """Return the environment variables for Snakemake, including those that the account lacks.

    Raises
    ------
    UserError
        When this folder or the account cannot run it at all; Snakemake would fail with a traceback.
    """
    folder = Path.cwd()
    if {"{", "}"} & set(str(folder)):
        raise UserError(f"{folder}: Snakemake takes braces in a path for wildcards; rename the folder")
    _check_threads()
    variables = dict(os.environ)
    variables.setdefault("XDG_CACHE_HOME", str(folder / KEPT / "cache"))
    variables.setdefault("MPLCONFIGDIR", str(folder / KEPT / "cache/matplotlib"))
    variables.setdefault("HOME", str(folder / KEPT))
    try:
        getpass.getuser()
    except (OSError, KeyError):  # a number without a name, as in containers
        variables["LOGNAME"] = f"uid{os.getuid()}"
    return variables


def _check_threads() -> None:
    """Refuse an account that may not start a few threads (``ulimit -u``)."""
    end = threading.Event()
    started = []
    try:
        for _ in range(THREADS):
            thread = threading.Thread(target=end.wait)
            thread.start()
            started.append(thread)
    except RuntimeError as error:
        raise UserError(f"{error}: a run needs {THREADS} threads at once; raise the limit (ulimit -u)") from error
    finally:
        end.set()
        for thread in started:
            thread.join()
