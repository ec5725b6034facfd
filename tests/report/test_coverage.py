"""The table of coverage: what it marks and what it says of the worst row."""

from __future__ import annotations

import pandas as pd

from ptl.report.coverage import coverage_page
from ptl.report.table import to_html, to_markdown

LOOKS = {"ptl": ("PTL", "#0072b2")}
TITLES = {"env1": "Environment 1"}


def test_rows_far_below_the_level_are_marked_and_the_worst_is_named():
    values = {"first_episode": 0.93, "asymptotic": 0.4, "total_steps": 0.901}
    frame = pd.DataFrame(
        [("env1", "B", "ptl", name, 1234.5, 1600, value) for name, value in values.items()],
        columns=["environment", "task", "method", "metric", "mean", "runs", "coverage"],
    )
    page = coverage_page(frame, 30, 0.95, LOOKS, TITLES)
    [row] = page.groups[0].rows
    assert [cell.text for cell in row.cells] == ["93%", "40% *", "90.1%"]
    assert "0 of 1 of first episode, 1 of 1 of asymptotic performance, 0 of 1 of total performance" in page.intro
    assert page.notes[0].startswith("Least: 40%, asymptotic performance of Environment 1, task B, PTL.")
    assert "1,234 over 1,600" in to_html(page) and "40% \\*" in to_markdown(page)
