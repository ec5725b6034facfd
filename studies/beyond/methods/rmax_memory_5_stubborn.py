"""R-max that keeps its model and never forgets any of it (control)."""

from __future__ import annotations

from studies.beyond.methods.rmax_memory_5 import Method as RMax


class Method(RMax):
    """As `rmax_memory_5`, but what was counted once is counted for ever (control)."""

    label = "R-max, m = 5, kept, never forgets"
    colour = "#666633"
    forgets = False
