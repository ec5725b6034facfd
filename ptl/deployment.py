"""The workflow's files, in a checkout or installed, and new folders in which it runs."""

from __future__ import annotations

import re
import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import yaml

from ptl import methods
from ptl.config import Configuration, check_tasks
from ptl.errors import UserError
from ptl.files.atomic import write_text
from ptl.learning.method_check import check_method
from ptl.study.measures import BASE
from ptl.world.gridworld import GridWorld, load_map

PACKAGE = Path(__file__).parent


def _place(name: str) -> Path:
    """Return a folder that an installation has in the package and a checkout beside it."""
    installed = PACKAGE / name
    return installed if installed.is_dir() else PACKAGE.parent / name


SNAKEFILE = _place("workflow") / "Snakefile"
"""The workflow, to be used as a module by the Snakefile of a study."""

PROFILE = _place("profiles") / "default"
"""The settings with which Snakemake runs it, and the style of its report."""

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
        Methods as `ptl.methods` names them; files are copied into the folder. By default all built-in methods.

    Raises
    ------
    UserError
        One line on the first thing that is wrong, before anything is written.
    """
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise UserError(f"{folder}: exists already; name a folder that is absent or empty")
    places = _environments(maps)
    worlds = {name: load_map(path) for name, path in places.items()}
    orders = _orders(tasks, worlds)
    built_in = sorted(methods.names(), key=lambda name: name != BASE)  # the base first, as readers look for it
    references = methods.by_identifier(chosen or built_in)
    for reference in references.values():
        check_method(reference)
    run = re.sub(r"[^A-Za-z0-9_-]", "_", folder.resolve().name).lstrip("_-") or "study"
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

    for name, path in places.items():
        _copy(path, folder / "maps" / f"{name}.txt")
    for reference in references.values():
        if _kept(reference) != reference:
            _copy(Path(reference), folder / _kept(reference))
    for path in PROFILE.iterdir():
        _copy(path, folder / "profiles/default" / path.name)
    write_text(folder / "Snakefile", SNAKEFILE_OF_A_STUDY)
    text = yaml.safe_dump(config, sort_keys=False, allow_unicode=True, default_flow_style=None, width=100)
    write_text(folder / "config/config.yaml", CONFIGURATION_HEAD + text)
    write_text(folder / "README.md", README.format(run=run))
    write_text(folder / ".gitignore", ".snakemake/\nlogs/\nresults/\n")
    return config


def _environments(maps: Sequence[Path]) -> dict[str, Path]:
    """Return the maps by the name of their environment: the file's stem in the letters that names may have."""
    places: dict[str, Path] = {}
    for path in maps:
        name = re.sub(r"[^a-z0-9_]", "_", path.stem.lower())
        name = name if re.match("[a-z]", name) else f"map_{name}"
        if name in places:
            raise UserError(f"maps {places[name]} and {path} are both called {name}; rename one of the files")
        places[name] = path
    return places


def _orders(tasks: Sequence[str], worlds: Mapping[str, GridWorld]) -> dict[str, str]:
    """Return the tasks of each environment in the order in which they are learned."""
    orders = {name: "".join(world.goals) for name, world in worlds.items()}
    for given in sorted(tasks, key=lambda given: "=" in given):  # one for every map first
        name, equals, letters = given.rpartition("=")
        if equals and name not in orders:
            raise UserError(f"--tasks {given}: no map is called {name!r}; known are {', '.join(orders)}")
        orders |= dict.fromkeys([name] if equals else orders, letters)
    for name, letters in orders.items():
        check_tasks(letters, worlds[name].goals, f"environments.{name}.tasks")
    return orders


def _kept(reference: str) -> str:
    """Return how the study names a method: files lie in its folder."""
    return f"methods/{Path(reference).name}" if reference.endswith(".py") else reference


def _copy(source: Path, target: Path) -> None:
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(source, target)
    except OSError as error:
        raise UserError(f"{target}: cannot be written ({error.strerror}); choose a writable folder") from error
