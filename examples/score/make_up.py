"""Write made_up.csv, a table of random numbers in the form that `ptl score` takes. They are not the article's.

The numbers follow neither from runs of this package nor from anything printed: steps are powers of ten with a uniform
exponent, episodes and ratios are uniform, and a standard deviation is a uniform part of its mean.
"""

from __future__ import annotations

import random
from collections.abc import Iterator
from pathlib import Path

TARGET = Path(__file__).with_name("made_up.csv")
METHODS = ("no_transfer", "full_transfer", "policy_reuse", "ptl", "ptl_supervised", "ptl_unknown_goal")
FIRST_LINE = "# MADE UP: random numbers for trying ptl score, not the article's tables; see make_up.py"


def rows() -> Iterator[str]:
    """Yield the lines of the file."""
    uniform = random.Random("made up").uniform
    yield FIRST_LINE
    yield "table,environment,task,method,measure,mean,sd"
    for number in (1, 2, 3):
        for table, measures in (
            (2 * number - 1, ("jump_start", "asymptotic", "threshold_episode")),
            (2 * number, ("total_steps", "transfer_ratio")),
        ):
            for task in "BCDEF":
                for method in METHODS:
                    for measure in measures:
                        if method == "no_transfer" and measure in ("jump_start", "transfer_ratio"):
                            continue  # 0 by definition
                        if measure == "transfer_ratio":
                            mean = uniform(-1, 1)
                        elif measure == "threshold_episode":
                            mean = uniform(10, 200)
                        else:
                            mean = 10 ** uniform(1.5, 4) * (100 if measure == "total_steps" else 1)
                        deviation = abs(mean) * uniform(0.1, 1)
                        yield f"{table},env{number},{task},{method},{measure},{mean:.2f},{deviation:.2f}"


if __name__ == "__main__":
    TARGET.write_text("".join(f"{row}\n" for row in rows()), encoding="utf-8", newline="\n")
