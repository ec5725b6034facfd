"""Figure 3: the prior probability of a skill, by where its subgoal lies, for one goal."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
from matplotlib.colors import LogNorm

from ptl.figures import cells, style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ptl.gridworld import GridWorld
