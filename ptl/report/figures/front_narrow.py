"""The picture on the first page, with its panels below each other for a phone."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ptl.report.figures import front

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from ptl.report.script import Script


def make(script: Script) -> tuple[Figure, pd.DataFrame]:
    """Draw the same numbers."""
    return front.make(script, narrow=True)
