"""Peak memory of a process."""

from __future__ import annotations

import sys
from pathlib import Path


def peak_mebibytes() -> float:
    """Return the peak resident memory of this process in MiB.

    On Linux from VmHWM: the maximum of ``getrusage`` is inherited from the process that started this one.
    """
    if sys.platform == "linux":
        for line in Path("/proc/self/status").read_text(encoding="utf-8").splitlines():
            if line.startswith("VmHWM:"):
                return int(line.split()[1]) / 1024
    import resource

    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / (2**20 if sys.platform == "darwin" else 2**10)
