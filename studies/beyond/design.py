"""From config/beyond.yaml to the jobs of the second study."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import msgspec

from ptl import methods
from ptl.config import PATH, RUN_NAME, TASKS, Name, Parameters, Statistics, check_tasks
from ptl.errors import UserError
from ptl.files.configuration import check_text, read_yaml
from ptl.files.outside import learning_code
from ptl.files.question import READS, Question, asked_jobs, digest_of, lives_code
from ptl.files.schema import LEARNING, LIVES
from ptl.keys import ConfigurationError, Group, key, repeated
from ptl.learning.trial import check_method
from ptl.methods.ptl import Method as PartialTransfer
from ptl.world.gridworld import GridWorld, load_map, map_digest
from ptl.world.mazes import FAMILIES, GOALS
from studies.beyond.methods import module_of, reference
from studies.beyond.population import BANDS, MAPS, POPULATION, SEQUENCES, SIZE, Entry, read_population
from studies.beyond.running import MOVING_AI, Cell, load_moving_ai

MAIN = "increasing"
"""Sequence of tasks of the main comparison, as in the article."""

ARTICLE = "article"
"""Sequence of the article's maps, whose goals are given."""


class ArticleMap(Group, frozen=True, kw_only=True):
    """A map of the article and its tasks."""

    map: Annotated[str, key("Text file of the map.", **PATH)]
    tasks: Annotated[str, key("Goal letters in the order in which they are learned.", **TASKS)]


class Sequences(Group, frozen=True, kw_only=True):
    """Other sequences of tasks, on the first maps of each family."""

    names: Annotated[list[str], key("Sequences beside the increasing one.", wanted="a list of names")] = []  # noqa: RUF012
    methods: Annotated[list[str], key("Methods compared.", wanted="a list of methods")] = []  # noqa: RUF012
    maps: Annotated[int, key("Maps of each family.", ge=1, le=10**5)] = 10


class LibrarySizes(Group, frozen=True, kw_only=True):
    """Libraries of given sizes, on the first maps of each family and on the article's maps."""

    methods: Annotated[list[str], key("Variants of PTL.", wanted="a list of methods")] = []  # noqa: RUF012
    per_task: Annotated[list[int], key("Skills added after each task.", wanted="a list of whole numbers")] = []  # noqa: RUF012
    maps: Annotated[int, key("Maps of each family.", ge=1, le=10**5)] = 10


class Shown(Group, frozen=True, kw_only=True):
    """What the explorer shows: one life of some methods on the first maps of each family."""

    methods: Annotated[list[str], key("Methods; without any there is no explorer.", wanted="a list of methods")] = []  # noqa: RUF012
    maps: Annotated[int, key("Maps of each family.", ge=1, le=100)] = 1


