"""Tables 1 to 6: the values in their cells, the best ones, and their notes."""

from __future__ import annotations

import re
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ptl.errors import UserError
from ptl.measures.measures import MEASURES
from ptl.measures.statistics import Resampling, summarise
from ptl.report.metric_tables import COLUMNS, MetricColumn, best_methods, build_tables, write_tables
from ptl.report.table import Cell, Table, to_html, to_latex, to_markdown
from ptl.report.table_kinds import KINDS, table_labels
from ptl.text import number

METHODS = {
    "no_transfer": ("No transfer", "#666666"),
    "ptl": ("PTL & co_1", "#0072b2"),
    "full_transfer": ("<Other>", "red"),
}
FIRST_EPISODES = {"no_transfer": 1000, "ptl": 100, "full_transfer": 4000}
ROWS = ["No transfer", "PTL & co_1", "<Other>"]
FEWER = MetricColumn("total_steps", "Total", "steps", "lower")
MORE = MetricColumn("transfer_ratio", "Ratio", "", "higher")
EPISODES = MetricColumn("threshold_episode", "Time", "episodes", "lower", with_share=True)


def per_seed() -> pd.DataFrame:
    rows = []
    for environment in ("env1", "env2"):
        for task in "AB":
            for method, size in FIRST_EPISODES.items():
                for seed in range(5):
                    base, own = 1000 + 100 * seed, size + 100 * seed
                    missed = method == "full_transfer" or (method == "no_transfer" and seed > 0)
                    rows.append(
                        {
                            "environment": environment,
                            "task": task,
                            "method": method,
                            "seed": seed,
                            "first_episode": own,
                            "asymptotic": own / 10,
                            "threshold_episode": np.nan if missed else 12 + 2 * seed,
                            "total_steps": 10 * own,
                            "jump_start": base - own,
                            "transfer_ratio": (base - own) / base,
                            "truncated": int(method == "full_transfer" and seed == 1),
                        }
                    )
    return pd.DataFrame(rows)


def lay_out(per_seed: pd.DataFrame, titles: dict[str, str]) -> list[tuple[Table, pd.DataFrame]]:
    measures = SimpleNamespace(window=10, threshold_factor=1.5)
    statistics = SimpleNamespace(confidence=0.95, resamples=100)
    return build_tables(summarise(per_seed, Resampling(0.95, 100)), measures, statistics, METHODS, titles)


@pytest.fixture(scope="module")
def built() -> list[tuple[Table, pd.DataFrame]]:
    return lay_out(per_seed(), {"env2": "a corridor", "env1": "Rooms | halls"})


def cell(table: Table, task: str, method: str, heading: str, unit: str) -> Cell:
    [group] = [group for group in table.groups if group.name == task]
    [row] = [row for row in group.rows if row.label == METHODS[method][0]]
    [index] = [i for i, column in enumerate(table.columns) if (column.heading, column.unit) == (heading, unit)]
    return row.cells[index]


def values(**means: float | tuple[float, float]) -> dict[str, dict[str, float]]:
    """Rows of one metric by method: a mean, or a mean and the share of seeds that reached the threshold."""
    pairs = {name: mean if isinstance(mean, tuple) else (mean, np.nan) for name, mean in means.items()}
    ends = {"ci_low": np.nan, "ci_high": np.nan}
    return {name: {"mean": mean, "reached": reached, **ends} for name, (mean, reached) in pairs.items()}


# -- best values ---------------------------------------------------------------------------------------------


def test_the_best_value_is_that_of_the_direction():
    assert best_methods(FEWER, values(a=300.0, b=200.0, c=900.0)) == {"b"}
    assert best_methods(MORE, values(a=0.3, b=-0.2, c=0.9)) == {"c"}


def test_all_that_read_the_same_are_best_but_never_everyone():
    assert best_methods(MORE, values(a=0.9001, b=0.9004, c=0.2)) == {"a", "b"}
    assert best_methods(MORE, values(a=0.9001, b=0.9004)) == set()


