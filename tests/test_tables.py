"""Tables: what is written in a cell, what goes in bold, and that each format is well-formed."""

from __future__ import annotations

import re
from html.parser import HTMLParser

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st

from ptl import tables
from ptl.commands.tables import command
from ptl.errors import UserError
from ptl.statistics import Resampling, summarise

SETTINGS = tables.Settings(window=10, threshold_factor=1.5, confidence=0.95, resamples=100)
LABELS = {
    "no_transfer": ("No transfer", "#666666"),
    "ptl": ("PTL & co_1", "#0072b2"),
    "other": ("<Other>", "red"),
}
THRESHOLD = tables.TRANSFER_COLUMNS[3]
TOTAL = tables.TOTAL_COLUMNS[0]
RATIO = tables.TOTAL_COLUMNS[1]


def per_seed():
    first = {"no_transfer": 1000, "ptl": 100, "other": 4000}
    rows = []
    for environment in ("env1", "env2"):
        for task in "AB":
            for method, size in first.items():
                for seed in range(4):
                    base = 1000 + 100 * seed
                    own = size + 100 * seed
                    missed = method == "other" or (method == "no_transfer" and seed > 0)
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
                            "truncated": int(method == "other" and seed == 1),
                        }
                    )
    return pd.DataFrame(rows)


@pytest.fixture(scope="module")
def built():
    metrics = summarise(per_seed(), Resampling(0.95, 100))
    return tables.build_tables(metrics, SETTINGS, LABELS, {"env2": "a corridor", "env1": ""})


def cell(table, task, method, key):
    group = next(group for group in table.groups if group.task == task)
    row = next(row for row in group.rows if row.method == method)
    return row.cells[[column.key for column in table.columns].index(key)]


def values(**means):
    """Rows of one metric by method: a mean, or a mean and the share of seeds that reached the threshold."""
    pairs = {name: mean if isinstance(mean, tuple) else (mean, np.nan) for name, mean in means.items()}
    return {name: pd.Series({"mean": mean, "reached": reached}) for name, (mean, reached) in pairs.items()}


# -- numbers -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("value", "text"),
    [(35412.6, "35,400"), (2632000, "2,630,000"), (8.4, "8"), (96.5, "96"), (0, "0"), (-606123, "−606,000"),
     (-0.2, "0"), (999.6, "1,000")],
)  # fmt: skip
def test_counts(value, text):
    assert tables.count_text(value) == text


@pytest.mark.parametrize(("value", "text"), [(0.8871, "0.887"), (-0.48, "−0.480"), (-0.0001, "0.000")])
def test_decimals(value, text):
    assert tables.decimal_text(3)(value) == text


@given(st.floats(-1e7, 1e7), st.floats(-1e7, 1e7))
def test_rounding_keeps_the_order(a, b):
    def number(text):
        return float(text.replace(",", "").replace("−", "-"))

    low, high = sorted((a, b))
    assert number(tables.count_text(low)) <= number(tables.count_text(high))


# -- bold ----------------------------------------------------------------------------------------------------


def test_bold_goes_to_the_best_of_the_direction():
    assert tables.best_methods(TOTAL, values(a=300.0, b=200.0, c=900.0)) == {"b"}
    assert tables.best_methods(RATIO, values(a=0.3, b=-0.2, c=0.9)) == {"c"}


def test_bold_goes_to_all_that_read_the_same_but_not_to_everyone():
    assert tables.best_methods(RATIO, values(a=0.9001, b=0.9004, c=0.2)) == {"a", "b"}
    assert tables.best_methods(RATIO, values(a=0.9001, b=0.9004)) == set()


def test_bold_passes_over_missing_values():
    assert tables.best_methods(TOTAL, values(a=np.nan, b=200.0, c=900.0)) == {"b"}
    assert tables.best_methods(TOTAL, values(a=np.nan, b=np.nan)) == set()


def test_a_few_lucky_seeds_do_not_win_the_time_to_threshold():
    rows = values(lucky=(20.0, 0.1), steady=(60.0, 1.0), slow=(90.0, 1.0), never=(np.nan, 0.0))
    assert tables.best_methods(THRESHOLD, rows) == {"steady"}


