"""Tables of lives: what is refused in those of other programs."""

from __future__ import annotations

import pytest

from ptl.errors import UserError
from studies.beyond.collect import LIFE_COLUMNS, TASK_COLUMNS, read_lives, read_tasks

LIFE = {
    "family": "chain", "map": "300", "size": "300", "sequence": "increasing", "method": "theirs", "seed": "0",
    "total_steps": "10.5", "optimum": "8", "library_size": "0",
}  # fmt: skip


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
    rows = [
        "chain",
        "m",
        "300",
        "increasing",
        "0",
        "none",
        "ptl",
        "0",
        "0",
        "1",
        "10",
        "5",
        "2.5",
        "8",
        "0",
        "1",
        "300",
        "0.5",
    ]
    path.write_text(",".join(TASK_COLUMNS) + "\n" + ",".join(rows) + "\n")
    assert read_tasks(path)["task"].tolist() == [1]
