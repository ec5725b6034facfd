"""``ptl front-page``: the first page of the report."""

from __future__ import annotations

from pathlib import Path

import click

FILE = click.Path(dir_okay=False, path_type=Path)


@click.command()
@click.argument("claims", type=FILE)
@click.argument("metrics", type=FILE)
@click.option(
    "--environment", "environments", multiple=True, required=True, metavar="NAME=TASK=TITLE",
    help="Environment, its last task and its title; repeat.",
)  # fmt: skip
@click.option("--method", "methods", multiple=True, required=True, help="Identifier of a method; repeat.")
@click.option("--output", required=True, type=FILE, help="reStructuredText file to write.")
def command(claims: Path, metrics: Path, environments: tuple[str, ...], methods: tuple[str, ...], output: Path) -> None:
    """Compose the front page from the table of CLAIMS and the table of METRICS."""
    from ptl.files import read_csv, write_text
    from ptl.front_page import compose
    from ptl.methods import load

    parts = [text.split("=", 2) for text in environments]
    page = compose(
        read_csv(claims, keep_default_na=False),
        read_csv(metrics),
        titles={name: title for name, _, title in parts},
        last_tasks={name: task for name, task, _ in parts},
        labels={name: load(name).label for name in methods},
    )
    write_text(output, page)
