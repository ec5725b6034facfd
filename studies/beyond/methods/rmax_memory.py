"""R-max whose model lasts: tasks differ in their goal only, so what was tried stays true."""

from __future__ import annotations

import numpy as np

from studies.beyond.methods.rmax import Method as RMax


class Method(RMax):
    """As `rmax`, with the model kept from task to task (Brafman and Tennenholtz, 2002; keeping it is our choice)."""

    label = "R-max, model kept"
    colour = "#bf812d"

    def begin_task(self, start: int, goal: int) -> np.ndarray | None:
        kept = self.model
        super().begin_task(start, goal)
        self.model = kept
        self.goal_is_known = any(goal in after for after in kept.after)
        return None