class Study(Parameters, frozen=True, kw_only=True):
    """The second study: maps, methods and effort."""

    run: Annotated[str, key("Name of the run; files go to results/<run>/, products to reports/<run>/.", **RUN_NAME)] = (
        "beyond"
    )
    root_seed: Annotated[int, key("Seed from which every random stream derives.", ge=0, le=2**63 - 1)] = 15
    population: Annotated[str, key("Table of the maps.", **PATH)] = str(POPULATION)
    band: Annotated[Literal["tuning", "test"], key("Band of maps; what is tuned is tuned on the tuning band only.")] = (
        "test"
    )
    size: Annotated[int, key("States of a map, about.", ge=1, le=10**6)] = SIZE
    families: Annotated[list[str], key("Families of maps.", wanted="a list of names")] = msgspec.field(
        default_factory=lambda: list(FAMILIES)
    )
    maps: Annotated[int, key("Maps of each family.", ge=1, le=10**5)] = 100
    seeds: Annotated[int, key("Lives on each map under each method.", ge=1, le=10**5)] = 3
    methods: Annotated[
        list[str],
        key(
            "Methods to compare: identifiers of built-in methods and those of studies/beyond/methods/, files, or"
            " package.module:Class.",
            wanted="a list of methods",
        ),
    ]
    article_maps: Annotated[
        dict[Name, ArticleMap], key("The article's maps, families of one map each.", wanted="names, each with its keys")
    ] = {}  # noqa: RUF012
    article_seeds: Annotated[int, key("Lives on each of the article's maps.", ge=1, le=10**5)] = 30
    moving_ai: Annotated[
        list[str], key("Map files in the Moving AI format, a family of their own.", wanted="a list of paths")
    ] = []  # noqa: RUF012
    foreign_lives: Annotated[
        list[str],
        key(
            "CSV files with the columns of per_life.csv: lives of methods that are not run here, under their names.",
            wanted="a list of paths",
        ),
    ] = []  # noqa: RUF012
    sequences: Sequences = Sequences()
    library_sizes: LibrarySizes = LibrarySizes()
    explorer: Shown = Shown()
    batch: Annotated[int, key("Maps in one job.", ge=1, le=10**5)] = 25
    statistics: Statistics = Statistics()

    def __post_init__(self) -> None:
        super().__post_init__()
        for name, given, known in (
            ("families", self.families, FAMILIES),
            ("sequences.names", self.sequences.names, [s for s in SEQUENCES if s != MAIN]),
            ("sequences.methods", self.sequences.methods, self.methods),
            ("library_sizes.methods", self.library_sizes.methods, self.methods),
            ("explorer.methods", self.explorer.methods, self.methods),
        ):
            for value in given:
                if value not in known:
                    raise ConfigurationError.of_value(name, value, f"one of {', '.join(known)}")
            if twice := repeated(given):
                raise ConfigurationError(name, f"{twice[0]} is repeated; name it once")
        if self.families and (self.band, self.size) not in MAPS:
            sizes = [str(size) for band, size in MAPS if band == self.band]
            raise ConfigurationError.of_value("size", self.size, f"one of {', '.join(sizes)} in the band {self.band}")
        if self.families and self.maps > MAPS[self.band, self.size]:
            raise ConfigurationError.of_value(
                "maps", self.maps, f"at most {MAPS[self.band, self.size]} for size {self.size} in the band {self.band}"
            )
        if any(number < 1 for number in self.library_sizes.per_task):
            raise ConfigurationError.of_value(
                "library_sizes.per_task", self.library_sizes.per_task, "numbers from 1 up"
            )

    @classmethod
    def read(cls, given: Mapping[str, Any]) -> Self:
        """Check a configuration and the methods that it names.

        Raises
        ------
        UserError
            One line that names the key, the value and the constraint.
        """
        if isinstance(maps := given.get("article_maps", {}), Mapping):
            given = {**given, "article_maps": {name: entry for name, entry in maps.items() if entry is not None}}
        study = cls.from_dict(given)
        for name, method in methods.by_identifier(map(reference, study.methods)).items():
            check_method(method)
            check_text(f"methods: label of {name}", methods.load(method).label)
        if not study.methods and not study.foreign_lives:
            raise ConfigurationError("methods", "is empty, and so is foreign_lives; name a method or a file of lives")
        for name in study.library_sizes.methods:
            if not issubclass(methods.load(reference(name)), PartialTransfer):
                raise ConfigurationError.of_value("library_sizes.methods", name, "variants of ptl")
        return study

    @property
    def modules(self) -> list[str]:
        """Modules of the package that give the methods their names and colours."""
        return [name for method in self.methods if (name := module_of(method))]

    @property
    def parameters(self) -> dict[str, Any]:
        """The hyper-parameters of learning, as plain data."""
        return {name: getattr(self, name).to_dict() for name in Parameters.__struct_fields__}


def cells(study: Study) -> Iterator[Cell]:
    """Yield the cells of a study."""
    sizes, others = study.library_sizes, study.sequences
    plans = [(MAIN, study.maps, method, 0) for method in study.methods]
    plans += [(name, others.maps, method, 0) for name in others.names for method in others.methods]
    sized = [(method, number) for method in sizes.methods for number in sizes.per_task]
    plans += [(MAIN, sizes.maps, *variant) for variant in sized]
    first = BANDS[study.band]
    for family in study.families:
        for sequence, maps, method, per_task in plans:
            for batch in range(0, min(maps, study.maps), study.batch):
                seeds: list[int | str] = list(range(first + batch, first + min(batch + study.batch, maps, study.maps)))
                yield Cell(family, study.size, sequence, seeds, study.seeds, method, per_task)
    for method, per_task in [*((method, 0) for method in study.methods), *sized]:
        for family, entry in study.article_maps.items():
            yield Cell(family, 0, ARTICLE, [entry.map], study.article_seeds, method, per_task, entry.tasks)
        for path in study.moving_ai:
            yield Cell(MOVING_AI, 0, MAIN, [path], study.seeds, method, per_task)


def shown(study: Study) -> dict[str, tuple[str, int]]:
    """Return family and seed of each map that the explorer shows, by the name of its file."""
    seeds = range(min(study.explorer.maps, study.maps) if study.explorer.methods else 0)
    places = [(family, BANDS[study.band] + seed) for family in study.families for seed in seeds]
    return {f"{family}_{study.size}_{seed}": (family, seed) for family, seed in places}


