"""R-max that believes an action after 2 tries; its model is kept between tasks."""

from __future__ import annotations

from studies.beyond.methods.rmax_memory import Method as RMax


class Method(RMax):
    """As `rmax_memory`, with m = 2."""

    label = "R-max, m = 2, kept"
    colour = "#dfc27d"
    visits = 2
