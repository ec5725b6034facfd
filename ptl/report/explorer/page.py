"""Join the data set, the style and the scripts into one self-contained HTML file.

The scripts in ``web`` are plain ES modules. They are joined without a build tool: import lines and the word
``export`` are dropped, and the whole becomes one function, so no name reaches the page and no file refers to
another.
"""

from __future__ import annotations

import base64
import gzip
import hashlib
import json
import re
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import Any

WEB = Path(__file__).parent / "web"

PURE_MODULES = ("format.js", "colour.js", "world.js", "episodes.js", "dataset.js", "address.js")
"""Modules that only compute; each may use those before it."""

VIEW_MODULES = ("svg.js", "map_view.js", "charts.js", "guides.js", "stage.js", "app.js")
"""Modules that work on the page."""

_IMPORT = re.compile(r'^import\b[^;]*?\bfrom\s+"\./[a-z_]+\.js";\n', re.MULTILINE)
_EXPORT = re.compile(r"^export (?=(?:const|(?:async )?function|class)\b)", re.MULTILINE)
_TOP_NAME = re.compile(r"^(?:const|let|(?:async )?function\*?|class) (\w+)", re.MULTILINE)


def bundle(modules: Iterable[str] = (*PURE_MODULES, *VIEW_MODULES)) -> str:
    """Return the modules as one script, in the order given.

    Raises
    ------
    ValueError
        If two modules declare the same name at their top level, or an import or export is written in
        another way.
    """
    sources = []
    for name in modules:
        text = _EXPORT.sub("", _IMPORT.sub("", (WEB / name).read_text(encoding="utf-8")))
        if left := re.search(r"^(?:import|export)\b.*", text, re.MULTILINE):
            raise ValueError(f"{name}: cannot join this line: {left.group()}")
        sources.append(f"// {name}\n{text.strip()}\n")
    joined = "\n".join(sources)
    doubled = [name for name, count in Counter(_TOP_NAME.findall(joined)).items() if count > 1]
    if doubled:
        raise ValueError(f"declared in more than one module: {', '.join(doubled)}")
    return joined


def build(data: dict[str, Any]) -> str:
    """Return the page for a data set of `ptl.report.explorer.data.collect`; equal data give equal text."""
    style = (WEB / "style.css").read_text(encoding="utf-8")
    script = '"use strict";\n(() => {\n' + bundle() + "})();\n"
    policy = (
        "default-src 'none'; img-src data:; base-uri 'none'; form-action 'none';"
        f" style-src '{_source_hash(style)}'; script-src '{_source_hash(script)}'"
    )
    parts = {"policy": policy, "style": style, "script": script, "data": pack(data)}
    for name in ("stage", "detail"):  # these occur twice in the page
        parts[name] = (WEB / f"{name}.html").read_text(encoding="utf-8")
    page = (WEB / "explorer.html").read_text(encoding="utf-8")
    return re.sub(r"\{\{(\w+)\}\}", lambda match: parts[match.group(1)], page)


def pack(data: dict[str, Any]) -> str:
    """Return a data set as gzipped JSON in base64.

    The page is kept small, because Chromium shows it inside the report only up to 1.5 MB (2 MiB as a data address).
    """
    text = json.dumps(data, separators=(",", ":"), allow_nan=False)
    return base64.b64encode(gzip.compress(text.encode(), mtime=0)).decode("ascii")


def _source_hash(text: str) -> str:
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode("utf-8")).digest()).decode("ascii")
