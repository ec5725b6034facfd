"""New folders in which the second study runs on users' methods, for `ptl new-study --population`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ptl import methods
from ptl.deployment import method_files, name_in_study, run_name, write_study
from ptl.errors import UserError
from ptl.files.configuration import read_yaml
from ptl.keys import repeated
from studies.beyond.collect import foreign_lives
from studies.beyond.design import SecondStudy
from studies.beyond.methods import reference
from studies.beyond.population import BANDS, MAPS, SIZE

HERE = Path(__file__).parent

SNAKEFILE = HERE / "Snakefile"
"""The workflow of the second study, to be used as a module by the Snakefile of a folder."""


def new_population_study(
    folder: Path,
    band: str,
    *,
    maps: int | None = None,
    seeds: int | None = None,
    episodes: int | None = None,
    chosen: Sequence[str] = (),
    lives: Sequence[Path] = (),
) -> dict[str, Any]:
    """Make a folder in which the second study runs on a user's methods, and return its configuration.

    Parameters
    ----------
    folder : path
        Must be absent or empty; the run gets its name.
    band : {"tuning", "test"}
        Tune on the first, report on the second.
    maps, seeds, episodes : int, optional
        Maps of each family, lives on each, episodes of a task; by default as in the published study.
    chosen : sequence of str
        Methods to run, those of `studies.beyond.methods` among them; files are copied into the folder.
    lives : sequence of paths
        Tables of lives of other methods (columns of ``per_life.csv``), copied into the folder.

    Raises
    ------
    UserError
        One line on the first error, before anything is written.
    """
    run = run_name(folder)
    if (band, SIZE) not in MAPS:
        raise UserError(f"--population: {band!r} is not allowed; give one of {', '.join(BANDS)}")
    references = methods.by_identifier(map(reference, chosen)).values()
    published = read_yaml(HERE / "config/beyond.yaml")
    config: dict[str, Any] = {
        "run": run,
        "band": band,
        "maps": maps or min(published["maps"], MAPS[band, SIZE]),
        "seeds": seeds or published["seeds"],
        "methods": [name_in_study(name) for name in chosen],
        "foreign_lives": [f"lives/{path.name}" for path in lives],
    }
    if episodes is not None:
        config["learning"] = {"episodes": episodes}
    if twice := repeated(config["foreign_lives"]):
        raise UserError(f"--lives: two files are called {Path(twice[0]).name}; rename one of them")
    checked = {"methods": list(chosen), "foreign_lives": [str(path) for path in lives]}
    foreign_lives(SecondStudy.read({**config, **checked}))
    files = {Path("lives", path.name): path for path in lives}
    write_study(folder, config, files | method_files(references), HERE / "skeleton")
    return config