def entries_of(study: Study) -> dict[tuple[str, int], Entry]:
    """Return the row of each generated map of a study by family and seed.

    Raises
    ------
    UserError
        When the table lacks a map.
    """
    if not study.families:
        return {}
    rows = {(e.family, e.seed): e for e in read_population(study.population) if e.size == study.size}
    first = BANDS[study.band]
    places = [(family, seed) for family in study.families for seed in range(first, first + study.maps)]
    for place in places:
        if place not in rows:
            raise UserError(
                f"{study.population}: has no map of the family {place[0]}, size {study.size} and seed {place[1]}; run"
                " 'ptl population' to make the table"
            )
    return {place: rows[place] for place in places}


def given_worlds(study: Study) -> dict[str, GridWorld]:
    """Return the maps of a study that are files, by their paths.

    Raises
    ------
    UserError
        When a map cannot be read, or lacks a task.
    """
    found = {}
    for name, entry in study.article_maps.items():
        found[entry.map] = load_map(entry.map)
        check_tasks(entry.tasks, found[entry.map].goals, f"article_maps.{name}.tasks")
    return found | {path: load_moving_ai(path) for path in study.moving_ai}


def map_digests(
    study: Study, entries: Mapping[tuple[str, int], Entry], worlds: Mapping[str, GridWorld]
) -> dict[str, str]:
    """Return a digest of the maps of each cell and of each map that the explorer shows, by its name.

    Parameters
    ----------
    entries, worlds : mapping
        Generated and given maps, as `entries_of` and `given_worlds` return them.
    """
    digests: dict[str, str] = {}
    for cell in cells(study):
        hashes = [
            entries[cell.family, int(place)].hash if cell.size else map_digest(worlds[str(place)].text)
            for place in cell.maps
        ]
        digests[cell.name] = digest_of(*hashes)
    return {**digests, **{name: entries[place].hash for name, place in shown(study).items()}}


def job_of(cell: Cell, study: Study, maps: str) -> dict[str, Any]:
    """Return what one cell's job needs, as plain data.

    Parameters
    ----------
    maps : str
        Digest of its maps.
    """
    return {"cell": asdict(cell), "maps": maps, **_shared(study)}


def _shared(study: Study) -> dict[str, Any]:
    return {"root_seed": study.root_seed, "population": study.population, "parameters": study.parameters}


def question_of(study: Study, maps: Mapping[str, str], codes: Mapping[str, str] | None = None) -> Question:
    """Return what the files of lives, and of those that the explorer shows, must have been made from.

    Parameters
    ----------
    maps : mapping
        Digests, as `map_digests` returns them.
    codes : mapping, optional
        Digest of each method's sources as they are now; without it files by methods from elsewhere may be older.
    """
    jobs = {
        cell.name: {
            "cell": asdict(cell),
            "maps": maps[cell.name],
            **({"code": codes[cell.method]} if codes else {}),
        }
        for cell in cells(study)
    }
    parameters = {name: study.parameters[name] for name in READS[LEARNING]}
    names = list(shown(study))
    return {
        **asked_jobs(LIVES, jobs, **_shared(study)),
        LEARNING: {
            "root_seed": study.root_seed,
            "parameters": parameters,
            "tasks": dict.fromkeys(names, GOALS),
            "maps": {name: maps[name] for name in names},
        },
    }


def report_files(study: Study, lived: Iterable[str]) -> list[str]:
    """Return the names of the files that the study's page comes with.

    Parameters
    ----------
    lived : iterable of str
        Families with lives of other programs.
    """
    tables, numbers = ("costs", "ratios", "improvement", "components"), ("winding_trends", "sequences")
    figures = ["overview", "profiles", "tasks"]
    if any(cell.per_task for cell in cells(study)):
        figures.append("library_size")
    if study.families and (study.methods or {*lived} & {*study.families}):
        figures.append("winding")
    return [
        *(f"{name}.{kind}" for name in tables for kind in ("csv", "html", "md")),
        *(f"{name}.{kind}" for name in figures for kind in ("csv", "png", "svg")),
        *(f"{name}.csv" for name in numbers),
    ]


def method_digest(method: str) -> str:
    """Return a digest of the sources that the lives of a method depend on."""
    if module := module_of(method):
        return lives_code(module)
    return learning_code(method, "studies.beyond.running")


def read_study(path: str | Path) -> Study:
    """Read and check a file such as config/beyond.yaml.

    Raises
    ------
    UserError
        One line that names the file, the key and the remedy.
    """
    content = read_yaml(path)
    try:
        return Study.read(content)
    except ConfigurationError as error:
        raise UserError(f"{path}: {error}") from error
