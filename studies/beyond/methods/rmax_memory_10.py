"""R-max that believes an action after 10 tries; its model is kept between tasks."""

from __future__ import annotations

from studies.beyond.methods.rmax_memory import Method as RMax


class Method(RMax):
    """As `rmax_memory`, with m = 10."""

    label = "R-max, m = 10, kept"
    colour = "#e6ab02"
    visits = 10
