"""R-max that believes an action after 5 tries; its model is kept between tasks."""

from __future__ import annotations

from studies.beyond.methods.rmax_memory import Method as RMax


class Method(RMax):
    """As `rmax_memory`, with m = 5."""

    label = "R-max, m = 5, kept"
    colour = "#a6761d"
    visits = 5
