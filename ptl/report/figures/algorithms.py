"""Figure 2: the two algorithms of the method, with the constants of the run."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd
from matplotlib.patches import FancyBboxPatch

from ptl.report.figures import style
from ptl.text import number

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ptl.config import Parameters
    from ptl.report.script import Script

LINE, INDENT, FONT = 0.3, 0.3, 12.5
"""Height of a line and width of an indent in inches, and size of the type."""

USES = {
    "lead_in": ("follow its policy to its subgoal", "explore ε-greedily"),
    "reselect": ("follow its policy to its subgoal", "explore ε-greedily for p steps"),
    "initiation_set": (
        "follow its policy to its subgoal",
        "explore ε-greedily for p steps, and follow it again",
        "from states of its initiation set whose Q is unknown",
        "unless i = 0, explore for p steps more",
    ),
    "mixing": ("explore for p steps with its policy mixed in by π-reuse",),
    "initial_values": ("explore ε-greedily",),
}
"""What a drawn skill does, by ``skills.skill_use``."""


def make(script: Script) -> tuple[Figure, pd.DataFrame]:
    """Draw both algorithms as the run's settings have them."""
    frame = algorithms(script.parameters)
    return draw(frame), frame


def algorithms(parameters: Parameters) -> pd.DataFrame:
    """Return the lines of the algorithms, columns algorithm, title, line (from 1), indent, text and constants."""
    learning, skills, subgoals = parameters.learning, parameters.skills, parameters.subgoals
    again, once = skills.skill_use not in ("lead_in", "initial_values"), skills.skill_use == "initial_values"
    draw = ("draw candidate i with probability ∝ v(i)^κ P(i | g)", f"κ = {number(skills.likelihood_exponent)}")
    known = "a subgoal" if subgoals.known == "subgoals" else "a subgoal or a skill's path"
    learn = [
        (0, "given: a task with goal g, a library with skills 1 … n", ""),
        (0, "candidates: the skills" + ", and 0 for no guidance" * skills.null_skill, ""),
        (0, "v(i) ← 1 for every candidate", ""),
        *([(0, *draw)] if once else []),
        (0, "Q ← " + ("the values of its policy" if once else "0"), ""),
        (0, f"for each of {number(learning.episodes)} episodes:", ""),
        *([(1, "p ← patience in steps", f"{number(skills.patience)} × number of states")] * again),
        (1, "until the goal is reached:", ""),
        *([] if once else [(2, *draw)]),
        *((2, line, "") for line in USES[skills.skill_use]),
        *([(2, "p ← patience factor × p", number(skills.patience_growth))] * again),
        *(
            []
            if once
            else [
                (1, "v(i) of each candidate i that was drawn:  1 / steps at first,", ""),
                (2, "then (1 − β) v(i) + β / steps of the episode", f"β = {number(skills.likelihood_weight)}"),
                (1, "v(i) of those never drawn:  the best v", ""),
            ]
        ),
        (0, "in each step:  Q(s,a) ← Q(s,a) + α (r + γ max Q(s′,·) − Q(s,a))", ""),
        (1, "", f"α = {number(learning.alpha)},  γ = {number(learning.gamma)},  ε = {number(learning.epsilon)}"),
    ]
    discover = [
        (0, "given: the paths of the first T successful episodes", f"T = {number(subgoals.trajectories)}"),
        (0, "erase the loops of every path", ""),
        (0, f"covered ← states within r steps of {known}", f"r = {number(subgoals.cover_radius)}"),
        (0, "rest of a path ← what follows its last covered state", ""),
        (0, "for every state s on a rest:", ""),
        (1, "f(s) ← share of the rests that contain s", ""),
        (1, "d(s) ← mean distance from the ends of the rest", f"0 to 1, {subgoals.distance_form}"),
        (0, "s* ← the state with the greatest f(s) d(s)", ""),
        (0, "D ← the longest shortest path between visited states", ""),
        (0, "if the mean length of the rests is at least ρ D,", f"ρ = {number(subgoals.novelty)}"),
        (0, "f(s*) d(s*) is at least θ, and s* is no subgoal yet:", f"θ = {number(subgoals.threshold)}"),
        (1, "π ← shortest ways to s* over the transitions seen", ""),
        *([(1, "initiation set ← states before s* on the paths", "")] * (skills.skill_use == "initiation_set")),
        (1, "add the skill (s*, π) to the library", ""),
    ]
    titles = ("Algorithm 1: learn a task with the library", "Algorithm 2: find a subgoal, add a skill")
    return pd.DataFrame(
        [
            (place, title, line, *row)
            for place, (title, lines) in enumerate(zip(titles, (learn, discover), strict=True), start=1)
            for line, row in enumerate(lines, start=1)
        ],
        columns=["algorithm", "title", "line", "indent", "text", "constants"],
    )


@style.styled
def draw(frame: pd.DataFrame) -> Figure:
    """Draw a box for each algorithm, side by side; constants stand at its right edge."""
    height, width = LINE * (frame["line"].max() + 3.4), style.SLIDE_WIDTH / 2
    figure = style.new_figure(style.SLIDE_WIDTH, height)
    figure.set_layout_engine("none")
    axes = figure.add_axes((0, 0, 1, 1), xlim=(0, style.SLIDE_WIDTH), ylim=(height, 0))
    axes.axis("off")
    for place, (_, part) in enumerate(frame.groupby("algorithm")):
        left, right = place * width + 0.12, (place + 1) * width - 0.12
        box = FancyBboxPatch(
            (left, 0.12), right - left, height - 0.24, boxstyle="round,pad=0,rounding_size=0.12",
            facecolor=style.FLOOR, edgecolor=style.RULE,
        )  # fmt: skip
        axes.add_patch(box)
        axes.text(left + 0.2, 0.5, part["title"].iloc[0], fontsize=16, fontweight="bold", va="center")
        for row in part.itertuples():
            y = 0.55 + LINE * (row.line + 0.4)
            axes.text(left + 0.42, y, row.line, fontsize=10, color=style.MUTED, va="center", ha="right")
            axes.text(left + 0.55 + INDENT * row.indent, y, row.text, fontsize=FONT, va="center")
            axes.text(right - 0.15, y, row.constants, fontsize=FONT, color=style.ACCENT, va="center", ha="right")
    return figure