def test_numbers_that_read_the_same_at_the_precision_of_their_intervals_are_both_best():
    rows = values(a=106.0, b=112.0, c=180.0)
    for row in rows.values():
        row |= {"ci_low": row["mean"] - 300, "ci_high": row["mean"] + 300}
    assert best_methods(FEWER, rows) == {"a", "b"}


def test_missing_values_do_not_compete():
    assert best_methods(FEWER, values(a=np.nan, b=200.0, c=900.0)) == {"b"}
    assert best_methods(FEWER, values(a=np.nan, b=np.nan)) == set()


def test_a_few_lucky_seeds_do_not_win_the_time_to_threshold():
    rows = values(lucky=(20.0, 0.1), steady=(60.0, 1.0), slow=(90.0, 1.0), never=(np.nan, 0.0))
    assert best_methods(EPISODES, rows) == {"steady"}


@given(st.lists(st.floats(-1e7, 1e7), min_size=2, max_size=5))
def test_no_value_reads_better_than_a_best_one(means: list[float]):
    def read(value: float) -> float:
        return float(number(value).replace(",", "").replace("−", "-"))

    rows = values(**{str(index): mean for index, mean in enumerate(means)})
    for index in best_methods(FEWER, rows):
        assert read(means[int(index)]) == min(map(read, means))


# -- the model -----------------------------------------------------------------------------------------------


def test_two_tables_for_each_environment_in_the_given_order(built):
    assert [table.name for table, _ in built] == ["table1", "table2", "table3", "table4"]
    assert [table.title.split(", ")[-1] for table, _ in built] == ["a corridor"] * 2 + ["Rooms | halls"] * 2


def test_labels_of_the_report_are_the_titles_of_the_tables(built):
    labels = table_labels({"env2": {"title": "a corridor"}, "env1": {"title": "Rooms | halls"}})
    assert labels == {table.name: table.full_title for table, _ in built}


def test_every_measure_of_a_table_has_its_column(built):
    for (table, numbers), kind in zip(built, [*KINDS, *KINDS], strict=True):
        own = [measure for measure in MEASURES if measure.table == kind]
        assert [column.metric for column in COLUMNS[kind]] == [measure.name for measure in own]
        assert {(m.heading, m.unit) for m in own} <= {(column.heading, column.unit) for column in table.columns}
        assert {f"{measure.name}_mean" for measure in own} <= set(numbers.columns)
        assert all(len(row.cells) == len(table.columns) for group in table.groups for row in group.rows)


def test_a_comparison_shows_its_improvement_once():
    shown = {kind: [column.metric for column in COLUMNS[kind] if column.with_improvement] for kind in KINDS}
    assert shown == {"transfer": ["jump_start", "asymptotic", "threshold_episode"], "total": ["total_steps"]}


def test_cells_show_mean_deviation_interval_and_improvement(built):
    table, _ = built[1]
    total = cell(table, "B", "ptl", "Total performance", "steps")
    assert total.text == "3,000 ± 1,600"  # deviation of 1000, 2000, 3000, 4000, 5000; the interval is thousands wide
    assert re.fullmatch(r"\[[\d,]+, [\d,]+\]", total.detail) and total.best
    assert cell(table, "B", "ptl", "Total performance", "P").text == "1"


def test_nothing_is_best_in_the_first_task_and_something_in_the_next(built):
    for table, _ in built:
        first, second = table.groups
        assert not any(cell.best for row in first.rows for cell in row.cells)
        assert any(cell.best for row in second.rows for cell in row.cells)


def test_a_threshold_that_no_seed_reached_has_no_number(built):
    table, _ = built[0]
    never = cell(table, "B", "full_transfer", "Time to threshold", "episodes")
    assert (never.text, never.detail, never.best) == ("not reached", "", False)
    assert cell(table, "B", "full_transfer", "Time to threshold", "reached").text == "0 of 5"
    once = cell(table, "B", "no_transfer", "Time to threshold", "episodes")
    assert (once.text, once.best) == ("12", False)
    assert cell(table, "B", "no_transfer", "Time to threshold", "reached").text == "1 of 5"
    assert cell(table, "B", "ptl", "Time to threshold", "episodes").best


