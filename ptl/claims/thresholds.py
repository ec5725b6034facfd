"""The meaning of the article's vague words. All are our choice, and none was moved to change a verdict.

One word has one meaning in all claims; the ledger prints this list.
"""

from __future__ import annotations

from ptl.claims.reading import DEFAULT
from ptl.text import number, percent

MAJORITY = 0.5
"""A subgoal "lies" somewhere, runs "converge": in more than half of the runs, the minimum for "typical"."""

FAR = 2.0
"""Far fewer, many more, markedly slower: by a factor of at least two, a clearly noticeable change."""

ABOUT = 0.25
"""About a number: within a quarter of it; a reader of "about 80" would accept 60 to 100 and hardly more."""

ABOUT_POINTS = 5.0
"""About a range of percentages: five points beyond either end, half the width of the article's 80-90%."""

FEW_EPISODES = 20
"""A few episodes: a tenth of the 200 of a task. The window of the threshold is the minimum possible number."""

NO_IMPROVEMENT = 20.0
"""Not improved: not significantly, and by less than this share (%) of the base, about the standard error of a
mean first episode over 30 runs (18%)."""

SPIKE = 10.0
"""A spike: this many times the median of the episodes before, a whole unit on the log scale of figure 12."""

LINEAR_EXPONENT = 1.1
"""Linear cost: a power of the size no higher than this; n log n over our sizes would show about 1.15."""

OVERHEAD = 1.01
"""Bytes beyond the entries of the policies and the subgoals that still count as none: one in a hundred."""

MEANINGS = (
    ("lies at, converges, concentrates", f"in more than {percent(MAJORITY)} of the runs"),
    ("far fewer, many more, markedly slower", f"by a factor of {number(FAR)} or more"),
    ("about n", f"between {number(1 - ABOUT)} n and {number(1 + ABOUT)} n"),
    ("about 80-90%", f"up to {number(ABOUT_POINTS)} percentage points beyond either end"),
    (
        "a few episodes",
        f"{FEW_EPISODES} or fewer; the least possible number is measures.window",
    ),
    ("not improved", f"not significantly, and by less than {number(NO_IMPROVEMENT)}% of the mean of the base"),
    (
        "degrades in an episode",
        f"at least {number(SPIKE)} times the steps of the median of the episodes before, as many as measures.window",
    ),
    ("one curve below another", "in every block of as many episodes as measures.window"),
    ("about seven tasks", "as many as growth.breakpoint"),
    ("on a doorway", f"at most {DEFAULT.tolerance} step from a free cell between two opposite walls"),
    ("one loop", f"cost grows with a power of the number of skills of at most {number(LINEAR_EXPONENT)}"),
)
"""Word and meaning, for readers."""
