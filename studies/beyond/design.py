"""The configuration of the second study."""

import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import msgspec

from ptl import methods
from ptl.config import PATH, RUN_NAME, TASKS, Name, Parameters, Statistics
from ptl.errors import UserError
from ptl.files.configuration import check_text, read_yaml
from ptl.keys import ConfigurationError, Group, key, repeated, shortened
from ptl.learning.trial import check_method
from ptl.methods.ptl import Method as PartialTransfer
from ptl.world.mazes import FAMILIES
from studies.beyond.changes import RULES
from studies.beyond.maps import MAIN, RETURNING, SEQUENCES
from studies.beyond.methods import module_of, reference
from studies.beyond.population import BANDS, MAPS, SIZE

Slip = Annotated[float, key("", gt=0, le=1)]

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


class Harder(Group, frozen=True, kw_only=True):
    """Worlds in which a remembered model may be wrong: steps slip, or the map changes between tasks."""

    slips: Annotated[
        list[Slip], key("Probabilities of a slip, each a world of its own.", wanted="a list of numbers")
    ] = []  # noqa: RUF012
    changes: Annotated[list[str], key("Rules by which maps change.", wanted="a list of names")] = []  # noqa: RUF012
    methods: Annotated[list[str], key("Methods compared.", wanted="a list of methods")] = []  # noqa: RUF012
    maps: Annotated[int, key("Maps of each family.", ge=1, le=10**5)] = 10
    article_seeds: Annotated[int, key("Lives on each of the article's maps.", ge=1, le=10**5)] = 10


class Returning(Group, frozen=True, kw_only=True):
    """Lives that end with the first task once more, on the first maps of each family and on the article's maps."""

    methods: Annotated[list[str], key("Methods compared.", wanted="a list of methods")] = []  # noqa: RUF012
    maps: Annotated[int, key("Maps of each family.", ge=1, le=10**5)] = 10
    seeds: Annotated[int, key("Lives on each map.", ge=1, le=10**5)] = 3
    article_seeds: Annotated[int, key("Lives on each of the article's maps.", ge=1, le=10**5)] = 10


class Shown(Group, frozen=True, kw_only=True):
    """What the explorer shows: one life of some methods on the first maps of each family."""

    methods: Annotated[list[str], key("Methods; without any there is no explorer.", wanted="a list of methods")] = []  # noqa: RUF012
    maps: Annotated[int, key("Maps of each family.", ge=1, le=100)] = 1


class SecondStudy(Parameters, frozen=True, kw_only=True):
    """The second study: maps, methods and effort."""

    run: Annotated[str, key("Name of the run; files go to results/<run>/, products to reports/<run>/.", **RUN_NAME)] = (
        "beyond"
    )
    root_seed: Annotated[int, key("Seed from which every random stream derives.", ge=0, le=2**63 - 1)] = 15
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
    harder: Harder = Harder()
    returning: Returning = Returning()
    explorer: Shown = Shown()
    batch: Annotated[int, key("Maps in one job.", ge=1, le=10**5)] = 25
    statistics: Statistics = Statistics()

    def __post_init__(self) -> None:
        super().__post_init__()
        for name, given, known in (
            ("families", self.families, FAMILIES),
            ("sequences.names", self.sequences.names, [s for s in SEQUENCES if s not in (MAIN, RETURNING)]),
            ("sequences.methods", self.sequences.methods, self.methods),
            ("library_sizes.methods", self.library_sizes.methods, self.methods),
            ("harder.changes", self.harder.changes, RULES),
            ("harder.methods", self.harder.methods, self.methods),
            ("returning.methods", self.returning.methods, self.methods),
            ("explorer.methods", self.explorer.methods, self.methods),
        ):
            for value in given:
                if value not in known:
                    raise ConfigurationError.of_value(name, value, f"one of {', '.join(known)}")
            if twice := repeated(given):
                raise ConfigurationError(name, f"{twice[0]} is repeated; name it once")
        for path in self.moving_ai:
            if not re.fullmatch("[A-Za-z0-9_][A-Za-z0-9_.-]*", Path(path).stem):
                raise ConfigurationError.of_value("moving_ai", path, "a file called by letters, digits, _, - and .")
        if "moving_ai" in self.article_maps:
            raise ConfigurationError("article_maps", "moving_ai is the name of another family; give another name")
        if twice := repeated([Path(path).stem for path in self.moving_ai]):
            raise ConfigurationError("moving_ai", f"two maps are called {twice[0]}; rename one of the files")
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
            kind = methods.load(method)
            check_text(f"methods: label of {name}", kind.label)
            knows = getattr(kind, "knows", ("", "", ""))
            if not (isinstance(knows, tuple) and len(knows) == 3 and all(isinstance(text, str) for text in knows)):
                raise UserError(f"method {name}: knows = {shortened(repr(knows))} is not allowed; give three texts")
        if not study.methods and not study.foreign_lives:
            raise ConfigurationError("methods", "is empty, and so is foreign_lives; name a method or a file of lives")
        for name in study.library_sizes.methods:
            if not issubclass(methods.load(reference(name)), PartialTransfer):
                raise ConfigurationError.of_value("library_sizes.methods", name, "variants of ptl")
        return study

    @property
    def is_harder(self) -> bool:
        """Whether methods are compared in worlds that slip or change."""
        return bool(self.harder.methods and (self.harder.slips or self.harder.changes))

    @property
    def returns(self) -> bool:
        """Whether methods are sent back to the first task on some map."""
        return bool(self.returning.methods and (self.families or self.article_maps))

    @property
    def modules(self) -> list[str]:
        """Modules of the package that give the methods their names and colours."""
        return [name for method in self.methods if (name := module_of(method))]

    @property
    def seeds_of_maps(self) -> range:
        """Seeds of the maps of each family."""
        first = BANDS[self.band]
        return range(first, first + self.maps)

    def groups(self, names: tuple[str, ...]) -> dict[str, dict[str, Any]]:
        """Return groups of hyper-parameters as plain data."""
        return {name: getattr(self, name).to_dict() for name in names}


def report_files(study: SecondStudy, lived: Iterable[str]) -> list[str]:
    """Return the names of the files that the study's page comes with.

    Parameters
    ----------
    lived : iterable of str
        Families with lives of other programs.
    """
    tables, numbers = ["costs", "ratios", "improvement", "components", "sequences"], []
    figures = ["strip", "overview", "profiles", "tasks"]
    sizes = study.library_sizes
    if sizes.methods and sizes.per_task and (study.families or study.article_maps or study.moving_ai):
        figures.append("library_size")
    if study.families and (study.methods or {*lived} & {*study.families}):
        figures.append("hardness")
        tables.append("hardness_trends")
    if study.returns:
        tables.append("lifelong")
    if study.is_harder:
        tables.append("harder")
        numbers.append("per_life_harder")
        figures.append("slips")
    return [
        *(f"{name}.{kind}" for name in tables for kind in ("csv", "html", "md")),
        *(f"{name}.{kind}" for name in figures for kind in ("csv", "png", "svg")),
        *(f"{name}.csv" for name in numbers),
    ]


def read_study(path: str | Path) -> SecondStudy:
    """Read and check the file of a study.

    Raises
    ------
    UserError
        One line that names the file, the key and the remedy.
    """
    content = read_yaml(path)
    try:
        return SecondStudy.read(content)
    except ConfigurationError as error:
        raise UserError(f"{path}: {error}") from error
