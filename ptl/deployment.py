"""The workflow's files, in a checkout or installed, and new folders in which it runs."""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import yaml

from ptl import methods
from ptl.config import Configuration, check_tasks
from ptl.errors import UserError
from ptl.files.atomic import write_text
from ptl.files.configuration import read_yaml
from ptl.files.outside import local_sources
from ptl.keys import repeated
from ptl.learning.method_check import check_method
from ptl.measures.measures import BASE
from ptl.methods import beyond
from ptl.world.gridworld import GridWorld, load_map
from studies.beyond.collect import foreign_lives
from studies.beyond.design import Study as Population
from studies.beyond.population import MAPS, POPULATION, SIZE

PACKAGE = Path(__file__).parent


def _place(name: str) -> Path:
    """Return a folder that an installation has in the package and a checkout beside it."""
    installed = PACKAGE / name
    return installed if installed.is_dir() else PACKAGE.parent / name


SNAKEFILE = _place("workflow") / "Snakefile"
"""The workflow, to be used as a module by the Snakefile of a study."""

PROFILE = _place("profiles") / "default"
"""The settings with which Snakemake runs it, and the style of its report."""

BEYOND = SNAKEFILE.with_name("beyond.smk")
"""The workflow of the second study, to be included by the Snakefile of a study on its maps."""

POPULATION_TABLE = _place("config") / "population.csv"
"""The maps of the second study."""

SURVEYED_WHOLE = 400
"""States up to which a new study surveys all start states; a larger map gets a sample, because the cost of the survey
grows with more than the square of the number of states."""

SNAKEFILE_OF_A_STUDY = """\
# The study in this folder: `snakemake -j2` makes everything that config/config.yaml describes.

from ptl.deployment import SNAKEFILE
from ptl.files.atomic import remove_unfinished


configfile: "config/config.yaml"


module ptl:
    snakefile:
        SNAKEFILE
    config:
        config


use rule * from ptl


onstart:
    remove_unfinished(f"results/{config['run']}", f"reports/{config['run']}")
"""

SNAKEFILE_OF_A_POPULATION = SNAKEFILE_OF_A_STUDY.replace("SNAKEFILE", "BEYOND")

README_OF_A_POPULATION = """\
# {run}

A study of methods on the {band} maps of the second study of the Python package `ptl`. In an environment in which the
package is installed, `snakemake -j2` runs what is missing and writes `reports/{run}/index.html`, with figures and
tables beside it, and `reports/{run}/per_life.csv`, a row for each life.

`config/config.yaml` says what is compared: `methods` are run, `foreign_lives` are read from CSV files with the columns
of `per_life.csv`. `maps` counts the maps of each family; a study on fewer maps takes the first ones.
"""

CONFIGURATION_HEAD = """\
# Every key that is not here has its default; README.md beside this file lists all keys with their ranges.
"""

README = """\
# {run}

A study of transfer between navigation tasks with the Python package `ptl`. In an environment in which the package is
installed:

```sh
snakemake -j2                                              # everything that is missing or out of date
snakemake --report reports/{run}/report.html      # one page with all tables, figures and the explorer
```

| place | content |
|---|---|
| `config/config.yaml` | what is learned: maps, tasks, methods, seeds; `config/README.md` lists all keys |
| `maps/` | the maps: `#` wall, `.` free cell, `I` start, other capital letters goals |
| `methods/` | methods of your own; name them in `methods:` as `methods/<name>.py` |
| `reports/{run}/tables/per_seed.csv` | every measure of every seed; `metrics.csv` holds means and intervals |
| `reports/{run}/figures/` | figures as PNG, SVG and CSV |
| `reports/{run}/explorer.html` | a page on which single learners can be watched |
| `results/{run}/` | result files of all jobs; `ptl inspect FILE` prints one, `ptl verify results reports` checks all |

After a change of the configuration, of a map or of a method, `snakemake -j2` learns only what has changed.
"""


