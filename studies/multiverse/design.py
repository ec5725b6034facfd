"""What the study draws: every quantity that the article leaves open, with its range and the reason for it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from msgspec import Meta, Struct
from scipy.stats import qmc

from ptl.config import PATH, TITLE, Measures, Parameters
from ptl.errors import UserError
from ptl.files.configuration import check_text, read_yaml
from ptl.keys import ConfigurationError, Group, key, text
from ptl.world.drawing import KINDS

PARAMETERS = Parameters.__struct_fields__
GROUPS = (*PARAMETERS, "measures")
"""Groups of the configuration whose keys can be drawn."""

EVERY = "environments"
"""Stands for every environment in the name of an unknown."""

UNKNOWN = text(
    r"[a-z][a-z0-9_]*\.[a-z][a-z0-9_]*(\.[a-z][a-z0-9_]*)?",
    f"group.key of the configuration, or environment.kind or environment.kind.part of a drawing, {EVERY} for each one",
    129,
)
METHOD = text("[a-z][a-z0-9_]*", "the identifier of a method")


class Unknown(Group, frozen=True, kw_only=True):
    """A quantity that the article leaves open."""

    symbol: Annotated[str, key("Name in tables and figures.", **TITLE)]
    reason: Annotated[str, key("Why it is drawn from this range; for readers.", **TITLE)]
    options: Annotated[tuple[Any, ...], key("Values, equally likely.", wanted="a list")] = ()
    range: Annotated[
        tuple[int | float, int | float] | None,
        key("Ends of the range; whole numbers only if both ends are.", wanted="two numbers, the lower first"),
    ] = None
    scale: Annotated[Literal["linear", "log"], key("Scale on which the range is uniform.")] = "linear"

    def __post_init__(self) -> None:
        super().__post_init__()
        if bool(self.range) == bool(self.options):
            raise ConfigurationError("options", "must be given, or else range; give one of the two")
        if self.range and not self.range[0] < self.range[1]:
            raise ConfigurationError.of_value("range", list(self.range), "two numbers, the lower first")
        if self.range and self.scale == "log" and self.range[0] <= 0:
            raise ConfigurationError.of_value("range", list(self.range), "two positive numbers")

    @property
    def numeric(self) -> bool:
        """Whether its values are ordered."""
        return self.range is not None

    def value_at(self, share: float) -> Any:
        """Return the value at a place in [0, 1) of the options or the range."""
        if self.options:
            return self.options[int(share * len(self.options))]
        assert self.range is not None
        low, high = self.range
        whole = isinstance(low, int) and isinstance(high, int)
        if self.scale == "log":
            value = low * (high / low) ** share
        elif whole:  # a whole number has half a unit on both sides, so that the ends are as likely as the rest
            value = low - 0.5 + share * (high - low + 1)
        else:
            value = low + share * (high - low)
        return int(np.clip(round(value), low, high)) if whole else float(f"{value:.4g}")


class Effort(Group, frozen=True, kw_only=True):
    """Runs of one method in a setting."""

    seeds: Annotated[int, key("Learning runs in each environment; verdicts need 10.", ge=1, le=10**5)]
    every: Annotated[int, key("Learned in every n-th setting only.", ge=1, le=10**5)] = 1


class Growth(Group, frozen=True, kw_only=True):
    """Growth of the skill library in a setting."""

    runs: Annotated[int, key("Lives.", ge=1, le=10**5)]
    tasks: Annotated[int, key("Tasks in one life.", ge=2, le=10**5)]
    every: Annotated[int, key("Learned in every n-th setting only.", ge=1, le=10**5)] = 1


class Named(Group, frozen=True, kw_only=True):
    """A setting that is not drawn."""

    title: Annotated[str, key("What it is, for readers.", **TITLE)]
    changes: Annotated[
        dict[Annotated[str, key("", **UNKNOWN)], Any],
        key("Unknowns that differ from the configuration of the run, with their values."),
    ] = {}  # noqa: RUF012 (msgspec copies it)
    maps: Annotated[
        dict[Annotated[str, key("", **METHOD)], Annotated[str, key("", **METHOD)]],
        key("Environments that have another map, one of `maps`."),
    ] = {}  # noqa: RUF012 (msgspec copies it)
    seeds: Annotated[int, key("Learning runs of each method; 0: `named_seeds`.", ge=0, le=10**5)] = 0
    fitted: Annotated[int, key("Choices in it that were made because they fit the claims.", ge=0, le=100)] = 0


class Point(Struct, frozen=True, forbid_unknown_fields=True):
    """One setting.

    Attributes
    ----------
    name : str
        Name of the setting, and of its random streams.
    changes : dict
        Unknowns with their values.
    seeds : dict
        Learning runs in each environment by method.
    growth_runs : int
        Lives of the growing library.
    maps : dict
        Environments that have another map, and its name.
    """

    name: Annotated[str, Meta(pattern=r"^[a-z][a-z0-9_]*$")]
    changes: dict[str, Any]
    seeds: dict[str, int]
    growth_runs: int = 0
    maps: dict[str, str] = {}


class Multiverse(Group, frozen=True, kw_only=True):
    """The study: its effort, its unknowns and its named settings."""

    settings: Annotated[int, key("Settings drawn.", ge=1, le=10**6)]
    seed: Annotated[int, key("Seed of the draw.", ge=0, le=2**63 - 1)]
    block: Annotated[int, key("Settings in one file.", ge=1, le=10**4)]
    step_budget: Annotated[
        int,
        key(
            "Steps for each planned run; a method that has taken those of all of them begins no further run in an"
            " environment.",
            ge=1,
            le=10**10,
        ),
    ]
    methods: Annotated[dict[Annotated[str, key("", **METHOD)], Effort], key("Effort by method.")]
    growth: Growth
    maps: Annotated[
        dict[Annotated[str, key("", **METHOD)], Annotated[str, key("", **PATH)]],
        key("Files of the maps of named settings, by a name that no environment has."),
    ] = {}  # noqa: RUF012 (msgspec copies it)
    named_seeds: Annotated[int, key("Learning runs of each method in a named setting.", ge=1, le=10**5)]
    replicates: Annotated[int, key("Samples of 30 runs drawn from the reference.", ge=1, le=10**5)]
    named: Annotated[dict[Annotated[str, key("", **METHOD)], Named], key("Settings that are not drawn, by name.")]
    unknowns: Annotated[dict[Annotated[str, key("", **UNKNOWN)], Unknown], key("Unknowns by their keys.")]

    def __post_init__(self) -> None:
        super().__post_init__()
        if "reference" not in self.named:
            raise ConfigurationError("named", "has no setting named reference; give one")
        for name, unknown in self.unknowns.items():
            check_text(f"unknowns.{name}.symbol", unknown.symbol)
            ends = unknown.options or unknown.range or ()
            for value in ends:
                _check_value(name, value)

    def named_runs(self, name: str) -> int:
        """Return the runs of each method in a named setting."""
        return self.named[name].seeds or self.named_seeds

    def points(self) -> list[Point]:
        """Return the named settings and then those drawn, a Latin hypercube; their names are fit for files."""
        named = [
            Point(
                name,
                setting.changes,
                dict.fromkeys(self.methods, self.named_runs(name)),
                self.named_runs(name),
                setting.maps,
            )
            for name, setting in self.named.items()
        ]
        sampler = qmc.LatinHypercube(len(self.unknowns), rng=np.random.default_rng(self.seed))
        drawn = [
            Point(
                f"setting_{number:04d}",
                {
                    name: unknown.value_at(share)
                    for (name, unknown), share in zip(self.unknowns.items(), shares, strict=True)
                },
                {method: effort.seeds for method, effort in self.methods.items() if number % effort.every == 0},
                self.growth.runs if number % self.growth.every == 0 else 0,
            )
            for number, shares in enumerate(sampler.random(self.settings))
        ]
        return [*named, *drawn]


def parameters_of(changes: dict[str, Any], base: Parameters) -> Parameters:
    """Return the hyper-parameters of a setting."""
    return base.replace(**{_flat(name): value for name, value in changes.items() if _group(name) in PARAMETERS})


def measures_of(changes: dict[str, Any], base: Measures) -> Measures:
    """Return the settings of the measures in a setting."""
    return base.replace(
        **{name.partition(".")[2]: value for name, value in changes.items() if _group(name) == "measures"}
    )


def drawings_of(changes: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """Return the changes of each map by kind, as `ptl.world.drawing.changed_world` takes them."""
    drawings: dict[str, dict[str, Any]] = {}
    for name, value in changes.items():
        environment, *kind = name.split(".")
        if kind[0] not in KINDS:
            continue
        own = drawings.setdefault(environment, {})
        if len(kind) == 1:
            own[kind[0]] = value
        else:
            own.setdefault(kind[0], {})[kind[1]] = value
    return drawings


def _group(name: str) -> str:
    return name.partition(".")[0]


def _flat(name: str) -> str:
    return name.replace(".", "__")


def _check_value(name: str, value: Any) -> None:
    """Refuse a value that the configuration does not allow; drawings are checked when they are made."""
    group = _group(name)
    try:
        if group in PARAMETERS:
            Parameters().replace(**{_flat(name): value})
        elif group == "measures":
            Measures().replace(**{name.partition(".")[2]: value})
        elif name.split(".")[1] not in KINDS:
            raise ConfigurationError(name, f"is neither a key of {', '.join(GROUPS)} nor a drawing")
    except ConfigurationError as error:
        raise ConfigurationError(f"unknowns.{error.key}", error.problem) from None


def read_study(path: str | Path) -> Multiverse:
    """Read and check the study's file.

    Raises
    ------
    UserError
        One line that names the file, the key and the remedy.
    """
    content = read_yaml(path)
    try:
        return Multiverse.from_dict(content)
    except ConfigurationError as error:
        raise UserError(f"{path}: {error}") from error
