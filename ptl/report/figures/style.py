"""The common look of the figures."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from importlib import import_module
from typing import Any, ParamSpec, TypeVar

import matplotlib as mpl
import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

SLIDE_WIDTH = 13.3
"""Width in inches of a figure that fills a 16:9 slide; the text sizes below are chosen for it."""

INK = "#22262b"
MUTED = "#6b7178"
RULE = "#d9dce0"
WALL = "#3b4149"
FLOOR = "#ffffff"
START = "#0f7f8c"
GOAL = "#b3361e"
ACCENT = "#0f7f8c"
"""Colours that are not those of a method (methods carry their own): text, lines, map cells and emphasis."""

CATEGORIES = ("#6a2c91", "#00767c", "#8a5a00", "#1f3d7a", "#a8244f", "#2f6b1e")
"""Colours of things that are not methods, told apart also by the colour-blind; none is a method's."""


CLASS_COLOURS = {
    "under every reading": "#083d4f",
    "under some readings": "#4fa3ab",
    "in part": "#e6c48f",
    "contradicted": "#b23a1c",
    "by construction": "#e4e6ea",
    "undecided": "#ffffff",
}
"""Colours of the classes of claims (`ptl.claims.degrees.CLASSES`), all different in lightness; those of the pages."""


GROUPED = "{x:,.0f}"
"""Format of the marks of a linear axis of whole numbers that reach 1,000, as `ptl.text.number` writes them."""


def _heat() -> ListedColormap:
    """Return reversed magma from white to deep purple: zero looks like floor, large values do not look like walls."""
    colours = mpl.colormaps["magma_r"](np.arange(216))
    to_paper = np.linspace(1, 0, 30)[:, np.newaxis]
    colours[:30, :3] = to_paper + (1 - to_paper) * colours[:30, :3]
    return ListedColormap(colours, name="ptl_heat")


HEAT = _heat()
"""Colour map, safe for the colour-blind and nearly uniform in perception, from white to deep purple."""

PALE_HEAT = ListedColormap(HEAT(np.linspace(0, 0.55, 256)), name="ptl_pale_heat")
"""The lighter part of `HEAT`, for a ground on which lines are drawn."""

PARAMETERS: dict[str, Any] = {
    "font.family": "DejaVu Sans",  # comes with matplotlib, so figures are the same on every machine
    "font.size": 15,
    "text.color": INK,
    "axes.titlesize": 17,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.titlepad": 9,
    "axes.labelsize": 16,
    "axes.labelcolor": INK,
    "axes.edgecolor": MUTED,
    "axes.linewidth": 1.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "axes.grid": True,
    "grid.color": RULE,
    "grid.linewidth": 0.8,
    "xtick.color": MUTED,
    "ytick.color": MUTED,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "xtick.labelsize": 14,
    "ytick.labelsize": 14,
    "lines.linewidth": 2.4,
    "lines.solid_capstyle": "round",
    "legend.fontsize": 15,
    "legend.frameon": False,
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
    "savefig.bbox": None,
    "svg.hashsalt": "ptl",
    "svg.fonttype": "path",
}
"""Settings of matplotlib under which every figure is drawn and written."""

_P = ParamSpec("_P")
_R = TypeVar("_R")


def styled(draw: Callable[_P, _R]) -> Callable[_P, _R]:
    """Run a drawing function under `PARAMETERS`, independent of the caller's matplotlib settings."""

    @wraps(draw)
    def wrapper(*args: _P.args, **kwargs: _P.kwargs) -> _R:
        with mpl.rc_context():
            mpl.rcdefaults()
            mpl.rcParams.update(PARAMETERS)  # type: ignore[arg-type]
            return draw(*args, **kwargs)

    return wrapper


def new_figure(width: float, height: float, compress: bool = False) -> Figure:
    """Return an empty figure of this size in inches, without pyplot and its global state.

    ``compress`` pushes panels of fixed aspect (maps) together.
    """
    layout = ConstrainedLayoutEngine(w_pad=0.09, h_pad=0.09, wspace=0.03, hspace=0.03, compress=compress)
    return Figure(figsize=(width, height), layout=layout)


def method_look(identifier: str) -> tuple[str, str]:
    """Return colour and label of a method, the same in every figure (they are attributes of the method itself)."""
    # imported by name: only the rules of figures that show methods depend on them
    method = import_module("ptl.methods").load(identifier)
    return method.colour, method.label
