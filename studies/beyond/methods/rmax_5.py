"""R-max that believes an action after 5 tries; its model is forgotten between tasks."""

from __future__ import annotations

from studies.beyond.methods.rmax import Method as RMax


class Method(RMax):
    """As `rmax`, with m = 5."""

    label = "R-max, m = 5, forgotten"
    colour = "#b35806"
    visits = 5
