"""The table model and its formats: structure, and that every text is text."""

from __future__ import annotations

import html
import re
from html.parser import HTMLParser

import pandas as pd
import pytest

from ptl.report.table import Cell, Column, Row, RowGroup, Table, text_table, to_html, to_latex, to_markdown, write

HOSTILE = "<script>alert(1)</script> | *a* $b_c$ \\d & {e} [f](g) `h` ${i} %j #k ~l ^m"


def two_level_table(title: str = "Measures") -> Table:
    columns = [Column("Steps", "mean"), Column("Steps", "P"), Column("Ratio", "mean")]
    rows = [
        Row("PTL", [Cell("1,234 ± 5", "[1,200, 1,300]", best=True), Cell("0.9"), Cell("−0.5")], "#0072b2"),
        Row("Base", [Cell("2,000"), Cell("–", aside=True), Cell("0")]),
    ]
    return Table(
        title, "Introduction.", "Method", columns, [RowGroup(rows, "Task A: first", "A")], ["Note."], 3, "Task"
    )


def hostile_table() -> Table:
    columns = [Column(HOSTILE, HOSTILE), Column("other", "unit")]
    row = Row(HOSTILE, [Cell(HOSTILE, HOSTILE, best=True), Cell("1")])
    return Table(HOSTILE, HOSTILE, HOSTILE, columns, [RowGroup([row], HOSTILE, HOSTILE)], [HOSTILE], 1, HOSTILE)


class Reader(HTMLParser):
    """Collects the tags and the text of the cells of a page."""

    def __init__(self) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.rows: list[list[str]] = []

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        if tag == "tr":
            self.rows.append([])
        elif tag in ("td", "th"):
            self.rows[-1].append("")

    def handle_data(self, data):
        if self.rows and self.rows[-1]:
            self.rows[-1][-1] += data


def read(page: str) -> Reader:
    reader = Reader()
    reader.feed(page)
    return reader


def test_html_has_two_rows_of_headings_and_one_row_a_method():
    page = to_html(two_level_table())
    rows = [[cell.strip() for cell in row] for row in read(page).rows]
    assert rows[:3] == [["Method", "Steps", "Ratio"], ["mean", "P", "mean"], ["Task A: first"]]
    assert rows[3] == ["PTL", "1,234 ± 5[1,200, 1,300]", "0.9", "−0.5"]
    assert '<th scope="colgroup" colspan="2">Steps</th>' in page and "<h1>Table 3. Measures</h1>" in page


def test_markdown_is_a_pipe_table_with_equally_many_cells_in_every_line():
    lines = [line for line in to_markdown(two_level_table()).splitlines() if line.startswith("|")]
    assert lines[0] == "| Task | Method | Steps (mean) | Steps (P) | Ratio (mean) |"
    assert lines[2] == "| **A** | PTL | **1,234 ± 5**<br>\\[1,200, 1,300\\] | 0.9 | −0.5 |"
    assert {len(re.findall(r"(?<!\\)\|", line)) for line in lines} == {6}


def test_latex_has_as_many_columns_as_it_declares():
    source = to_latex(two_level_table())
    assert r"\begin{longtable}{@{}lrrr@{}}" in source and r"\cmidrule(lr){2-3}\cmidrule(lr){4-4}" in source
    body = [
        line for line in source.splitlines() if line.rstrip().endswith((r"\\", r"\\*")) and "multicolumn" not in line
    ]
    assert body and {line.count("&") for line in body if "caption" not in line} == {3}


@pytest.mark.parametrize(
    "table", [hostile_table(), text_table(HOSTILE, HOSTILE, [HOSTILE] * 2, [[HOSTILE] * 2], [HOSTILE])]
)
def test_text_never_becomes_markup(table: Table):
    page = to_html(table)
    assert "script" not in read(page).tags and html.escape("<script>") in page
    unescaped = re.sub(r"\\.", "", to_markdown(table)).replace("**", "").replace("<br>", "")
    assert not set("<>*_`$[]&") & set(unescaped)
    widths = [len(re.findall(r"(?<!\\)\|", line)) for line in to_markdown(table).splitlines() if line.startswith("|")]
    assert len(set(widths)) == 1


def test_latex_prints_every_character_as_itself():
    source = to_latex(hostile_table())
    assert r"\textless" in source or "$<$script$>$" in source
    assert r"\textbackslash{}d" in source and r"\_c" in source and r"\$b" in source and r"\%j" in source


def test_writing_makes_a_file_for_each_format(tmp_path):
    write(two_level_table(), tmp_path / "table3", pd.DataFrame({"x": [1.5]}), (".html", ".md", ".tex"))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["table3.csv", "table3.html", "table3.md", "table3.tex"]
    assert (tmp_path / "table3.csv").read_text() == "x\n1.5\n"


def test_lines_of_a_cell_are_lines_in_every_format():
    table = text_table("Title", "Intro.", ["claim", "numbers"], [["a", "one\n* two"]], text_columns=["numbers"])
    assert '<td class="text">one\n* two</td>' in to_html(table)
    assert "| a | one<br>\\* two |" in to_markdown(table)
    assert "{a} & one * two \\\\\n" in to_latex(table)


@pytest.mark.parametrize("text", ["- item", "+ item", "1. item", "1) item", "# title", "===", "---", "~~~"])
def test_a_line_of_markdown_begins_as_text(text: str):
    _, _, line, *_ = to_markdown(text_table("Title", text, ["x"], [])).splitlines()
    assert "\\" in line and line.replace("\\", "") == text


def test_numbers_are_not_escaped_in_markdown():
    table = text_table("Title", "Intro.", ["x", "y"], [["0.5", "1.25"]])
    assert "| 0.5 | 1.25 |" in to_markdown(table)


def test_a_label_is_no_argument_of_the_line_end_in_latex():
    source = to_latex(text_table("Title", "Intro.", ["x", "y"], [["[1]", "a"], ["*", "b"]]))
    assert not re.search(r"\\\\\*?\s*[\[*]", source)
    assert "multicolumn" not in source and r"\label" not in source
