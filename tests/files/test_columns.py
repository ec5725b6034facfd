"""Columns of tables: which are texts, and which other values than numbers are refused."""

from __future__ import annotations

import pytest

from ptl.errors import UserError
from ptl.files.tables import check_numbers, read_table


def test_names_are_texts_and_only_empty_cells_are_missing(tmp_path):
    path = tmp_path / "table.csv"
    path.write_text("map,task,steps,note\n300,NA,1.5,nan\n,1,,\n")
    frame = read_table(path, ["map", "steps"], texts=["map"])
    assert frame["map"].tolist()[0] == "300" and frame["task"].tolist() == ["NA", "1"] and frame["note"][0] == "nan"
    assert frame.isna().to_numpy().tolist() == [[False] * 4, [True, False, True, True]]
    with pytest.raises(UserError, match="no column 'seed'; remove the table and run the workflow again"):
        read_table(path, ["map", "seed"])


@pytest.mark.parametrize("value", ["", "nan", "inf", "-inf", "many", "1e999", "0x10", "True", "1.5", "-1"])
def test_other_values_than_whole_numbers_are_refused(tmp_path, value):
    path = tmp_path / "table.csv"
    path.write_text(f"seed,other\n1,0\n{value},0\n")
    frame = read_table(path, ["seed"])
    with pytest.raises(UserError, match=r"row 2: seed '.*' is not allowed; give a whole number from 0 up"):
        check_numbers(frame, path, ["seed"], low=0)
    if value in {"1.5", "-1"}:
        check_numbers(frame, path, ["seed"])
    if value in {"", "-1"}:
        check_numbers(frame, path, ["seed"], low=-1, missing=True)
