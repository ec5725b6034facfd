"""What columns of numbers can hold, for every column of the tables that jobs hand to each other."""

from __future__ import annotations

import pandas as pd
import pytest
from projects import ROOT

from ptl.errors import UserError
from ptl.files.tables import COLUMNS, NAMES, read_table
from ptl.measures.growth import COLUMNS as GROWTH_COLUMNS
from ptl.measures.library_cost import SELECTION_COLUMNS, STORAGE_COLUMNS
from ptl.measures.measures import PER_SEED_COLUMNS, SUBGOAL_COLUMNS

TABLES = ("per_seed", "subgoals", "growth", "selection_cost", "library_bytes")


@pytest.mark.parametrize("name", TABLES)
def test_published_tables_hold_what_they_can(name):
    path = ROOT / f"reports/published/tables/{name}.csv"
    assert len(read_table(path, pd.read_csv(path, nrows=0).columns))


def test_every_column_of_numbers_is_declared():
    texts = {*NAMES, "reason", "task"}
    costs = (SELECTION_COLUMNS, STORAGE_COLUMNS)
    for columns in (*costs, GROWTH_COLUMNS, PER_SEED_COLUMNS, SUBGOAL_COLUMNS):
        assert set(columns) - texts <= set(COLUMNS)


def refused(column: str) -> list[str]:
    """Values that a column cannot hold."""
    numbers = COLUMNS[column]
    wrong = ["inf", "-inf", "many", "1e999", "0x10", "True"]
    wrong += [] if numbers.missing else ["", "nan"]
    wrong += ["1.5"] if numbers.whole else []
    wrong += [str(numbers.low - 1)] if numbers.low > -1e300 else []
    return wrong + ([str(numbers.high + 1)] if numbers.high < 1e300 else [])


@pytest.mark.parametrize("column", COLUMNS)
def test_what_a_column_cannot_hold_is_refused_in_one_line(column, tmp_path, record_property):
    record_property("impossible values in tables, all refused", len(refused(column)))
    path = tmp_path / "table.csv"
    for value in refused(column):
        path.write_text(f"{column},other\n1,0\n{value},0\n")
        with pytest.raises(UserError, match=f"column '{column}' must hold ") as caught:
            read_table(path, [column])
        assert str(COLUMNS[column]) in str(caught.value) and "\n" not in str(caught.value)
    path.write_text(f"{column},other\n1,0\n" + ",0\n" * COLUMNS[column].missing)
    assert len(read_table(path, [column])) == 1 + COLUMNS[column].missing
