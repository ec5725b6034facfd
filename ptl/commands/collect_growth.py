"""``ptl collect-growth``: the library's size after every task, from the growth files of a run."""

from __future__ import annotations

from pathlib import Path

import click

FILE = click.Path(dir_okay=False, path_type=Path)


@click.command()
@click.argument("files", nargs=-1, required=True, type=FILE)
@click.option("--output", required=True, type=FILE, help="CSV with the columns run, tasks and library_size.")
def command(files: tuple[Path, ...], output: Path) -> None:
    """Put the growth FILES of a run into one table; a range of runs may be written as run_[0-29].h5."""
    import pandas as pd

    from ptl.files import expand_numbers, write_csv
    from ptl.store import GROWTH, open_result
    from ptl.verification import OneRun

    rows: list[tuple[int, int, int]] = []
    admitted = OneRun()
    for path in expand_numbers(files):
        with open_result(path, GROWTH) as result:
            admitted.admit(path, result)
            run = int(result.file.attrs["seed"])
            sizes = result.file["library_size"][()]
            rows.extend((run, tasks, int(size)) for tasks, size in enumerate(sizes))
    write_csv(pd.DataFrame(rows, columns=["run", "tasks", "library_size"]), output, sealed=True)
