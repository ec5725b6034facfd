"""A plan through the free space: what has not been seen is taken as free, and walls are found by walking into them."""

from __future__ import annotations

import numpy as np

from ptl.agent._kernel import Learner
from ptl.config import Parameters
from ptl.methods._base import BaseMethod
from ptl.world.gridworld import MOVES, GridWorld
from ptl.world.transitions import TransitionGraph


class Method(BaseMethod):
    """Takes a shortest path to the goal over all cells that are no wall by what it knows, and finds walls by bumping.

    A. Stentz, Optimal and efficient path planning for partially-known environments, ICRA 1994; S. Koenig, M. Likhachev,
    D* Lite, AAAI 2002. The paths are those of D* Lite; here they are searched for anew whenever a wall is found. A cell
    is a wall if a move into it left the agent where it was, unless it has been entered in this task; if no path is
    left, all walls are forgotten (our choice: an uncertain move may fail without a wall).

    Knows the goal's coordinates, as `ptl`, its own, the size of the map and the direction of each action. It has no
    skill, and every task begins without walls, so it shows how much of a skill's gain is the goal's direction.
    """

    label = "Plan in free space, forgotten"
    colour = "#cab2d6"

    def __init__(self, world: GridWorld, parameters: Parameters, random: np.random.Generator) -> None:
        super().__init__(world, parameters, random)
        rows, columns = world.shape
        places = np.stack(np.divmod(np.arange(rows * columns), columns), axis=1)
        beyond = (places[:, None] + MOVES).clip(0, [rows - 1, columns - 1])
        self.next_cells = (beyond[..., 0] * columns + beyond[..., 1]).astype(np.int32)
        self.cell_of = (world.cells[:, 0] * columns + world.cells[:, 1]).tolist()
        self.forget()

    def forget(self) -> None:
        """Take every cell as free that has not been found to be a wall in this task."""
        self.walls = np.zeros(len(self.next_cells), dtype=bool)
        self.entered = np.zeros(len(self.next_cells), dtype=bool)

    def begin_task(self, start: int, goal: int) -> np.ndarray | None:
        self.goal = self.cell_of[goal]
        self.forget()
        self.entered[self.cell_of[start]] = True
        self._plan()
        return None

    def run_episode(self, learner: Learner) -> list[int]:
        cell = self.cell_of[learner.state]
        while not (cell == self.goal or learner.truncated):
            if self.policy[cell] < 0:
                self.walls[:] = False
                self._plan()
            action = self.policy[cell]
            after = self.cell_of[learner.act(action)]
            if after == cell:
                self._bump(int(self.next_cells[cell, action]))
            elif not self.entered[after]:
                self._enter(after)
            cell = after
        return []

    def _bump(self, wall: int) -> None:
        if not self.entered[wall]:
            self.walls[wall] = True
            self._plan()

    def _enter(self, cell: int) -> None:
        self.entered[cell] = True
        if self.walls[cell]:
            self.walls[cell] = False
            self._plan()

    def _plan(self) -> None:
        free = np.packbits(~self.walls[self.next_cells], axis=1, bitorder="little")[:, 0]
        self.policy = TransitionGraph(self.next_cells, free).shortest_path_policy(self.goal).tolist()
