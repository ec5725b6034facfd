"""``ptl score``: compare the printed tables of the article with the published predictions of their cells."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ptl.cli._columns import laid_out

if TYPE_CHECKING:
    import pandas as pd

PREDICTIONS = "reports/predictions/predictions.csv"


@click.command()
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--template", "wants_template", is_flag=True, help="Write an empty FILE with all cells, and no more.")
@click.option("--predictions", default=PREDICTIONS, show_default=True, type=click.Path(),
              help="Predictions of the cells.")  # fmt: skip
@click.option("--output", type=click.Path(path_type=Path),
              help="PNG file of the figure; beside it SVG and CSV files. FILE_scores.png if left out.")  # fmt: skip
def command(file: Path, wants_template: bool, predictions: str, output: Path | None) -> None:
    """Score the printed tables in FILE.

    FILE is CSV with the columns table, environment, task, method, measure, mean, sd; --template makes one to fill in.
    Printed for each number: the median of its prediction, the ranges of 50 and 90%, its rank (share of the prediction
    below it), * inside the 50% range, + inside the 90% range, and the continuous ranked probability score (CRPS), for
    the prediction from all settings and from those in which most of the article's claims hold.
    """
    from ptl.errors import UserError
    from ptl.files.atomic import write_text
    from ptl.files.csv import write_csv
    from ptl.measures import printed, scoring

    predicted = scoring.read_predictions(predictions)
    if wants_template:
        if file.exists():
            raise UserError(f"{file}: exists and may have numbers typed in; name another file or remove it")
        write_text(file, printed.template(predicted))
        click.echo(f"{file}: written; type the printed numbers in, then: ptl score {file}")
        return
    target = output or file.with_name(f"{file.stem}_scores.png")
    scores = scoring.score(printed.read_printed(file, predicted), predicted)
    covered = scoring.coverage(scores)

    from ptl.report.figures import saving
    from ptl.report.figures.scores import draw

    saving.save(draw(scores), scores, target)
    write_csv(covered, target.with_name(f"{target.stem}_coverage.csv"))
    width = shutil.get_terminal_size().columns
    for (table, environment), part in scores.groupby(["table", "environment"], sort=False):
        click.echo(f"Table {table}, {environment}")
        click.echo("\n".join(laid_out(list(_columns(part)), width)) + "\n")
    click.echo("\n".join(laid_out(list(_coverage_columns(covered)), width)) + "\n")
    click.echo("\n".join(scoring.sentences(scores)))
    click.echo(f"Cells of one table depend on one another. Written: {target}, with .svg and .csv beside it.")


def _columns(part: pd.DataFrame) -> Iterator[list[str]]:
    """Yield the columns of a table's scores, each with its two headings first."""
    from ptl.measures.scoring import DISTRIBUTIONS
    from ptl.text import MISSING, interval, number

    cell = ["task", "method", "measure", "statistic"]
    by_distribution = {
        name: part[part["distribution"] == name].set_index(cell).to_dict("index") for name in DISTRIBUTIONS
    }
    cells = list(dict.fromkeys(part[cell].itertuples(index=False, name=None)))
    printed = {key: row["printed"] for rows in by_distribution.values() for key, row in rows.items()}
    yield ["", "", *(" ".join(key) for key in cells)]
    yield ["", "printed", *(number(printed[key]) for key in cells)]
    for name, rows in by_distribution.items():
        own = [rows.get(key) for key in cells]
        yield [name, "median", *(number(row["median"]) if row else MISSING for row in own)]
        for level in (50, 90):
            ends = (interval(row[f"low_{level}"], row[f"high_{level}"]) if row else MISSING for row in own)
            yield ["", f"{level}%", *ends]
        yield ["", "rank", *(number(row["rank"]) + _mark(row) if row else MISSING for row in own)]
        yield ["", "CRPS", *(number(row["crps"]) if row else MISSING for row in own)]


def _mark(row: dict) -> str:
    return "*" if row["inside_50"] else "+" if row["inside_90"] else " "


def _coverage_columns(covered: pd.DataFrame) -> Iterator[list[str]]:
    """Yield the columns of the table of coverage."""
    from ptl.text import percent

    yield ["coverage", *(f"{row.distribution}, {row.statistic}" for row in covered.itertuples())]
    yield ["range", *(percent(row.nominal) for row in covered.itertuples())]
    yield ["inside", *(f"{row.inside} of {row.cells}" for row in covered.itertuples())]
    yield ["share", *(percent(round(row.coverage, 2)) for row in covered.itertuples())]
