"""Snakemake's own report: titles and labels stay text in it."""

from __future__ import annotations

from collections.abc import Callable


def keep_texts() -> None:
    """Write ``<`` in the data of Snakemake's report as ``\\u003c``.

    Snakemake 9.27 puts labels and params as JSON into script elements, which a title with ``</script>`` would end.
    """
    from snakemake.report.html_reporter import data

    for name in [name for name in vars(data) if name.startswith("render_")]:
        setattr(data, name, _without_tags(getattr(data, name)))


def _without_tags(render: Callable[..., str]) -> Callable[..., str]:
    return lambda *arguments: render(*arguments).replace("<", "\\u003c")