# -- the model -----------------------------------------------------------------------------------------------


def test_two_tables_for_each_environment_in_the_given_order(built):
    assert [table.name for table in built] == ["table1", "table2", "table3", "table4"]
    assert [table.title.split(", ")[-1] for table in built] == ["a corridor"] * 2 + ["env1"] * 2
    assert [len(table.columns) for table in built] == [4, 3, 4, 3]


def test_cells_show_mean_deviation_interval_and_improvement(built):
    total = cell(built[1], "B", "ptl", "total_steps")
    assert total.text == f"2,500 ± {np.std([1000, 2000, 3000, 4000], ddof=1):,.0f}".replace("1,291", "1,290")
    assert re.fullmatch(r"[\d,]+ to [\d,]+", total.interval)
    assert total.improvement == "1.00"
    assert total.best


def test_nothing_is_bold_in_the_first_task_and_something_in_the_next(built):
    for table in built:
        first, second = table.groups
        assert not any(cell.best for row in first.rows for cell in row.cells)
        assert all(any(row.cells[i].best for row in second.rows) for i in range(len(table.columns)))


def test_not_reached_is_written_and_the_share_stands_beside(built):
    never = cell(built[0], "B", "other", "threshold_episode")
    assert (never.text, never.interval, never.share, never.best) == ("not reached", "", "0 of 4", False)
    once = cell(built[0], "B", "no_transfer", "threshold_episode")
    assert (once.text, once.share) == ("12.0", "1 of 4")
    assert not once.best
    always = cell(built[0], "B", "ptl", "threshold_episode")
    assert always.share == "4 of 4"
    assert always.best


def test_base_has_a_plain_zero(built):
    base = cell(built[1], "B", "no_transfer", "transfer_ratio")
    assert (base.text, base.interval, base.improvement) == ("0.000", "", "–")


def test_notes_name_runs_interval_truncations_and_source(built):
    notes = " ".join(built[0].notes)
    assert "4 runs" in notes
    assert "95% bootstrap" in notes
    assert "1.5 times the shortest path" in notes
    assert "task B, <Other>: 1" in notes
    assert "metrics.csv, environment env2" in notes


def test_both_transfer_ratios_are_told_apart(built):
    units = [column.unit for column in built[1].columns]
    assert units[1:] == ["mean of per-seed ratios", "ratio of the means"]
    texts = [cell(built[1], "B", "other", key).text for key in ("transfer_ratio", "transfer_ratio_of_means")]
    assert texts[0].split(" ± ")[0] != texts[1]
    assert texts[1] == "−2.609"  # (1150 - 4150) / 1150


def test_unknown_environment_is_refused():
    metrics = summarise(per_seed(), Resampling(0.95, 10))
    with pytest.raises(UserError, match="env9"):
        tables.build_tables(metrics, SETTINGS, LABELS, {"env9": ""})


# -- the formats ---------------------------------------------------------------------------------------------


class Page(HTMLParser):
    """Collects rows of cells and fails on tags that are not closed in order."""

    VOID = frozenset({"meta", "br"})

    def __init__(self):
        super().__init__()
        self.open, self.rows, self.bold, self.text = [], [], [], []

    def handle_starttag(self, tag, attributes):
        if tag in self.VOID:
            return
        self.open.append(tag)
        if tag == "tr":
            self.rows.append(0)
        if tag in ("td", "th"):
            self.rows[-1] += int(dict(attributes).get("colspan", 1))

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text.append(data)
        if self.open and self.open[-1] == "b":
            self.bold.append(data)


def test_html_is_well_formed_and_stands_alone(built):
    for table in built:
        source = tables.to_html(table)
        page = Page()
        page.feed(source)
        page.close()
        assert page.open == []
        width = 1 + sum(column.width for column in table.columns)
        # the second line of the head is one cell short: "Method" spans both
        assert page.rows == [width, width - 1] + 2 * ([width] + [width] * 3)
        assert page.bold == [c.text for g in table.groups for r in g.rows for c in r.cells if c.best]
        assert not re.search(r"<(script|link|img)|https?:|url\(", source)
        assert "<Other>" in "".join(page.text)
        assert "prefers-color-scheme: dark" in source
        assert 'name="viewport"' in source


