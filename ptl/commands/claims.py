"""``ptl claims``: the verdict on every claim of the article, from a run's own results."""

from __future__ import annotations

from pathlib import Path

import click

FILE = click.Path(dir_okay=False, path_type=Path)


@click.command("claims")
@click.argument("per_seed", type=FILE)
@click.option("--map", "maps", multiple=True, required=True, metavar="NAME=FILE", help="Map of an environment; repeat.")
@click.option("--steps", type=FILE, help="HDF5 of the steps per episode (`ptl measure`).")
@click.option("--subgoals", type=FILE, help="CSV of the subgoals found (`ptl measure`).")
@click.option("--growth", type=FILE, help="CSV of library sizes: run, tasks, library_size.")
@click.option("--selection-cost", type=FILE, help="CSV of skills and seconds (`ptl library-cost`).")
@click.option("--library-bytes", type=FILE, help="CSV of states, skills and bytes (`ptl library-cost`).")
@click.option(
    "--confidence",
    required=True,
    type=click.FloatRange(0, 1, min_open=True, max_open=True),
    help="Level of the intervals.",
)
@click.option("--resamples", required=True, type=click.IntRange(min=1), help="Bootstrap resamples.")
@click.option("--output-csv", required=True, type=FILE, help="Ledger as CSV, a row for each claim.")
@click.option("--output-parts", required=True, type=FILE, help="CSV with a row for each part of each claim.")
@click.option("--output-md", required=True, type=FILE, help="Ledger as Markdown; the counts come first.")
@click.option("--output-html", required=True, type=FILE, help="Ledger as a page.")
def command(
    per_seed: Path,
    maps: tuple[str, ...],
    steps: Path | None,
    subgoals: Path | None,
    growth: Path | None,
    selection_cost: Path | None,
    library_bytes: Path | None,
    confidence: float,
    resamples: int,
    output_csv: Path,
    output_parts: Path,
    output_md: Path,
    output_html: Path,
) -> None:
    """Judge the article's claims by PER_SEED, the table of `ptl measure`, and the other files of the run.

    Claims that need a file which is left out come out as undecided.
    """
    from ptl.claims import judge, ledger
    from ptl.evidence import read_evidence
    from ptl.files import write_csv, write_text
    from ptl.statistics import Resampling

    how = Resampling(confidence, resamples)
    files = (steps, subgoals, growth, selection_cost, library_bytes)
    evidence = read_evidence(per_seed, dict(map(_name_and_path, maps)), *files, how=how)
    judgements = judge(evidence)
    run = ledger.Run(evidence.n_seeds(), confidence, resamples)
    write_csv(ledger.to_frame(judgements), output_csv, sealed=True)
    write_csv(ledger.to_parts_frame(judgements), output_parts)
    write_text(output_md, ledger.to_markdown(judgements, run))
    write_text(output_html, ledger.to_html(judgements, run))


def _name_and_path(text: str) -> tuple[str, Path]:
    from ptl.errors import UserError

    name, equals, path = text.partition("=")
    if not (name and equals and path):
        raise UserError(f"--map {text}: is not NAME=FILE; write e.g. --map env1=config/environments/env1.txt")
    return name, Path(path)
