"""Make the notebooks from the scripts of the same name, with their outputs: python examples/make_notebook.py

Lines that begin with `# %%` divide the script into cells, as in Jupytext and many editors; `# %% [markdown]` begins a
cell of text. The docstring of the script is the first cell. The notebook names no machine, no time and no version, so
that the same outputs give the same file.
"""

from __future__ import annotations

import ast
import io
import json
import tempfile
from base64 import b64encode
from contextlib import chdir, redirect_stdout
from pathlib import Path
from typing import Any

SCRIPTS = [Path(__file__).with_name(f"{name}.py") for name in ("first_look", "whole_argument")]
SETUP = "%matplotlib inline"
"""Code of the notebook alone: makes Jupyter show figures."""


def cells_of(script: str) -> list[tuple[str, str]]:
    """Return the kind, "markdown" or "code", and the source of each cell of the notebook."""
    parts = script.split("\n# %%")
    title, _, text = (ast.get_docstring(ast.parse(parts[0])) or "").partition("\n\n")
    cells = [("markdown", f"# {title.partition(':')[0]}\n\n{text}"), ("code", SETUP)]
    for part in parts[1:]:
        first, _, source = part.strip().partition("\n")
        if first == "[markdown]":
            source = "\n".join(line.removeprefix("#").removeprefix(" ") for line in source.splitlines())
            cells.append(("markdown", source))
        else:
            cells.append(("code", part.strip()))
    return cells


def run(source: str, names: dict[str, Any]) -> list[dict[str, Any]]:
    """Run the code of a cell and return its outputs: what it prints, and its last expression if that is a figure."""
    body = ast.parse(source).body
    shown = body.pop() if isinstance(body[-1], ast.Expr) and isinstance(body[-1].value, ast.Name) else None
    printed = io.StringIO()
    with redirect_stdout(printed):
        exec(compile(ast.Module(body, []), "cell", "exec"), names)
    outputs: list[dict[str, Any]] = []
    if printed.getvalue():
        outputs.append({"name": "stdout", "output_type": "stream", "text": lines_of(printed.getvalue())})
    if shown is not None:
        picture = io.BytesIO()
        names[shown.value.id].savefig(picture, dpi=80, metadata={"Software": None})
        data = {"image/png": b64encode(picture.getvalue()).decode()}
        outputs.append({"data": data, "metadata": {}, "output_type": "display_data"})
    return outputs


def lines_of(text: str) -> list[str]:
    """Return the lines of a text as the format of notebooks has them."""
    return text.splitlines(keepends=True)


def notebook_of(script: str) -> dict[str, Any]:
    """Run a script cell by cell and return its notebook (format 4.5)."""
    names: dict[str, Any] = {"__name__": "__main__"}
    cells = []
    for number, (kind, source) in enumerate(cells_of(script)):
        cell: dict[str, Any] = {"cell_type": kind, "id": f"cell-{number}", "metadata": {}, "source": lines_of(source)}
        if kind == "code":
            outputs = [] if source == SETUP else run(source, names)
            cell |= {"execution_count": None, "outputs": outputs}
        cells.append(cell)
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    metadata = {"kernelspec": kernel, "language_info": {"name": "python"}}
    return {"cells": cells, "metadata": metadata, "nbformat": 4, "nbformat_minor": 5}


if __name__ == "__main__":
    for path in SCRIPTS:
        with tempfile.TemporaryDirectory() as folder, chdir(folder):  # a script writes its figures where it runs
            notebook = notebook_of(path.read_text(encoding="utf-8"))
        text = json.dumps(notebook, indent=1, ensure_ascii=False) + "\n"
        path.with_suffix(".ipynb").write_text(text, encoding="utf-8")
