"""``ptl new-study``: a folder in which the workflow runs on maps of one's own."""

from __future__ import annotations

from pathlib import Path

import click


@click.command()
@click.argument("folder", type=click.Path(path_type=Path))
@click.option("--map", "maps", multiple=True, required=True, type=click.Path(path_type=Path),
              help="Text file of a map; repeat it for several. Its environment is called after the file.")  # fmt: skip
@click.option("--tasks", multiple=True,
              help="Goal letters in the order of learning, for every map (BAC) or for one (maze=BAC);"
                   " by default all goals in alphabetical order.")  # fmt: skip
@click.option("--seeds", type=click.IntRange(1), help="Learning runs per environment and method (default 30).")
@click.option("--episodes", type=click.IntRange(1), help="Episodes of each task (default 200).")
@click.option("--method", "methods", multiple=True,
              help="Method to compare: a built-in name, a file that ends in .py (it is copied), or"
                   " package.module:Class; repeat it for several. By default all built-in methods.")  # fmt: skip
def command(
    folder: Path,
    maps: tuple[Path, ...],
    tasks: tuple[str, ...],
    seeds: int | None,
    episodes: int | None,
    methods: tuple[str, ...],
) -> None:
    """Make FOLDER, in which `snakemake -j2` compares methods on your own maps.

    Maps, tasks and methods are checked before anything is written.
    """
    from ptl.cli.config_docs import tables
    from ptl.deployment import new_study
    from ptl.files.atomic import write_text
    from ptl.study.measures import BASE

    config = new_study(folder, maps, tasks=tasks, seeds=seeds, episodes=episodes, chosen=methods)
    write_text(folder / "config/README.md", f"# Keys of the configuration\n\n{tables()}")
    for name, entry in config["environments"].items():
        click.echo(f"environment {name}: tasks {', '.join(entry['tasks'])}")
    click.echo(f"methods: {', '.join(config['methods'])}")
    if BASE not in config["methods"]:
        click.echo(f"note: without {BASE} there is no jump start and no transfer ratio; add it for comparisons")
    click.echo(f"run it: cd {folder} && snakemake -j2 && snakemake --report reports/{config['run']}/report.html")
