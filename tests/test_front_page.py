"""The front page of the report and the manifest."""

from __future__ import annotations

import json
from pathlib import Path

import pandas as pd
import pytest
from docutils.core import publish_parts

from ptl.errors import UserError
from ptl.front_page import compose
from ptl.manifest import build, differences

CLAIMS = pd.DataFrame(
    {"id": ["a", "b", "c"], "claim": ["A", "B", "C"], "verdict": ["reproduced", "not reproduced", "reproduced"]}
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
                 "last_tasks": {"env1": "F"}, "labels": LABELS} | changes  # fmt: skip
    return compose(**arguments)


def test_front_page_counts_the_verdicts_and_names_what_failed():
    text = page()
    assert "Of 3 claims, **2 reproduced**, **1 not reproduced**." in text
    assert "Not reproduced: b." in text
    assert "Not reproduced" not in page(claims=CLAIMS[CLAIMS.verdict == "reproduced"])


def test_front_page_shows_the_main_table_without_the_base():
    text = page()
    assert "0.90 [0.80, 1.00]" in text and "-0.40 [-0.50, -0.30]" in text
    assert "* - No transfer" not in text
    assert "not in this run" in page(labels={**LABELS, "policy_reuse": "Policy reuse"})


def test_front_page_is_proper_restructured_text():
    html = publish_parts(page(), writer="html", settings_overrides={"halt_level": 2, "report_level": 2})
    assert "<table" in html["html_body"]


@pytest.fixture
def products(tmp_path) -> tuple[Path, Path]:
    folder = tmp_path / "run"
    (folder / "tables").mkdir(parents=True)
    (folder / "tables/metrics.csv").write_text("a,b\n1,2\n")
    (folder / "tables/selection_cost.csv").write_text("skills,seconds\n1,2e-5\n")
    manifest = build(sorted(folder.rglob("*.csv")), folder, {"run": "run"})
    (tmp_path / "manifest.json").write_text(json.dumps(manifest))
    return folder, tmp_path / "manifest.json"


def test_a_run_equals_its_own_manifest(products):
    assert differences(*products) == []


def test_changed_and_missing_products_are_found_but_measured_times_may_differ(products):
    folder, manifest = products
    (folder / "tables/selection_cost.csv").write_text("skills,seconds\n1,3e-5\n")
    assert differences(folder, manifest) == []
    (folder / "tables/metrics.csv").write_text("a,b\n1,3\n")
    [line] = differences(folder, manifest)
    assert "metrics.csv: differs" in line
    (folder / "tables/metrics.csv").unlink()
    [line] = differences(folder, manifest)
    assert "is missing; run 'snakemake " in line


def test_what_is_no_manifest_is_refused(tmp_path):
    (tmp_path / "manifest.json").write_text("[]")
    with pytest.raises(UserError, match="is not a manifest"):
        differences(tmp_path, tmp_path / "manifest.json")
