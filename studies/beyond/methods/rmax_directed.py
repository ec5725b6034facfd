"""R-max that knows where the goal lies: the unknown action nearest to it first."""

from __future__ import annotations

import numpy as np

from ptl.world.gridworld import MOVES
from studies.beyond.methods.rmax import Method as RMax


class Method(RMax):
    """As `rmax`, but of what is unknown it tries first what should lead nearest to the goal in a straight line (ours).

    Ties: fewest steps to get there, then at random. Knows the goal's coordinates, as `ptl`, and the direction of each
    action. It has no skill and keeps nothing, so it shows how much of a skill's gain is the goal's direction.
    """

    label = "R-max, nearest to the goal first"
    colour = "#b15928"

    def way(self, state: int) -> list[int]:
        steps, model = self.model.steps_from(state), self.model
        states, actions = np.nonzero(model.unknown & (steps >= 0)[:, None])
        if not len(states):
            return super().way(state)
        away = ((self.world.cells[states] + MOVES[actions] - self.world.cells[self.goal]) ** 2).sum(axis=1)
        order = np.lexsort((self.random.random(len(states)), steps[states], away))
        target, action = int(states[order[0]]), int(actions[order[0]])
        return [*model.way_to(state, target), action]
