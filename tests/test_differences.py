"""The page of differences names claims and parts that the ledger really has."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest

from ptl.differences import DIFFERENCES, differences_page
from ptl.errors import UserError

PUBLISHED = Path(__file__).resolve().parent.parent / "reports/published"


def ledger() -> tuple[pd.DataFrame, pd.DataFrame]:
    claims = pd.DataFrame({"id": [item.claim for item in DIFFERENCES], "verdict": "partly reproduced"})
    parts = pd.DataFrame(
        [
            {"id": item.claim, "part": part, "estimate": 12345.6, "low": 0.1234, "high": 2.0, "unit": "steps"}
            for item in DIFFERENCES
            for part in item.parts
        ]
    )
    return claims, parts


def test_numbers_and_verdicts_come_from_the_ledger():
    claims, parts = ledger()
    claims.loc[0, "verdict"] = "reproduced"
    page = differences_page(claims, parts)
    assert len(page.rows) == len(DIFFERENCES)
    assert "12,346 [0.123, 2] steps" in page.rows[0][2]
    assert page.rows[0][3] == "reproduced" and page.rows[1][3] == "partly reproduced"
    assert all(row[4] for row in page.rows)


def test_a_part_that_the_run_lacks_is_said_to_be_missing():
    claims, parts = ledger()
    page = differences_page(claims, parts[parts["id"] != DIFFERENCES[0].claim])
    assert page.rows[0][2] == "not in this run"


def test_a_ledger_without_a_claim_is_refused():
    claims, parts = ledger()
    with pytest.raises(UserError, match="no claim"):
        differences_page(claims[1:], parts)


def test_every_part_named_is_in_the_published_ledger():
    published = pd.read_csv(PUBLISHED / "claims_parts.csv")
    known = set(zip(published["id"], published["part"], strict=True))
    missing = [(item.claim, part) for item in DIFFERENCES for part in item.parts if (item.claim, part) not in known]
    assert not missing


def test_document_holds_the_published_table():
    document = (PUBLISHED.parent.parent / "docs/differences.md").read_text(encoding="utf-8")
    shown = document.partition("<!-- published: differences, begin -->")[2]
    shown = shown.partition("<!-- published: differences, end -->")[0].strip()
    assert shown == (PUBLISHED / "differences.md").read_text(encoding="utf-8").strip()
