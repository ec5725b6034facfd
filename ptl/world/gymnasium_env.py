"""A map as a Gymnasium environment.

Needs the package ``gymnasium``. One task of the reproduction: reward 1 at the goal, which ends the episode, and
0 elsewhere; a move into a wall leaves the agent where it is. In a world that slips with probability p an action leads
in its own direction with probability 1 - 3 p / 4 and in each other one with probability p / 4. Importing this module
registers the id `ID`:

>>> import gymnasium
>>> import ptl.world.gymnasium_env
>>> env = gymnasium.make("ptl/GridWorld-v0", world="config/environments/env2.txt", goal="A")
>>> state, _ = env.reset(seed=1)
>>> int(state) == env.unwrapped.world.start
True
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ptl.world.gridworld import GridWorld
from ptl.world.map_files import load_map

try:
    import gymnasium
    from gymnasium import spaces
except ImportError as error:
    raise ImportError(
        f"the Gymnasium view needs the package gymnasium ({error}); install it: pip install gymnasium"
    ) from error

ID = "ptl/GridWorld-v0"


class GridWorldEnv(gymnasium.Env[np.int64, np.int64]):
    """One navigation task on a map.

    Parameters
    ----------
    world : GridWorld or path
        A map, or the file of one.
    map_options : mapping, optional
        What a file leaves open: keys of `ptl.config.MapOptions`, say ``{"start": [2, 3], "slip": 0.1}``.
    goal : str
        Letter of the goal.
    random_start : bool
        Start each episode on a random state other than the goal instead of on ``I``.
    render_mode : {"ansi"}, optional
        ``render`` then returns the map as text with the agent as ``@``.

    Notes
    -----
    Observations are states (0 .. n_states - 1), actions 0 .. 3 are north, south, west, east. There is no step limit;
    wrap the environment in ``gymnasium.wrappers.TimeLimit`` for one.
    """

    metadata: dict[str, Any] = {"render_modes": ["ansi"], "render_fps": 10}  # noqa: RUF012 (Gymnasium's own form)

    def __init__(
        self,
        world: GridWorld | str | os.PathLike[str],
        goal: str,
        *,
        random_start: bool = False,
        render_mode: str | None = None,
        map_options: Mapping[str, Any] | None = None,
    ) -> None:
        if render_mode is not None and render_mode not in self.metadata["render_modes"]:
            raise ValueError(f"render_mode must be one of {self.metadata['render_modes']}, not {render_mode!r}")
        self.world = world if isinstance(world, GridWorld) else load_map(Path(world), **(map_options or {}))
        self.goal = self.world.goal(goal)
        self.random_start = random_start
        self.render_mode = render_mode
        self.observation_space = spaces.Discrete(self.world.n_states)
        self.action_space = spaces.Discrete(4)
        self._state = self.world.start

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.int64, dict[str, Any]]:
        """Put the agent on the start; ``seed`` sets the random starts and slips."""
        super().reset(seed=seed)
        self._state = self.world.start
        if self.random_start:
            drawn = int(self.np_random.integers(self.world.n_states - 1))
            self._state = drawn + (drawn >= self.goal)
        return np.int64(self._state), {}

    def step(self, action: np.int64) -> tuple[np.int64, float, bool, bool, dict[str, Any]]:
        """Move; return state, reward, terminated, truncated (always False) and an empty dictionary.

        An action that is not one of 0 to 3 raises ValueError.
        """
        if isinstance(action, bool) or not self.action_space.contains(action):
            raise ValueError(f"action {action!r:.60} is not allowed; give one of 0 to 3 (north, south, west, east)")
        slips = self.world.slip > 0 and self.np_random.random() < self.world.slip
        direction = self.np_random.integers(4) if slips else action
        self._state = int(self.world.successors[self._state, direction])
        terminated = self._state == self.goal
        return np.int64(self._state), float(terminated), terminated, False, {}

    def render(self) -> str | None:  # type: ignore[override]
        """Return the map as text with the agent as ``@``, if the environment was made with ``render_mode="ansi"``."""
        if self.render_mode is None:
            return None
        rows = [list(row) for row in self.world.text.splitlines()]
        row, column = self.world.cells[self._state]
        rows[row][column] = "@"
        return "\n".join(map("".join, rows))


gymnasium.register(ID, "ptl.world.gymnasium_env:GridWorldEnv")