def test_markdown_rows_have_equally_many_cells(built):
    source = tables.to_markdown(built[0])
    rows = [line for line in source.splitlines() if line.startswith("|")]
    assert len(rows) == 2 + 2 * 3
    assert {len(re.findall(r"(?<!\\)\|", row)) for row in rows} == {1 + 2 + 8}
    assert "PTL & co\\_1" in source
    best = cell(built[0], "B", "ptl", "asymptotic")
    assert f"**{best.text}**<br>{best.interval}" in source


SPECIAL = r"\&%$#_{}~^"


def unescape(source):
    known = {code: character for character, code in tables.LATEX_CHARACTERS.items()}
    pattern = "|".join(re.escape(code) for code in sorted(known, key=len, reverse=True))
    return re.sub(pattern, lambda found: known[found.group()], source)


@given(st.text(alphabet=SPECIAL + "aZ 3±−"))
def test_latex_escaping_prints_every_character_as_itself(text):
    escaped = tables.escape_latex(text)
    assert unescape(escaped) == text
    bare = re.sub(r"\\text(backslash|asciitilde|asciicircum)\{\}|\\[&%$#_{}]|\$(\\pm|-)\$", "", escaped)
    assert not set(bare) & set(SPECIAL)
    assert escaped.isascii()


def test_latex_is_balanced(built):
    for table in built:
        source = tables.to_latex(table)
        assert source.isascii()
        plain = re.sub(r"\\[&%$#_{}]", "", source)
        assert plain.count("{") == plain.count("}")
        assert plain.count("$") % 2 == 0
        assert re.findall(r"\\begin\{(\w+)\}", plain) == re.findall(r"\\end\{(\w+)\}", plain) == ["longtable"]
        assert source.count(r"\begingroup") == source.count(r"\endgroup") == 1
        width = 1 + sum(column.width for column in table.columns)
        rows = [line for line in plain.splitlines() if re.search(r"\\\\\*?$", line) and "caption" not in line]
        assert len(rows) == 4 + 2 * (1 + 2 * 3)
        for row in rows:
            spans = [int(number) for number in re.findall(r"\\multicolumn\{(\d+)\}", row)]
            assert row.count("&") + 1 + sum(spans) - len(spans) == width
        assert r"PTL \& co\_1" in source
        best = next(c for r in table.groups[1].rows for c in r.cells if c.best)
        assert rf"\textbf{{{tables.escape_latex(best.text)}}}" in source


def test_numbers_of_a_table_are_those_of_the_metrics(built):
    frame = tables.to_frame(built[0])
    assert len(frame) == 6
    row = frame[(frame["task"] == "B") & (frame["method"] == "ptl")].iloc[0]
    assert row["jump_start_mean"] == 900
    assert row["threshold_episode_mean"] == 15
    assert row["threshold_episode_reached"] == 1
    assert row["threshold_episode_best"]


def test_command_writes_metrics_and_every_format(tmp_path):
    frame = per_seed()
    frame[frame["method"] != "other"].to_csv(tmp_path / "per_seed.csv", index=False)
    result = CliRunner().invoke(
        command,
        [str(tmp_path / "per_seed.csv"), "--output-metrics", str(tmp_path / "metrics.csv"), "--output-folder",
         str(tmp_path / "tables"), "--environment", "env1=seven = many rooms", "--environment", "env2",
         "--window", "10", "--threshold-factor", "1.5", "--confidence", "0.9", "--resamples", "50"],
        catch_exceptions=False,
    )  # fmt: skip
    assert result.exit_code == 0, result.output
    written = {path.name for path in (tmp_path / "tables").iterdir()}
    assert written == {f"table{n}.{suffix}" for n in range(1, 5) for suffix in ("html", "md", "tex", "csv")}
    page = (tmp_path / "tables" / "table1.html").read_text(encoding="utf-8")
    assert "time to threshold, seven = many rooms" in page
    assert "90% bootstrap" in page
    metrics = pd.read_csv(tmp_path / "metrics.csv")
    assert set(metrics["method"]) == {"no_transfer", "ptl"}
    assert metrics["mean"].notna().sum() > 50
