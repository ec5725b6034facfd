"""A plain table of texts with a title and notes, as Markdown or as an HTML page of its own."""

from __future__ import annotations

import html
from collections.abc import Sequence
from dataclasses import dataclass

from ptl.tables import STYLE

EXTRA_STYLE = """
thead tr:only-child th { text-align: right; color: var(--soft); border-bottom: 1px solid var(--strong);
  font-size: .9em; }
td.text, thead tr:only-child th.text { text-align: left; }
td.text { white-space: normal; min-width: 16ch; }
""".strip()


@dataclass(frozen=True)
class Page:
    """A table ready to be written.

    Attributes
    ----------
    title, intro : str
    columns : sequence of str
        Headings; the first column names the row.
    rows : sequence of sequences of str
    notes : sequence of str
    text_columns : set of int
        Columns (counted from 0) of words rather than numbers; the first always is one.
    """

    title: str
    intro: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    notes: Sequence[str] = ()
    text_columns: frozenset[int] = frozenset()

    def to_markdown(self) -> str:
        """A pipe table with the notes below."""
        rule = ["---" if self._is_text(index) else "---:" for index in range(len(self.columns))]
        lines = [f"**{_escape(self.title)}**", "", _escape(self.intro), ""]
        lines += [_pipe([_escape(heading) for heading in self.columns]), _pipe(rule)]
        lines += [_pipe([_escape(text) for text in row]) for row in self.rows]
        lines += ["", *(f"{_escape(note)}\n" for note in self.notes)]
        return "\n".join(lines).rstrip("\n") + "\n"

    def to_html(self) -> str:
        """A page without scripts or other files; light and dark, and a wide table scrolls."""
        heads = "".join(
            f'<th scope="col"{self._kind(index)}>{html.escape(heading)}</th>'
            for index, heading in enumerate(self.columns)
        )
        body = []
        for row in self.rows:
            cells = "".join(f"<td{self._kind(i)}>{html.escape(text)}</td>" for i, text in enumerate(row) if i)
            body.append(f'<tr><th scope="row">{html.escape(row[0])}</th>{cells}</tr>')
        title = html.escape(self.title)
        notes = "".join(f"<li>{html.escape(note)}</li>" for note in self.notes)
        return "\n".join(
            [
                "<!DOCTYPE html>",
                '<html lang="en">',
                "<head>",
                '<meta charset="utf-8">',
                '<meta name="viewport" content="width=device-width, initial-scale=1">',
                f"<title>{title}</title>",
                f"<style>\n{STYLE}\n{EXTRA_STYLE}\n</style>",
                "</head>",
                "<body>",
                "<figure>",
                f'<figcaption id="caption"><h1>{title}</h1>{html.escape(self.intro)}</figcaption>',
                '<div class="scroll" tabindex="0" role="region" aria-labelledby="caption">',
                '<table aria-labelledby="caption">',
                f"<thead><tr>{heads}</tr></thead>",
                "<tbody>",
                *body,
                "</tbody>",
                "</table>",
                "</div>",
                f'<ul class="notes">{notes}</ul>',
                "</figure>",
                "</body>",
                "</html>",
                "",
            ]
        )

    def _is_text(self, index: int) -> bool:
        return index == 0 or index in self.text_columns

    def _kind(self, index: int) -> str:
        return ' class="text"' if self._is_text(index) else ""


def _pipe(texts: Sequence[str]) -> str:
    return "| " + " | ".join(texts) + " |"


def _escape(text: str) -> str:
    for character in "\\|*_<>":
        text = text.replace(character, f"\\{character}")
    return text
