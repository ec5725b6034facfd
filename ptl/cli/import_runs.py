"""``ptl import-runs``: the table of another program's runs, from what it has logged."""

from __future__ import annotations

from pathlib import Path

import click


@click.command()
@click.argument("sources", nargs=-1, required=True, metavar="[TASK=]PATH...")
@click.option("--environment", help="Environment of the runs, as the configuration calls it.")
@click.option("--method", help="Method of the runs, as foreign_results calls it.")
@click.option("--task", help="Goal letter of the runs; for several tasks write TASK=PATH.")
@click.option("--columns", multiple=True, metavar="OURS=THEIRS",
              help="Column of a table; repeat it, or separate several by commas. Ours are environment, method, task,"
                   " seed, episode, steps, truncated, and total_steps for running totals.")  # fmt: skip
@click.option("--episodes", type=click.IntRange(1), help="Episodes of each run; by default those of the shortest.")
@click.option("--max-steps", type=click.IntRange(1), help="Limit of steps: episodes of this length were cut off.")
@click.option("--output", type=click.Path(path_type=Path), help="CSV file to write; by default METHOD.csv.")
def command(
    sources: tuple[str, ...],
    environment: str | None,
    method: str | None,
    task: str | None,
    columns: tuple[str, ...],
    episodes: int | None,
    max_steps: int | None,
    output: Path | None,
) -> None:
    """Turn runs that another program has logged into a table for foreign_results.

    PATH is a file or a folder: monitor.csv (Stable-Baselines3, Baselines), progress.csv (RLlib and others), exports of
    TensorBoard and Weights & Biases (CleanRL), CSV logs of bsuite, or tables with one row an episode. In a folder, each
    folder with such files is a seed.
    """
    import re

    import yaml

    from ptl.files.atomic import write_text
    from ptl.files.runs import Source, import_runs, parsed_columns

    places = [re.fullmatch("(?:([A-Z])=)?(.*)", source, re.DOTALL) for source in sources]
    given = {"environment": environment, "method": method, "task": task}
    imported = import_runs(
        [Source(Path(place[2]), place[1] or "") for place in places if place],
        given={key: value for key, value in given.items() if value is not None},
        columns=parsed_columns(columns),
        episodes=episodes,
        max_steps=max_steps,
    )
    table = imported.table
    names = list(table["method"].unique())
    path = output or Path(f"{names[0]}.csv")
    write_text(path, table.to_csv(index=False, lineterminator="\n"))
    for note in imported.notes:
        click.echo(f"note: {note}", err=True)
    click.echo(
        f"{path}: written, {table['seed'].nunique()} seeds, {table['episode'].max()} episodes of"
        f" {', '.join(f'{task} in {place}' for place, task in table.groupby(['environment', 'task']).groups)}"
    )
    entry = yaml.safe_dump(
        {"foreign_results": {name: {"file": str(path)} for name in names}}, default_flow_style=None, width=1000
    )
    click.echo(f"name it in the configuration:\n{entry}", nl=False)
