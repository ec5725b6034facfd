"""Columns of tables: which are texts and numbers, and what is refused in those of other programs."""

from __future__ import annotations

import pytest

from ptl.errors import UserError
from ptl.study.population.collect import LIFE_COLUMNS, TASK_COLUMNS, read_lives, read_tasks
from ptl.study.tables import check_numbers, read_table

LIFE = {
    "family": "chain", "map": "300", "size": "300", "sequence": "increasing", "method": "theirs", "seed": "0",
    "total_steps": "10.5", "optimum": "8", "library_size": "0",
}  # fmt: skip


def test_names_are_texts_and_only_empty_cells_are_missing(tmp_path):
    path = tmp_path / "table.csv"
    path.write_text("map,task,steps,note\n300,NA,1.5,nan\n,1,,\n")
    frame = read_table(path, ["map", "steps"])
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


@pytest.mark.parametrize("column", ["size", "seed", "total_steps", "optimum", "library_size"])
def test_lives_of_other_programs_have_numbers(tmp_path, column):
    path = tmp_path / "lives.csv"
    for change, fault in (({}, None), ({column: "many"}, "many"), ({column: ""}, "")):
        life = {**LIFE, **change}
        path.write_text(",".join(LIFE_COLUMNS) + "\n" + ",".join(life[name] for name in LIFE_COLUMNS) + "\n")
        if fault is None:
            assert read_lives(path)["total_steps"].tolist() == [10.5]
        else:
            with pytest.raises(UserError, match=f"lives.csv: row 1: {column} '{fault}' is not allowed; give a"):
                read_lives(path)


def test_tasks_that_are_counted_are_numbers(tmp_path):
    path = tmp_path / "tasks.csv"
    rows = ["chain", "m", "300", "increasing", "ptl", "0", "0", "1", "10", "5", "8", "0", "1", "300", "0.5"]
    path.write_text(",".join(TASK_COLUMNS) + "\n" + ",".join(rows) + "\n")
    assert read_tasks(path)["task"].tolist() == [1]
