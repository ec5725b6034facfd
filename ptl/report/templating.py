"""Templates of the report: text is escaped for the format that a template is written in."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import jinja2
from markupsafe import Markup

from ptl.text import MINUS, MISSING

LATEX = {
    "\\": r"\textbackslash{}", "&": r"\&", "%": r"\%", "$": r"\$", "#": r"\#", "_": r"\_", "{": r"\{", "}": r"\}",
    "~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "±": r"$\pm$", MINUS: r"$-$", MISSING: "--",
    "×": r"$\times$", "“": "``", "”": "''", "<": r"$<$", ">": r"$>$", "|": r"$|$", "`": r"\textasciigrave{}",
    "∞": r"$\infty$",
}  # fmt: skip
"""Characters that LaTeX would not print as themselves."""


def escape_latex(text: str) -> str:
    """Escape text for LaTeX."""
    return "".join(LATEX.get(character, character) for character in " ".join(text.split()))


def escape_markdown(text: str) -> str:
    """Escape text for a line of Markdown or a cell of a pipe table."""
    escaped = re.sub(r"([\\|*_<>\[\]`$&#~@])", r"\\\1", " ".join(text.split()))
    escaped = re.sub(r"://|(?<=www)\.", r"\\\g<0>", escaped, flags=re.IGNORECASE)  # no link by itself
    return re.sub(r"^(\d*)([-+=.)])(?=[-=\s]|$)", r"\1\\\2", escaped)  # neither a list nor the underline of a title


def escape_rst(text: str) -> str:
    """Escape text for reStructuredText, where it may begin a block."""
    words = " ".join(text.split())
    escaped = re.sub(r"([\\*`|_<>:@])", r"\\\1", words)
    # an escaped space is nothing, and before it a list, a directive or the line of a title does not begin one
    return f"\\ {escaped}" if re.match(r"[!-/:-@\[-`{-~•‣⁃]|\w+[.)](\s|$)", words) else escaped


def _environment(**options: Any) -> jinja2.Environment:
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("ptl.report"),
        autoescape=lambda name: name is not None and name.endswith(".html"),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        **options,
    )
    environment.filters |= {"tex": escape_latex, "md": escape_markdown, "rst": escape_rst, "zip": zip}
    return environment


_PLAIN = _environment()
_LATEX = _environment(
    block_start_string="((*",
    block_end_string="*))",
    variable_start_string="(((",
    variable_end_string=")))",
    comment_start_string="((=",
    comment_end_string="=))",
)  # braces belong to LaTeX


def render(template: str, folder: Path | None = None, **values: Any) -> str:
    """Fill a file of ``ptl/report/templates``; values in HTML are escaped, other formats use filters.

    Parameters
    ----------
    folder : path, optional
        Further templates, which may use those of the report.
    """
    environment = _LATEX if template.endswith(".tex") else _PLAIN
    if folder is not None:
        loaders = [jinja2.FileSystemLoader(folder), jinja2.PackageLoader("ptl.report")]
        environment = environment.overlay(loader=jinja2.ChoiceLoader(loaders))
    return str(Markup(environment.get_template(template).render(**values)))
