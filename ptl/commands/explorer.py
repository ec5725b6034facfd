"""``ptl explorer``: the page in which the learning of a run can be watched."""

from __future__ import annotations

from pathlib import Path

import click

FILE = click.Path(dir_okay=False, path_type=Path)


@click.command("explorer")
@click.argument("files", nargs=-1, type=FILE)
@click.option("--output", required=True, type=FILE, help="HTML file to write, complete in itself.")
@click.option(
    "--seed",
    "seeds",
    multiple=True,
    type=click.IntRange(0),
    help="Seed to embed; repeat. [default: all]",
)
@click.option(
    "--environment",
    "environments",
    multiple=True,
    metavar="NAME=TITLE",
    help="Title of an environment; repeat.",
)
def command(
    files: tuple[Path, ...],
    output: Path,
    seeds: tuple[int, ...],
    environments: tuple[str, ...],
) -> None:
    """Build the explorer from learning FILES.

    A range of seeds may be written as seed_[0-2].h5.
    Environments and methods keep the order in which they first appear among FILES. A seed adds some 50 kB for
    six tasks of one method.
    """
    from ptl.explorer.data import collect
    from ptl.explorer.page import build
    from ptl.files import expand_numbers, write_text
    from ptl.progress import shown

    paths = expand_numbers(files)
    titles = dict(_name_and_title(text) for text in environments)
    write_text(output, build(collect(shown(paths, "Reading"), seeds or None, titles)))


def _name_and_title(text: str) -> tuple[str, str]:
    name, _, title = text.partition("=")
    return name, title or name
