"""One run at a time in a folder."""

from __future__ import annotations

import atexit
import errno
import fcntl
import os
import socket
import sys
import time
from contextlib import suppress
from pathlib import Path

from ptl.errors import UserError
from ptl.files.atomic import remove_unfinished

LOCK = Path(".snakemake/ptl.lock")
"""File that names the process holding the lock."""

PATIENCE = 600.0
"""Seconds to wait for the jobs of a killed run to end."""


ENDING = 10.0
"""Seconds to wait for a run that may have been told to end (Ctrl-C, SIGTERM)."""


def begin_run(*folders: str | os.PathLike[str]) -> None:
    """Lock the current folder and remove unfinished files of killed jobs below ``folders``.

    Raises
    ------
    SystemExit
        With one line, if another run is active in this folder or the folder cannot be written.
    """
    try:
        hold_folder()
        remove_unfinished(*folders)
    except UserError as error:
        sys.exit(f"error: {error}")


NO_LOCKS = {errno.ENOSYS, errno.ENOLCK, errno.EOPNOTSUPP, errno.EINVAL}
"""Errors of file systems without locks, such as Lustre and NFS as they are often mounted."""


def hold_folder() -> None:
    """Lock the current folder until this process and all its jobs have ended, however they end.

    The operating system keeps the lock as long as a process has the locked file open. It becomes the standard input,
    which jobs inherit, so that those of a killed run are waited for. On a file system without locks the file only names
    the process, until this one ends; two runs that begin at the same moment are not noticed there.

    Raises
    ------
    UserError
        If another run is active in this folder, or the folder cannot be written.
    """
    try:
        LOCK.parent.mkdir(exist_ok=True)
        file = os.open(LOCK, os.O_RDWR | os.O_CREAT, 0o666)
    except OSError as error:
        raise UserError(f"{LOCK}: cannot be written ({error.strerror}); make this folder writable") from error
    began = time.monotonic()
    told = False
    while (locked := _locked(file)) is not True:
        number, _, host = os.pread(file, 300, 0).decode().partition(" on ")
        waited, lives = time.monotonic() - began, _lives(number, host)
        if lives and (locked is None or waited > ENDING):
            remedy = f"if it has ended, remove {LOCK}" if locked is None else "wait for it or end it first"
            raise UserError(f"snakemake is running in this folder (process {number} on {host}); {remedy}")
        if locked is None:
            print("note: this file system has no locks; start one run at a time here", file=sys.stderr, flush=True)
            atexit.register(_forget, os.getpid())
            break
        if waited > PATIENCE:
            raise UserError(f"jobs of a killed run (process {number}) are still at work; end them first")
        if not told:
            whose = "another run here" if lives else "jobs of a killed run"
            print(f"waiting for {whose} (process {number}) to end", file=sys.stderr, flush=True)
            told = True
        time.sleep(0.2)
    os.ftruncate(file, 0)
    os.pwrite(file, f"{os.getpid()} on {socket.gethostname()}".encode(), 0)
    os.dup2(file, 0)
    if file:
        os.close(file)


def _locked(file: int) -> bool | None:
    """Return whether the file is locked for this process now, None if there are no locks."""
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError as error:
        if error.errno in NO_LOCKS:
            return None
        raise UserError(f"{LOCK}: cannot be locked ({error.strerror}); run in another folder") from error
    return True


def _forget(number: int) -> None:
    """Remove the name of a process from the file when it ends, so that no other one is taken for it."""
    if os.getpid() == number:
        with suppress(OSError):
            LOCK.unlink()


def _lives(number: str, host: str) -> bool:
    """Return whether a process is running; one on another machine is assumed to be."""
    if host != socket.gethostname():
        return bool(host)
    try:
        os.kill(int(number), 0)
    except ProcessLookupError:
        return False
    except PermissionError:  # of another user
        pass
    return True
