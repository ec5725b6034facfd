"""The front page of the report."""

from __future__ import annotations

import pandas as pd
from docutils.core import publish_parts

from ptl.report.front_page import compose, compose_page

CLAIMS = pd.DataFrame(
    {
        "id": ["a", "b", "c"],
        "claim": ["A", "B", "C"],
        "verdict": ["reproduced", "not reproduced", "reproduced"],
        "verdict_30": ["reproduced", "partly reproduced", "partly reproduced"],
    }
)
METRICS = pd.DataFrame(
    [
        {"environment": "env1", "task": "F", "method": method, "metric": "transfer_ratio", "mean": mean,
         "ci_low": mean - 0.1, "ci_high": mean + 0.1, "seeds": 30}
        for method, mean in [("no_transfer", 0.0), ("ptl", 0.9), ("full_transfer", -0.4)]
    ]
)  # fmt: skip
LABELS = {"no_transfer": "No transfer", "ptl": "PTL", "full_transfer": "Full transfer"}


def page(**changes) -> str:
    arguments = {"claims": CLAIMS, "metrics": METRICS, "titles": {"env1": "Environment 1"},
                 "tasks": {"env1": "EF"}, "labels": LABELS} | changes  # fmt: skip
    return compose(**arguments)


def test_front_page_counts_the_verdicts_and_names_what_failed():
    text = page()
    assert "Of 3 claims of the article, **2 reproduced**, **1 not reproduced**." in text
    assert "seeds of the tables alone would say: 1 reproduced, 2 partly reproduced." in text
    assert "Not reproduced: b." in text
    assert "Not reproduced" not in page(claims=CLAIMS[CLAIMS.verdict == "reproduced"])


def test_front_page_shows_the_main_table_without_the_base():
    text = page()
    assert "0.9 [0.8, 1]" in text and "−0.4 [−0.5, −0.3]" in text
    assert "* - No transfer" not in text
    assert "not in this run" in page(labels={**LABELS, "policy_reuse": "Policy reuse"})


def test_front_page_heads_nothing_with_a_first_task_and_says_why_intervals_are_missing():
    assert "Transfer ratio on the last task" not in page(tasks={"env1": "F"})
    assert "30 seeds with its interval;" in page()
    assert "3 seeds (no interval: fewer than 5);" in page(metrics=METRICS.assign(seeds=3))


def test_front_page_is_proper_restructured_text():
    for text in (page(), page(claims=None)):
        html = publish_parts(text, writer="html", settings_overrides={"halt_level": 2, "report_level": 2})
        assert "<table" in html["html_body"]


def test_front_page_of_another_study_is_silent_on_the_article():
    text = page(claims=None)
    assert "Environment 1, task F" in text and "0.9 [0.8, 1]" in text
    assert "article" not in text and "claim" not in text and "Checks" not in text


def test_the_page_shows_verdicts_figures_and_tables_and_escapes_names():
    figures = {"figure12": ("Figure 12: steps", "Mean of <30> seeds.")}
    arguments = {"claims": CLAIMS, "metrics": METRICS, "titles": {"env1": "A <b> room"}, "tasks": {"env1": "EF"}}
    html = compose_page(**arguments, labels=LABELS, figures=figures, tables={"table1": "Table 1. Jump start"})
    assert '<img src="figures/figure12.png" alt="Figure 12: steps"' in html and "Mean of &lt;30&gt; seeds." in html
    assert '<a href="tables/table1.html">Table 1. Jump start</a>' in html
    assert '<a href="claims.html#b">b</a> <b>not reproduced</b>' in html
    assert "A &lt;b&gt; room, task F" in html and "0.9 [0.8, 1]" in html
    neutral = compose_page(**{**arguments, "claims": None}, labels=LABELS, figures=figures, tables={})
    assert "article" not in neutral and "Verdicts" not in neutral and "study</h1>" in neutral


def test_front_page_says_that_the_reading_was_fitted():
    assert "is a fit and no prediction" in page()
