"""R-max whose model lasts: tasks differ in their goal only, so what was tried stays true."""

from __future__ import annotations

import numpy as np

from studies.beyond.methods.rmax import Method as RMax


class Method(RMax):
    """As `rmax`, with the model kept from task to task (our choice).

    In case the world has changed between tasks, the last m tries of an action replace its counts if all of them led to
    the same state, another than before (our choice). Knows the goal's state if it has ever been there.
    """

    label = "R-max, model kept"
    colour = "#bf812d"
    forgets = True

    def begin_task(self, start: int, goal: int) -> np.ndarray | None:
        kept = self.model
        super().begin_task(start, goal)
        self.model = kept
        self.model.doubted = False
        self.goal_is_known = any(goal in pair.outcomes for pairs in kept.pairs for pair in pairs)
        return None