def new_study(
    folder: Path,
    maps: Sequence[Path],
    *,
    tasks: Sequence[str] = (),
    seeds: int | None = None,
    episodes: int | None = None,
    chosen: Sequence[str] = (),
) -> dict[str, Any]:
    """Make a folder in which the workflow runs on maps of one's own, and return its configuration.

    Parameters
    ----------
    folder : path
        Must be absent or empty; the run is called after it.
    maps : sequence of paths
        Each map becomes an environment, called after the file's stem.
    tasks : sequence of str
        Goal letters in the order in which they are learned: ``"BAC"`` for every map, ``"maze=BAC"`` for one.
        By default all goals of a map in alphabetical order.
    seeds, episodes : int, optional
    chosen : sequence of str
        Methods as `ptl.methods` names them. Files, and modules of the current folder, are copied into the study with
        what they import from there. By default all built-in methods.

    Raises
    ------
    UserError
        One line on the first thing that is wrong, before anything is written.
    """
    _check_absent(folder)
    places = _environments(maps)
    worlds = {name: load_map(path) for name, path in places.items()}
    orders = _orders(tasks, worlds)
    built_in = sorted(methods.names(), key=lambda name: name != BASE)  # the base first, as readers look for it
    references = methods.by_identifier(chosen or built_in)
    for reference in references.values():
        check_method(reference)
    run = _run_name(folder)
    config: dict[str, Any] = {
        "run": run,
        "environments": {
            name: {"title": places[name].stem, "map": f"maps/{name}.txt", "tasks": orders[name]} for name in places
        },
        "methods": [_kept(reference) for reference in references.values()],
    }
    if seeds is not None:
        config |= {"seeds": seeds, "growth": {"runs": seeds}}
    if episodes is not None:
        config["learning"] = {"episodes": episodes}
    if max(world.n_states for world in worlds.values()) > SURVEYED_WHOLE:
        config["subgoal_frequencies"] = {"starts": 20}
    Configuration.from_dict(config)
    sources = _method_files(references.values())

    for name, path in places.items():
        _copy(path, folder / "maps" / f"{name}.txt")
    _write(folder, config, sources, SNAKEFILE_OF_A_STUDY, README.format(run=run))
    return config


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
    """Make a folder in which the second study runs on methods of one's own, and return its configuration.

    Parameters
    ----------
    folder : path
        Must be absent or empty; the run is called after it.
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
        One line on the first thing that is wrong, before anything is written.
    """
    _check_absent(folder)
    references = methods.by_identifier(map(beyond.reference, chosen))
    published = read_yaml(_place("config") / "beyond.yaml")
    config: dict[str, Any] = {
        "run": _run_name(folder),
        "band": band,
        "maps": maps or min(published["maps"], MAPS[band, SIZE]),
        "seeds": seeds or published["seeds"],
        "methods": [_kept(name) for name in chosen],
        "foreign_lives": [f"lives/{path.name}" for path in lives],
    }
    if episodes is not None:
        config["learning"] = {"episodes": episodes}
    if twice := repeated(config["foreign_lives"]):
        raise UserError(f"--lives: two files are called {Path(twice[0]).name}; rename one of them")
    checked = {"methods": list(chosen), "foreign_lives": [str(path) for path in lives]}
    foreign_lives(Population.read({**config, **checked, "population": str(POPULATION_TABLE)}))
    sources = _method_files(references.values())

    for path in lives:
        _copy(path, folder / "lives" / path.name)
    _copy(POPULATION_TABLE, folder / POPULATION)
    _write(folder, config, sources, SNAKEFILE_OF_A_POPULATION, README_OF_A_POPULATION.format(**config))
    return config


def _check_absent(folder: Path) -> None:
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise UserError(f"{folder}: exists already; name a folder that is absent or empty")


def _run_name(folder: Path) -> str:
    return re.sub(r"[^A-Za-z0-9_-]", "_", folder.resolve().name).lstrip("_-") or "study"


def _write(folder: Path, config: Mapping[str, Any], sources: Mapping[Path, Path], snakefile: str, readme: str) -> None:
    """Write what every study has: its methods' files, the profile, Snakefile, configuration and README."""
    for place, path in sources.items():
        _copy(path, folder / place)
    for path in PROFILE.iterdir():
        _copy(path, folder / "profiles/default" / path.name)
    write_text(folder / "Snakefile", snakefile)
    text = yaml.safe_dump(config, sort_keys=False, allow_unicode=True, default_flow_style=None, width=100)
    write_text(folder / "config/config.yaml", CONFIGURATION_HEAD + text)
    write_text(folder / "README.md", readme)
    write_text(folder / ".gitignore", ".snakemake/\nlogs/\nresults/\n")


def _environments(maps: Sequence[Path]) -> dict[str, Path]:
    """Return the maps by the name of their environment: the file's stem in the letters that names may have."""
    places: dict[str, Path] = {}
    for path in maps:
        name = _environment(path.stem)
        if name in places:
            raise UserError(f"maps {places[name]} and {path} are both called {name}; rename one of the files")
        places[name] = path
    return places


def _environment(stem: str) -> str:
    name = re.sub(r"[^a-z0-9_]", "_", stem.lower())
    return name if re.match("[a-z]", name) else f"map_{name}"


def _orders(tasks: Sequence[str], worlds: Mapping[str, GridWorld]) -> dict[str, str]:
    """Return the tasks of each environment in the order in which they are learned."""
    orders = {name: "".join(world.goals) for name, world in worlds.items()}
    for given in sorted(tasks, key=lambda given: "=" in given):  # one for every map first
        name, equals, letters = given.rpartition("=")
        if equals and _environment(name) not in orders:
            raise UserError(f"--tasks {given}: no map is called {name!r}; known are {', '.join(orders)}")
        orders |= dict.fromkeys([_environment(name)] if equals else orders, letters)
    for name, letters in orders.items():
        check_tasks(letters, worlds[name].goals, f"environments.{name}.tasks")
    return orders


def _method_files(references: Iterable[str]) -> dict[Path, Path]:
    """Return the files of methods that a study keeps, by their place in its folder."""
    here = Path.cwd()
    kept: dict[Path, Path] = {}
    for reference in references:
        if reference in methods.names() or reference.startswith("ptl."):
            continue
        root, paths = local_sources(reference)
        for path in paths:
            if reference.endswith(".py") and path.is_relative_to(root):
                place = "methods" / path.relative_to(root)
            elif path.is_relative_to(here):
                place = path.relative_to(here)
            else:  # of an installed package
                continue
            if kept.setdefault(place, path) != path:
                raise UserError(
                    f"method {reference}: {kept[place]} and {path} would both be {place}; rename one of them"
                )
    return kept


def _kept(reference: str) -> str:
    """Return how the study names a method: files lie in its folder."""
    return f"methods/{Path(reference).name}" if reference.endswith(".py") else reference


def _copy(source: Path, target: Path) -> None:
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(source, target)
    except OSError as error:
        raise UserError(f"{target}: cannot be written ({error.strerror}); choose a writable folder") from error
