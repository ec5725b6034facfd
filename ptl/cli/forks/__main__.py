"""The server of `ptl.cli.forks`; its arguments are the number of the socket that it listens on and what to import."""

from __future__ import annotations

import gc
import os
import select
import signal
import socket
import struct
import sys
import traceback
from contextlib import suppress
from importlib import import_module
from typing import NoReturn

from ptl import methods
from ptl.cli import _progress, main, run  # noqa: F401 - what a job imports
from ptl.files import store  # noqa: F401
from ptl.jobs import kinds  # noqa: F401
from ptl.world import map_files  # noqa: F401


def serve(listener: socket.socket, *modules: str) -> None:
    """Fork a job for each connection, until the standard input is closed: the run has ended."""
    for name in methods.names():
        methods.load(name)
    for module in modules:
        import_module(module)
    gc.freeze()  # collections in a job would copy the memory that it shares with this process
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # a job tells its client how it ended; nobody waits for it here
    while sys.stdin not in select.select([sys.stdin, listener], [], [])[0]:
        connection, _ = listener.accept()
        if os.fork() == 0:
            listener.close()
            run_job(connection)
        connection.close()


def run_job(connection: socket.socket) -> NoReturn:
    """Be the job of a client: its arguments, its streams, its exit status."""
    status = 1
    try:
        signal.signal(signal.SIGINT, signal.default_int_handler)
        signal.signal(signal.SIGCHLD, signal.SIG_DFL)
        sys.argv[1:] = received(connection)
        status = exit_status()
    except BaseException:
        traceback.print_exc()
    with suppress(OSError):  # the client is gone, or its streams
        sys.stdout.flush()
        sys.stderr.flush()
        connection.send(bytes([status]))
    os._exit(status)


def received(connection: socket.socket) -> list[str]:
    """Return the client's arguments and take its standard streams; processes of other users are refused."""
    _, user, _ = struct.unpack("3i", connection.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, 12))
    if user != os.getuid():
        raise PermissionError(f"user {user} must not start jobs of user {os.getuid()}")
    message, streams, _, _ = socket.recv_fds(connection, 1 << 16, 3)
    for number, stream in enumerate(streams):
        os.dup2(stream, number)
        os.close(stream)
    while part := connection.recv(1 << 16):
        message += part
    return [os.fsdecode(argument) for argument in message.split(b"\0")]


def exit_status() -> int:
    """Run the command line; return the exit status that ``python -m ptl`` would have."""
    try:
        main()
    except SystemExit as end:
        if isinstance(end.code, str):
            print(end.code, file=sys.stderr)
            return 1
        return end.code or 0
    return 0


if __name__ == "__main__":
    serve(socket.socket(fileno=int(sys.argv[1])), *sys.argv[2:])