def test_the_base_is_zero_by_definition(built):
    ratio = cell(built[1][0], "B", "no_transfer", "Transfer ratio", "mean of per-seed ratios")
    assert (ratio.text, ratio.detail) == ("0", "")
    assert cell(built[1][0], "B", "no_transfer", "Total performance", "P").text == "–"


def test_both_transfer_ratios_are_told_apart(built):
    units = ("mean of per-seed ratios", "ratio of the means")
    texts = [cell(built[1][0], "B", "full_transfer", "Transfer ratio", unit).text for unit in units]
    assert texts[0].split(" ± ")[0] != texts[1] == "−2.5"  # (1200 - 4200) / 1200


def test_notes_name_runs_interval_and_truncations(built):
    table, _ = built[0]
    notes = " ".join(table.all_notes)
    assert "over 5 seeds" in notes and "95% bootstrap" in notes and "1.5 times the shortest path" in notes
    assert "task B, <Other>: 1" in notes


def test_the_first_task_is_said_to_be_a_negative_control():
    frame = per_seed()
    arguments = SimpleNamespace(window=10, threshold_factor=1.5), SimpleNamespace(confidence=0.95, resamples=100)
    metrics = summarise(frame, Resampling(0.95, 100))
    own = metrics[(metrics["environment"] == "env1") & (metrics["task"] == "A") & (metrics["metric"] == "jump_start")]
    own = own[own["method"] != "no_transfer"].dropna(subset="ci_low")
    missed = int(((own["ci_low"] > 0) | (own["ci_high"] < 0)).sum())
    (table, _), (other, _) = build_tables(metrics, *arguments, METHODS, {"env1": "Rooms"}, reproduction=True)
    [note] = [note for note in table.notes if "negative control" in note]
    assert f"{missed} of the {len(own)} intervals of its jump starts exclude 0" in note and "5% would" in note
    assert not any("negative control" in note for note in other.notes)


def test_a_run_without_the_base_says_so():
    frame = per_seed()
    frame = frame[frame["method"] != "no_transfer"].assign(jump_start=np.nan, transfer_ratio=np.nan)
    (table, _), *_ = lay_out(frame, {"env1": "Rooms"})
    assert any("no_transfer is not in this run" in note for note in table.notes)
    assert cell(table, "B", "ptl", "Jump start", "steps").text == "–"


def test_unknown_environment_is_refused():
    with pytest.raises(UserError, match="env9"):
        lay_out(per_seed(), {"env9": ""})


# -- the files -----------------------------------------------------------------------------------------------


def test_each_format_has_every_method_and_every_best_value(built):
    for table, _ in built:
        best = [cell.text for group in table.groups for row in group.rows for cell in row.cells if cell.best]
        page = to_html(table)
        assert re.findall(r"<b>(.*?)</b>", page) == best
        assert page.count("&lt;Other&gt;</th>") == 2 and page.count('class="dot"') == 2 * len(ROWS)
        assert not re.search(r"<(script|link|img)|https?:|url\(", page)
        assert len(re.findall(r"\| \*\*(?=\d|−)", to_markdown(table))) == len(best)
        assert to_latex(table).count(r"\boldmath") == len(best)


def test_numbers_of_a_table_are_those_of_the_metrics(built):
    _, frame = built[0]
    assert len(frame) == 6
    row = frame[(frame["task"] == "B") & (frame["method"] == "ptl")].iloc[0]
    assert row["jump_start_mean"] == 900
    assert (row["threshold_episode_mean"], row["threshold_episode_reached"]) == (16, 1)
    assert row["threshold_episode_best"]


def test_every_table_is_written_in_every_format(built, tmp_path):
    write_tables(built, tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {
        f"table{index}.{suffix}" for index in range(1, 5) for suffix in ("html", "md", "tex", "csv")
    }
