"""R-max that believes an action after 10 tries; its model is forgotten between tasks."""

from __future__ import annotations

from studies.beyond.methods.rmax import Method as RMax


class Method(RMax):
    """As `rmax`, with m = 10."""

    label = "R-max, m = 10, forgotten"
    colour = "#fdb863"
    visits = 10
