"""R-max that believes an action after 2 tries; its model is forgotten between tasks."""

from __future__ import annotations

from studies.beyond.methods.rmax import Method as RMax


class Method(RMax):
    """As `rmax`, with m = 2."""

    label = "R-max, m = 2, forgotten"
    colour = "#7f3b08"
    visits = 2
