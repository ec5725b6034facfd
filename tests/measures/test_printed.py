"""Printed tables that are typed in: what is accepted, and the line that refuses the rest."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from predictions import normal_predictions

from ptl.errors import UserError
from ptl.measures.printed import COLUMNS, read_printed, template

CELLS = [
    ("1", "env1", "B", "ptl", "asymptotic"),
    ("1", "env1", "B", "ptl", "jump_start_percent"),
    ("4", "env2", "F", "no_transfer", "total_steps"),
]
PREDICTIONS = normal_predictions(CELLS, np.zeros(3), np.ones(3)).query(
    "measure != 'jump_start_percent' or statistic == 'mean'"
)
HEADER = ",".join(COLUMNS)
GOOD = f"{HEADER}\n1,env1,B,ptl,asymptotic,101.5,3\n"


def read(folder: Path, content: str | bytes) -> pd.DataFrame:
    path = folder / "printed.csv"
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return read_printed(path, PREDICTIONS)


@pytest.mark.parametrize(
    "content",
    [
        GOOD,
        GOOD.encode("utf-8-sig"),
        GOOD.replace("\n", "\r\n"),
        f"# a comment, with a comma\n\n{GOOD},,,,,,\n",
        "sd,mean,measure,method,task,environment,table\n3.0,+101.50, asymptotic ,ptl,B,env1,1\n",
        f"{HEADER},source\n1,env1,B,ptl,asymptotic,101.5,3,page 7\n",
        f"{GOOD}4,env2,F,no_transfer,total_steps,,\n",
    ],
)
def test_accepted_forms(tmp_path: Path, content: str | bytes):
    assert read(tmp_path, content).to_dict("records") == [
        dict(zip(COLUMNS, ("1", "env1", "B", "ptl", "asymptotic", 101.5, 3.0), strict=True))
    ]


def test_numbers_may_be_missing_and_have_the_printed_minus(tmp_path: Path):
    frame = read(tmp_path, f"{HEADER}\n1,env1,B,ptl,asymptotic,−2,\n4,env2,F,no_transfer,total_steps,,1e5\n")
    np.testing.assert_array_equal(frame[["mean", "sd"]], [[-2, np.nan], [np.nan, 1e5]])
    frame = read(tmp_path, GOOD.replace(",sd", "").replace(",3", ""))
    np.testing.assert_array_equal(frame[["mean", "sd"]], [[101.5, np.nan]])


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (GOOD.replace("asymptotic", "asymptote"), "line 2: measure 'asymptote' of table 1, environment env1, task B, "
         "method ptl is not in the predictions; give one of asymptotic, jump_start_percent"),
        (GOOD.replace("1,env1", "7,env1"), "line 2: table '7' is not in the predictions; give one of 1, 4"),
        (GOOD.replace("1,env1", "4,env1"), "line 2: environment 'env1' of table 4 .* give one of env2"),
        (GOOD.replace("101.5", "many"), "line 2: mean 'many' is not allowed; give a number with a decimal point"),
        (GOOD.replace("101.5", '"101,5"'), "line 2: mean '101,5' is not allowed"),
        (GOOD.replace("101.5", "101,5"), "line 2: has 8 values for 7 columns; numbers take a decimal point"),
        (GOOD.replace("101.5", "nan"), "line 2: mean 'nan' is not allowed"),
        (GOOD.replace("101.5", "91%"), "line 2: mean '91%' is not allowed"),
        (GOOD.replace("101.5", "4 ± 1"), "line 2: mean '4 ± 1' is not allowed"),
        (GOOD.replace("101.5,3", "101.5,-3"), "line 2: sd '-3' is negative"),
        (GOOD.replace(",3", ""), "line 2: has 6 values for 7 columns"),
        (GOOD.replace("mean", "average"), "no column 'mean'; give the columns table,.*,sd, separated by commas"),
        (GOOD.replace(",", ";"), "no column 'table'; give the columns .* separated by commas"),
        (GOOD.replace("sd", "mean"), "more than one column 'mean'"),
        (GOOD + GOOD.splitlines()[1], "line 3: table '1', .* is given again"),
        (f"{HEADER}\n1,env1,B,ptl,jump_start_percent,85,3\n", "line 2: .* has no sd; leave it empty"),
        (f"{HEADER}\n1,env1,B,ptl,asymptotic,,\n", "has no printed value"),
        ("", "no column 'table'"),
        (GOOD.replace("101.5", '"101.5'), "is not CSV"),
        ((GOOD + "# Gökçe\n").encode("latin-1"), "is not UTF-8 text .*; save it as CSV in UTF-8"),
        (GOOD.encode("utf-16"), "is not UTF-8 text"),
    ],
)  # fmt: skip
def test_refused_in_one_line(tmp_path: Path, content: str | bytes, words: str):
    with pytest.raises(UserError, match=words) as refusal:
        read(tmp_path, content)
    assert str(refusal.value).startswith(f"{tmp_path}/printed.csv: ") and "\n" not in str(refusal.value)


def test_missing_file(tmp_path: Path):
    with pytest.raises(UserError, match=r"printed.csv: cannot be read \(.*\); give a CSV file"):
        read_printed(tmp_path / "printed.csv", PREDICTIONS)


def test_the_template_names_every_cell_once_and_can_be_filled_in(tmp_path: Path):
    text = template(PREDICTIONS)
    with pytest.raises(UserError, match="has no printed value"):
        read(tmp_path, text)
    filled = read(tmp_path, text.replace(",,\n", ",7,\n"))
    assert [tuple(row) for row in filled[list(COLUMNS[:5])].to_numpy()] == CELLS
    assert filled["mean"].tolist() == [7, 7, 7]
