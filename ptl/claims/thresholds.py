"""What the article's vague words mean here. All are our choice, and none was moved to change a verdict.

One word has one meaning in all claims; the ledger prints this list.
"""

from __future__ import annotations

MOST = 0.5
"""A subgoal "lies" somewhere, runs "converge": in more than half of the runs, the least that is typical."""

FAR = 2.0
"""Far fewer, many more, markedly slower: by a factor of two at least, a change that nobody calls slight."""

ABOUT = 0.25
"""About a number: within a quarter of it; a reader of "about 80" would accept 60 to 100 and hardly more."""

ABOUT_POINTS = 5.0
"""About a range of percentages: five points beyond either end, half the width of the article's 80-90 %."""

FEW_EPISODES = 20
"""A few episodes: a tenth of the 200 of a task. The window of the threshold makes ten the least possible."""

NO_IMPROVEMENT = 20.0
"""Not improved: not significantly, and by less than this share (%) of the base, about the standard error of a
mean first episode over 30 runs (18 %)."""

SPIKE = 10.0
"""A spike: this many times the median of the episodes before, a whole unit on the log scale of figure 12."""

BLOCK = 10
"""Episodes that are averaged to compare curves and to look back from a spike: the window of the measures."""

AT = 1
"""Steps from a doorway that still count as on it: its two neighbours funnel the same paths."""

GROWTH_TASKS = 7
"""The number of tasks up to which the article lets the library grow linearly."""

LINEAR_EXPONENT = 1.1
"""Linear cost: a power of the size no higher than this; n log n over our sizes would show about 1.15."""

OVERHEAD = 1.01
"""Bytes beyond the entries of the policies and the subgoals that still count as none: one in a hundred."""

MEANINGS = (
    ("lies at, converges, concentrates", f"in more than {MOST:.0%} of the runs"),
    ("far fewer, many more, markedly slower", f"by a factor of {FAR:g} or more"),
    ("about n", f"between {1 - ABOUT:g} n and {1 + ABOUT:g} n"),
    ("about 80-90 %", f"up to {ABOUT_POINTS:g} percentage points beyond either end"),
    ("a few episodes", f"{FEW_EPISODES} or fewer (the window of the threshold makes 10 the least possible)"),
    ("not improved", f"not significantly, and by less than {NO_IMPROVEMENT:g} % of the mean of the base"),
    (
        "degrades in an episode",
        f"at least {SPIKE:g} times the steps of the median of the {BLOCK} episodes before",
    ),
    ("one curve below another", f"in every block of {BLOCK} episodes"),
    ("on a doorway", f"at most {AT} step from a free cell between two opposite walls"),
    ("one loop", f"cost grows with a power of the number of skills of at most {LINEAR_EXPONENT:g}"),
)
"""Word and meaning, for readers."""
