"""A plan through the free space whose walls last."""

from __future__ import annotations

import numpy as np

from studies.beyond.methods.free_space import Method as FreeSpace


class Method(FreeSpace):
    """As `free_space`, with the walls kept from task to task (our choice); where it has been is forgotten."""

    label = "Plan in free space, kept"
    colour = "#6a3d9a"

    def begin_task(self, start: int, goal: int) -> np.ndarray | None:
        kept = self.walls
        super().begin_task(start, goal)
        self.walls = kept
        self._plan()
        return None
