"""The front page of the report."""

from __future__ import annotations

import pandas as pd
from docutils.core import publish_parts

from ptl.claims.degrees import CLASSES
from ptl.report.front_page import compose, compose_page

CLAIMS = pd.DataFrame(
    {
        "id": ["a", "b", "c"],
        "claim": ["A", "B", "C"],
        "class": ["contradicted", "under every reading", "under some readings"],
        "holds_when": ["", "", "on task F"],
    }
)
STEPS = pd.DataFrame(
    [
        {"environment": "env1", "tasks": tasks, "method": method, "ratio": ratio, "low": ratio - 0.1,
         "high": ratio + 0.1}
        for tasks, ptl in (("EF", 0.4), ("E", 0.7), ("F", 0.1))
        for method, ratio in [("ptl", ptl), ("full_transfer", 1.4), ("policy_reuse", 11.5)]
    ]
)  # fmt: skip
LABELS = {"no_transfer": "No transfer", "ptl": "PTL", "full_transfer": "Full transfer"}
ARGUMENTS = {
    "claims": CLAIMS,
    "steps": STEPS,
    "seeds": 30,
    "titles": {"env1": "Environment 1"},
    "labels": LABELS,
    "run": "lab",
}


def page(**changes) -> str:
    return compose(**(ARGUMENTS | changes))


def test_front_page_counts_the_classes():
    counted = "1 holds under every reading of the words, 1 holds under some readings only and 1 is contradicted"
    assert f"Of 3 claims of the article, {counted}." in page()


def test_front_page_shows_all_tasks_together_before_the_last_and_no_base():
    text = page()
    assert text.index("Environment 1, E to F together") < text.index("Environment 1, F (last task)")
    assert "60% [50, 70]" in text and "90% [80, 100]" in text and "−40% [−50, −30]" in text
    assert "30% [20, 40]" not in text
    assert "* - No transfer" not in text
    assert "11.5 [11.4, 11.6] times as many" in page(labels={**LABELS, "policy_reuse": "Policy reuse"})
    assert "not in this run" in page(labels={**LABELS, "other": "Another"})


def test_a_single_task_with_transfer_is_shown_once():
    assert page(steps=STEPS[STEPS.tasks == "F"]).count("Environment 1, ") == 1


def test_front_page_says_why_there_is_no_table_and_no_interval():
    assert "Steps saved" not in page(steps=None)
    assert "30 seeds with its interval;" in page()
    assert "3 seeds (no interval: fewer than 5);" in page(seeds=3)


def test_front_page_is_proper_restructured_text():
    for text in (page(), page(claims=None)):
        html = publish_parts(text, writer="html", settings_overrides={"halt_level": 2, "report_level": 2})
        assert "<table" in html["html_body"]


def test_front_page_of_another_study_is_silent_on_the_article():
    text = page(claims=None)
    assert "Environment 1, F (last task)" in text and "90% [80, 100]" in text
    assert "article" not in text and "claim" not in text and "Checks" not in text


def test_the_page_shows_claims_figures_and_tables_and_escapes_names():
    figures = {"figure12": ("Figure 12: steps", "Mean of <30> seeds.", False)}
    figures |= {f"map_{name}": (f"Map of {name}", "Ours.", True) for name in "ab"}
    arguments = ARGUMENTS | {"titles": {"env1": "A <b> room"}, "figures": figures, "caption": "All <tasks>."}
    html = compose_page(**arguments, tables={"table1": "Table 1. Jump start"})
    assert (
        '<img src="figures/figure12.png" srcset="figures/figure12.png 2.8x" alt="Figure 12: steps"' in html
        and "Mean of &lt;30&gt; seeds." in html
    )
    small = html.partition('<div class="small">')[2].partition("</div>")[0]
    assert html.count("<figure id=") == 3 and small.count("<figure id=") == 2
    assert '<a href="tables/table1.html">Table 1. Jump start</a>' in html
    assert 'srcset="figures/front_narrow.png"' in html and "All &lt;tasks&gt;." in html
    assert "A &lt;b&gt; room, F (last task)" in html and "90% [80, 100]" in html
    places = [html.index(f'href="claims.html#{name}"') for name in "bca"]
    assert places == sorted(places), "claims are in the order of the classes"
    assert "<b>under some readings</b>: on task F" in html
    assert all(CLASSES[name] in html for name in CLAIMS["class"])
    assert "Undecided are" not in html
    claims = CLAIMS.assign(**{"class": "undecided"})
    assert "these runs are too few to decide" in compose_page(**{**arguments, "claims": claims}, tables={})
    neutral = compose_page(**{**arguments, "claims": None}, tables={})
    body = neutral.partition("<body>")[2]
    assert "article" not in body and "laim" not in body and "<h1>lab</h1>" in body
    assert "front.png" not in compose_page(**{**arguments, "caption": ""}, tables={})


def test_front_page_says_that_the_settings_were_fitted():
    assert "a fit and no prediction" in page()
