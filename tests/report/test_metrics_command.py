"""``ptl metrics``: its output for a run, and its errors."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner
from projects import ROOT

from ptl.cli.metrics import command
from ptl.errors import UserError
from ptl.files.csv import read_csv
from ptl.text import estimate


@pytest.fixture(autouse=True)
def in_the_project_folder(monkeypatch):
    monkeypatch.chdir(ROOT)


def printed(*arguments: str, width: int = 200) -> list[str]:
    result = CliRunner().invoke(command, arguments, env={"COLUMNS": str(width)}, catch_exceptions=False)
    assert result.exit_code == 0
    return result.output.splitlines()


def refusal(*arguments: str) -> str:
    result = CliRunner().invoke(command, arguments)
    assert isinstance(result.exception, UserError)
    return str(result.exception)


def test_the_published_run_and_its_last_tasks_are_the_default():
    assert [line for line in printed() if "task" in line and line.startswith("env")] == [
        f"env{place}, task F (30 seeds: mean [interval])" for place in (1, 2, 3)
    ]


def test_a_cell_is_the_estimate_of_the_file():
    lines = printed("published", "-e", "env1", "-m", "ptl", "-x", "total_steps")
    metrics = read_csv("reports/published/tables/metrics.csv").set_index(["environment", "task", "method", "metric"])
    row = metrics.loc["env1", "F", "ptl", "total_steps"]
    assert lines[-2].split("  ")[-1].strip() == estimate(row["mean"], row["ci_low"], row["ci_high"])
    assert lines[-2].startswith("ptl ")


def test_seeds_that_missed_the_threshold_are_counted():
    metrics = read_csv("reports/published/tables/metrics.csv").query("metric == 'threshold_episode'")
    row = metrics[metrics["n"].between(5, 29)].iloc[0]
    text = "\n".join(printed("-e", row["environment"], "-t", row["task"], "-x", "threshold_episode"))
    assert f"({row['n']} of {row['seeds']})" in text
    assert "not reached" in "\n".join(printed("-e", "env1", "-x", "threshold_episode"))


def test_all_tasks_and_the_first_one_is_marked():
    heads = [line for line in printed("-e", "env2", "-t", "all") if line.startswith("env2")]
    assert len(heads) == 6
    assert ["nothing to transfer yet" in head for head in heads] == [True, *[False] * 5]


@pytest.mark.parametrize("width", [60, 90, 200])
def test_lines_fit_the_terminal_and_columns_are_aligned(width):
    lines = printed("-e", "env1", width=width)
    assert max(map(len, lines)) <= width
    blocks = "\n".join(lines[1:]).strip("\n").split("\n\n")
    assert len(blocks) > 1 or width == 200
    for block in blocks:
        assert len({len(line) for line in block.splitlines()}) == 1


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["nowhere"], "reports/nowhere/tables/metrics.csv: no such file; runs with measures: "),
        (["-e", "env9"], "no environment 'env9'; there are env1, env2, env3"),
        (["-t", "Z"], "no task 'Z'; there are A, B"),
        (["-x", "speed"], "no metric 'speed'; there are first_episode"),
    ],
)
def test_unknown_names_are_refused_with_those_that_exist(arguments, message):
    assert message in refusal(*arguments)


def test_few_seeds_promise_no_interval(tmp_path: Path):
    metrics = read_csv("reports/published/tables/metrics.csv").assign(seeds=2)
    metrics.to_csv(tmp_path / "metrics.csv", index=False)
    assert printed(str(tmp_path / "metrics.csv"), "-e", "env1")[0] == "env1, task F (2 seeds: mean)"


@pytest.mark.parametrize(
    ("text", "column"),
    [("a,b\n1,2\n", "environment"), ("environment,task,method,metric\nenv1,A,ptl,total_steps\n", "mean")],
)
def test_another_table_is_refused(tmp_path: Path, text, column):
    path = tmp_path / "other.csv"
    path.write_text(text)
    assert refusal(str(path)).startswith(f"{path}: no column '{column}'")


def test_words_for_numbers_are_refused(tmp_path: Path):
    metrics = read_csv("reports/published/tables/metrics.csv").astype({"mean": str})
    metrics.loc[3, "mean"] = "many"
    metrics.to_csv(tmp_path / "metrics.csv", index=False)
    assert "row 4: mean 'many' is not allowed; give a number" in refusal(str(tmp_path / "metrics.csv"))


ESTIMATES = "environment,task,method,metric,mean,std,ci_low,ci_high,n,seeds\n"


@pytest.mark.parametrize(
    ("rows", "fault"),
    [
        (["1,,1,1,5,"], "row 1: seeds '' is not allowed; give a whole number from 1 up"),
        (["1,,1,1,5,inf"], "seeds 'inf'"),
        (["1,,1,1,5,-5"], "seeds '-5'"), (["1,,1,1,5,0"], "seeds '0'"), (["1,,1,1,5,True"], "seeds 'True'"),
        (["1,,1,1,2.5,5"], "n '2.5'"), (["1,,1,1,-1,5"], "n '-1'"), (["1,,1,1,,5"], "n ''"),
        (["1e400,,1,1,5,5"], "row 1: mean 'inf' is not allowed; give a number"), (["True,,1,1,5,5"], "mean 'True'"),
        (["1,,-inf,1,5,5"], "ci_low '-inf'"), (["1,,2,1,5,5"], "an interval"),
        ([",,,,5,5"], "values without a mean"), (["1,,1,1,5,5"] * 2, "row 2 has the estimate of an earlier row"),
    ],
    ids=str,
)  # fmt: skip
def test_estimates_that_cannot_be_are_refused(tmp_path: Path, rows, fault):
    path = tmp_path / "metrics.csv"
    path.write_text(ESTIMATES + "".join(f"e,A,m,total_steps,{row}\n" for row in rows))
    assert fault in refusal(str(path))


def test_names_are_printed_without_control_characters(tmp_path: Path):
    path = tmp_path / "metrics.csv"
    path.write_text(ESTIMATES + "e\x1b[2J,A\x07,m\x1b[31m,total_steps,1,,1,1,5,5\n")
    text = "\n".join(printed(str(path)))
    assert text.startswith(r"e\x1b[2J, task A\x07") and r"m\x1b[31m" in text


def test_without_any_run_the_folder_is_named(tmp_path: Path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert refusal() == "reports/*/tables/metrics.csv: 0 runs; name one of none"
