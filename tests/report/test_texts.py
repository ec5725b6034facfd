"""Titles and labels are texts in every format: never markup, mathematics or format strings."""

from __future__ import annotations

import re

import docutils.core
import docutils.nodes
import pytest
from hostile_texts import TITLES
from markdown_it import MarkdownIt
from projects import MAPS

from ptl.files.configuration import completed
from ptl.keys import ConfigurationError
from ptl.report.figures import maps, saving
from ptl.report.table import text_table, to_markdown
from ptl.report.templating import escape_rst, render
from ptl.world.gridworld import GridWorld


@pytest.mark.parametrize("text", TITLES)
def test_in_restructured_text(text):
    source = f"* {escape_rst(text)}\n\n{escape_rst(text)}\n\n* x {escape_rst(text)} x\n"
    document = docutils.core.publish_doctree(source, settings_overrides={"report_level": 1, "halt_level": 2})
    paragraphs = list(document.findall(docutils.nodes.paragraph))
    assert [paragraph.astext() for paragraph in paragraphs] == [text, text, f"x {text} x"]
    assert all(isinstance(node, docutils.nodes.Text) for paragraph in paragraphs for node in paragraph.children)


@pytest.mark.parametrize("text", TITLES)
def test_in_markdown(text):
    source = to_markdown(text_table(text, text, ["x", text], [[text, "1"]]))
    tokens = MarkdownIt("commonmark").enable("table").parse(source)
    inline = [token for token in tokens if token.type == "inline"]
    assert [token.content.count("|") > 5 for token in inline] == [False] * len(inline), "a row that is no table"
    shown = ["".join(child.content for child in token.children) for token in inline]
    assert shown == [shown[0], text, "x", text, text, "1"] and text in shown[0]
    kinds = {child.type for token in inline[1:] for child in token.children}
    assert kinds <= {"text", "text_special"}
    assert not re.search(r"(?<!\\)://|www\.", source), "GitHub makes links of these"


@pytest.mark.filterwarnings("ignore:Glyph .* missing from font")
@pytest.mark.parametrize("text", TITLES)
def test_in_figures(text, tmp_path):
    world = GridWorld.from_text("I.\n.A\n")
    figure = maps.draw(world, text)
    saving.save(figure, maps.places(world), tmp_path / "map.png")
    [axes] = figure.axes
    assert axes.title.get_text() + axes._left_title.get_text() == f"{text}: 4 states"
    assert not axes._left_title.get_parse_math()


@pytest.mark.parametrize("text", TITLES)
def test_in_latex(text):
    source = render("table.tex", table=text_table(text, "x", ["y"], [[text]]))
    assert "\\input{" not in source and not re.search(r"(?<!\\)\$x|100%", source)


HIDDEN = ["a\x85b", "a\u2028b", "a\x9b31mb", "\ud800", "a\u202eb", "a\ufffe", "_hidden"]


@pytest.mark.parametrize("text", [*HIDDEN, *[text for text in TITLES if set(text) & set("<{")]])
def test_texts_that_cannot_be_shown_are_refused(text):
    environment = {"map": str(MAPS / "env1.txt"), "title": text}
    with pytest.raises(ConfigurationError, match=r"environments\.env1\.title") as refused:
        completed({"run": "x", "seeds": 1, "environments": {"env1": environment}, "methods": ["ptl"]})
    assert str(refused.value).isprintable()
