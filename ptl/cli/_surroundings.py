"""What Snakemake needs of the machine and the account, looked at before it starts, because it fails with tracebacks."""

from __future__ import annotations

import getpass
import os
import threading
from pathlib import Path

from ptl.errors import UserError

THREADS = 8
"""Threads that a run needs at once."""

KEPT = Path(".snakemake")
"""Folder of Snakemake's own files; caches go there too, so that a run touches nothing outside its folder."""


def environment() -> dict[str, str]:
    """Return the environment variables for Snakemake, with what the account lacks.

    Raises
    ------
    UserError
        When this folder or the account cannot run it at all.
    """
    folder = Path.cwd()
    if {"{", "}"} & set(str(folder)):
        raise UserError(f"{folder}: Snakemake takes braces in a path for wildcards; rename the folder")
    _check_threads()
    found = dict(os.environ)
    found.setdefault("XDG_CACHE_HOME", str(folder / KEPT / "cache"))
    found.setdefault("MPLCONFIGDIR", str(folder / KEPT / "cache/matplotlib"))
    found.setdefault("HOME", str(folder / KEPT))
    try:
        getpass.getuser()
    except (OSError, KeyError):  # a number without a name, as in containers
        found["LOGNAME"] = f"uid{os.getuid()}"
    return found


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
