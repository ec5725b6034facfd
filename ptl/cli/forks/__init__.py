"""Jobs forked from one process of a run, which has imported what they need.

Most jobs learn for less time than Python takes to import numpy and h5py. The rules call ``ptl`` as a function of the
shell (`shell_prefix`). In a run with a server (``python -m ptl.cli.forks``) this function is a client
(`ptl.cli.forks.client`) that hands its arguments and standard streams over. The server forks, and the fork does what
``python -m ptl`` would do.
"""

from __future__ import annotations

import os
import secrets
import shlex
import socket
import subprocess
import sys

from ptl.cli.forks import client

_servers: list[subprocess.Popen[bytes]] = []


def start_server(*modules: str) -> str:
    """Start the server of a run and return its name; empty if jobs start on their own, as they do outside of Linux.

    The server imports ``modules`` once for all jobs of a study, beside what those of the package need. It ends with
    this process. It listens on a socket without a file, which only Linux has; elsewhere forks of a process that has
    imported numpy may also crash.
    """
    if sys.platform != "linux":
        return ""
    name = f"ptl-{secrets.token_hex(8)}"
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(f"\0{name}")
        listener.listen(socket.SOMAXCONN)
        server = subprocess.Popen(
            [sys.executable, "-m", "ptl.cli.forks", str(listener.fileno()), *modules],
            stdin=subprocess.PIPE,  # closed when this process ends, however it ends
            stdout=subprocess.DEVNULL,
            pass_fds=[listener.fileno()],
            env=os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"},
        )
    _servers.append(server)
    return name


def shell_prefix(server: str = "") -> str:
    """Return what the shell runs before the command of a job, with braces doubled for Snakemake.

    Every job calls the ``ptl`` of the Python that runs Snakemake, regardless of the path. Jobs are single-threaded;
    without the settings each one starts a pool of idle threads.
    """
    arguments = ["-I", "-S", str(client.__file__), server] if server else ["-m", "ptl"]
    return (
        "set -euo pipefail; export OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1 MPLBACKEND=Agg; "
        f'ptl() {{{{ {shlex.join([sys.executable, *arguments])} "$@"; }}}}; '
    )
