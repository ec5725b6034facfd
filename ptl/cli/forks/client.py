"""The client of `ptl.cli.forks`. Nearly all of its 10 ms are the start of Python, so it imports next to nothing."""

import os
import sys


def main() -> None:
    """Let a fork of the named server run ``ptl`` with the other arguments; end with its exit status.

    If the server does not answer, because it was killed, this process becomes ``python -m ptl``.
    """
    from _signal import SIG_DFL, SIGINT, signal  # the modules without underscore take as long again to import
    from _socket import AF_UNIX, SCM_RIGHTS, SHUT_WR, SOL_SOCKET, socket

    signal(SIGINT, SIG_DFL)  # the job itself says that it was interrupted
    server, *arguments = sys.argv[1:]
    connection = socket(AF_UNIX)
    try:
        connection.connect("\0" + server)
    except OSError:
        os.execv(sys.executable, [sys.executable, "-m", "ptl", *arguments])
    message = b"\0".join(map(os.fsencode, arguments))
    streams = b"".join(number.to_bytes(4, sys.byteorder) for number in (0, 1, 2))
    sent = connection.sendmsg([message], [(SOL_SOCKET, SCM_RIGHTS, streams)])
    connection.sendall(message[sent:])
    connection.shutdown(SHUT_WR)
    status = connection.recv(1)
    sys.exit(status[0] if status else "error: the process of the job was killed")


if __name__ == "__main__":
    main()
