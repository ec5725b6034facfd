"""``ptl make-map``: write a generated map."""

from __future__ import annotations

from pathlib import Path

import click

from ptl.world.mazes import FAMILIES


@click.command()
@click.argument("family", type=click.Choice(list(FAMILIES)))
@click.option("--size", default=300, show_default=True, type=click.IntRange(30, 10**6),
              help="Number of states, about.")  # fmt: skip
@click.option("--seed", default=0, show_default=True, type=click.IntRange(0, 2**63 - 1), help="Seed of the map.")
@click.option("--output", type=click.Path(path_type=Path), help="File to write; by default FAMILY_SIZE_SEED.txt.")
def command(family: str, size: int, seed: int, output: Path | None) -> None:
    """Write a generated map of FAMILY with a start and the goals A to F, in the order of their distance.

    Its walls are those of the second study's map of the same family, size and seed.
    """
    from ptl.files.atomic import write_text
    from ptl.world.map_files import generated_map

    world = generated_map(family, size, seed)
    path = output or Path(f"{world.name}.txt")
    write_text(path, world.text)
    click.echo(f"{path}: written, {world.n_states} states; 'ptl show-map {path}' shows it")
