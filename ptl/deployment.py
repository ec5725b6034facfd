"""The workflow's files, in a checkout or installed, and new folders in which it runs."""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import yaml

from ptl import methods
from ptl.config import Configuration, Measures, check_tasks
from ptl.errors import UserError
from ptl.files.outside import local_sources
from ptl.learning.trial import check_method
from ptl.measures.measures import BASE
from ptl.world.gridworld import GridWorld

PACKAGE = Path(__file__).parent

SKELETON = PACKAGE / "skeleton"
"""Files of a new study."""

SURVEYED_WHOLE = 400
"""States up to which a survey in a new study has all start states; a larger map gets a sample, because the cost of the
survey grows with more than the square of the number of states."""


def shared_folder(name: str) -> Path:
    """Return a folder that is inside the package in an installation, and next to it in a checkout."""
    installed = PACKAGE / name
    return installed if installed.is_dir() else PACKAGE.parent / name


SNAKEFILE = shared_folder("workflow") / "Snakefile"
"""The workflow, to be used as a module by the Snakefile of a study."""

PROFILE = shared_folder("profiles") / "default"
"""The settings with which Snakemake runs it, and the style of its report."""


def new_study(
    folder: Path,
    maps: Sequence[GridWorld],
    *,
    tasks: Sequence[str] = (),
    seeds: int | None = None,
    episodes: int | None = None,
    chosen: Sequence[str] = (),
    survey: bool = False,
    growth: bool = False,
) -> dict[str, Any]:
    """Make a folder in which the workflow runs on a user's maps, and return its configuration.

    Parameters
    ----------
    folder : path
        Must be absent or empty; the run gets its name.
    maps : sequence of GridWorld
        Each map becomes an environment, named after the stem of its file; the folder gets its text.
    tasks : sequence of str
        Goal letters in the order in which they are learned: ``"BAC"`` for every map, ``"maze=BAC"`` for one.
        By default all goals of a map in alphabetical order.
    seeds, episodes : int, optional
    chosen : sequence of str
        Methods as `ptl.methods` names them. Files, and modules of the current folder, are copied into the study with
        their imports from there. By default all built-in methods.
    survey, growth : bool
        Whether subgoals are surveyed over all pairs of start and goal, and a library is grown over random tasks. Both
        take long on large maps.

    Raises
    ------
    UserError
        One line on the first error, before anything is written.
    """
    run = run_name(folder)
    worlds: dict[str, GridWorld] = {}
    for world in maps:
        if (name := _environment(Path(world.name).stem)) in worlds:
            raise UserError(
                f"maps {worlds[name].name} and {world.name} are both called {name}; rename one of the files"
            )
        worlds[name] = world
    orders = _orders(tasks, {name: list(world.goals) for name, world in worlds.items()})
    built_in = sorted(methods.names(), key=lambda name: name != BASE)  # the base first, as readers expect it
    references = methods.by_identifier(chosen or built_in).values()
    for reference in references:
        check_method(reference)
    config: dict[str, Any] = {
        "run": run,
        "environments": {
            name: {"title": Path(world.name).stem, "map": f"maps/{name}.txt", "tasks": orders[name]}
            | ({"map_options": {"slip": world.slip}} if world.slip else {})
            for name, world in worlds.items()
        },
        "methods": [name_in_study(reference) for reference in references],
    }
    if seeds is not None:
        config["seeds"] = seeds
    if episodes is not None:
        config["learning"] = {"episodes": episodes}
        if episodes < Measures().window:
            config["measures"] = {"window": episodes}
    if not growth:
        config["growth"] = {"runs": 0}
    elif seeds is not None:
        config["growth"] = {"runs": seeds}
    if not survey:
        config["subgoal_frequencies"] = {"starts": 0}
    elif max(world.n_states for world in worlds.values()) > SURVEYED_WHOLE:
        config["subgoal_frequencies"] = {"starts": 20}
    Configuration.from_dict(config)
    files: dict[Path, Path | str] = {Path("maps", f"{name}.txt"): world.text for name, world in worlds.items()}
    write_study(folder, config, files | method_files(references), SKELETON)
    return config


def opening(page: str) -> str:
    """Return the last line of a run, which names the page to open; empty if it has not been made."""
    return f"Open {page} in a browser.\n" if Path(page).is_file() else ""


def run_name(folder: Path) -> str:
    """Return the name of the run in a new folder; refuse a folder that is in use."""
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise UserError(f"{folder}: exists already; name a folder that is absent or empty")
    return re.sub(r"[^A-Za-z0-9_-]", "_", folder.resolve().name).lstrip("_-") or "study"


def name_in_study(reference: str) -> str:
    """Return how a study names a method: it has a copy of the file."""
    return f"methods/{Path(reference).name}" if reference.endswith(".py") else reference


def method_files(references: Iterable[str]) -> dict[Path, Path]:
    """Return the files of methods that a study has copies of, by their place in its folder."""
    here = Path.cwd()
    kept: dict[Path, Path] = {}
    for reference in references:
        if reference in methods.names() or reference.startswith(("ptl.", "studies.")):
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


def write_study(folder: Path, config: Mapping[str, Any], files: Mapping[Path, Path | str], skeleton: Path) -> None:
    """Copy a skeleton, the profile, and files (or write texts) by their place; fill in the configuration.

    A key in braces in the skeleton's README.md, such as ``{run}``, is replaced by its value.
    """
    sources: dict[Path, Path | str] = dict(files)
    for place, tree in (("", skeleton), ("profiles/default", PROFILE)):
        sources |= {Path(place, path.relative_to(tree)): path for path in tree.rglob("*") if path.is_file()}
    try:
        for name, source in sources.items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            if isinstance(source, str):
                (folder / name).write_text(source, encoding="utf-8", newline="")
            else:
                shutil.copyfile(source, folder / name)
        readme = (folder / "README.md").read_text(encoding="utf-8")
        for key, value in config.items():
            readme = readme.replace(f"{{{key}}}", str(value))
        (folder / "README.md").write_text(readme, encoding="utf-8")
        with (folder / "config/config.yaml").open("a", encoding="utf-8") as file:
            yaml.safe_dump(config, file, sort_keys=False, allow_unicode=True, default_flow_style=None, width=100)
    except OSError as error:
        raise UserError(f"{folder}: cannot be written ({error.strerror}); choose a writable folder") from error


def _environment(stem: str) -> str:
    """Return the name of a map's environment: the file's stem in the letters that names may have."""
    name = re.sub(r"[^a-z0-9_]", "_", stem.lower())
    return name if re.match("[a-z]", name) else f"map_{name}"


def _orders(tasks: Sequence[str], goals: Mapping[str, Sequence[str]]) -> dict[str, str]:
    """Return the tasks of each environment in the order in which they are learned."""
    orders = {name: "".join(letters) for name, letters in goals.items()}
    for given in sorted(tasks, key=lambda given: "=" in given):  # one for every map first
        name, equals, letters = given.rpartition("=")
        if equals and _environment(name) not in orders:
            raise UserError(f"--tasks {given}: no map is called {name!r}; known are {', '.join(orders)}")
        orders |= dict.fromkeys([_environment(name)] if equals else orders, letters)
    for name, letters in orders.items():
        check_tasks(letters, goals[name], f"environments.{name}.tasks")
    return orders
