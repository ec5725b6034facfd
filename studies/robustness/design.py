"""From the study's file to the points that it tries.

Three groups of points: ``reference`` (replicates of the run's own configuration with other random numbers),
``one_at_a_time`` (a single unknown moved to each of its values) and ``latin_hypercube`` (all at once).
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Final, Literal

import numpy as np

from ptl.config import TITLE, Parameters
from ptl.errors import UserError
from ptl.files.configuration import check_text, read_yaml
from ptl.keys import ConfigurationError, Group, key, text
from ptl.world.drawing import KINDS

REFERENCE: Final = "reference"
ONE_AT_A_TIME: Final = "one_at_a_time"
LATIN_HYPERCUBE: Final = "latin_hypercube"
GROUPS = (REFERENCE, ONE_AT_A_TIME, LATIN_HYPERCUBE)
GroupName = Literal["reference", "one_at_a_time", "latin_hypercube"]

UNKNOWN = text(
    r"[a-z][a-z0-9_]*\.[a-z][a-z0-9_]*", "group.key of a hyper-parameter or environment.kind of a change of map", 129
)


# -- the study's file


class Unknown(Group, frozen=True, kw_only=True):
    """A choice that the article leaves open: a hyper-parameter, or a change of map (`ptl.world.drawing`)."""

    symbol: Annotated[str, key("Name in tables and figures.", **TITLE)]
    values: Annotated[tuple[Any, ...], key("Values tried one at a time.", wanted="a list")] = ()
    options: Annotated[tuple[Any, ...], key("Values in the Latin hypercube, equally likely.", wanted="a list")] = ()
    range: Annotated[
        tuple[int | float, int | float] | None,
        key(
            "Ends of the range in the Latin hypercube; whole numbers only if both ends are.",
            wanted="two numbers, the lower first",
        ),
    ] = None
    scale: Annotated[Literal["linear", "log"], key("Scale of the range.")] = "linear"
    candidates: Annotated[
        dict[str, Any] | None, key("How the values were found; for readers.", wanted="keys and values")
    ] = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.range and self.options:
            raise ConfigurationError("range", "is given beside options; keep one of them")
        if self.range and not self.range[0] < self.range[1]:
            raise ConfigurationError.of_value("range", list(self.range), "two numbers, the lower first")
        if self.range and self.logarithmic and self.range[0] <= 0:
            raise ConfigurationError.of_value("range", list(self.range), "two positive numbers")

    @property
    def logarithmic(self) -> bool:
        """Whether the range has a logarithmic scale."""
        return self.scale == "log"

    @property
    def points(self) -> list[Any]:
        """All values that are named: those tried one at a time, the options and the ends of the range."""
        return [*self.values, *self.options, *(self.range or ())]

    def value_at(self, share: float) -> Any:
        """Return the value at a place in [0, 1) of the options or the range."""
        if self.options:
            return self.options[int(share * len(self.options))]
        assert self.range is not None
        low, high = self.range
        whole = isinstance(low, int) and isinstance(high, int)
        if self.logarithmic:
            value = low * (high / low) ** share
        elif whole:  # a whole number has half a unit on both sides, so that the ends are as likely as the rest
            value = low - 0.5 + share * (high - low + 1)
        else:
            value = low + share * (high - low)
        return int(np.clip(round(value), low, high)) if whole else float(f"{value:.4g}")


class GrowthEffort(Group, frozen=True, kw_only=True):
    """Growth of the skill library in each setting; the rest is as in the run."""

    tasks: Annotated[int, key("Tasks in one life.", ge=2, le=10**5)]
    runs: Annotated[int, key("Lives.", ge=1, le=10**5)]


class LatinHypercube(Group, frozen=True, kw_only=True):
    """Settings in which all unknowns vary at once."""

    settings: Annotated[int, key("Number of settings.", ge=0, le=10**5)]
    seed: Annotated[int, key("Seed of their draw.", ge=0, le=2**63 - 1)]


class Robustness(Group, frozen=True, kw_only=True):
    """The robustness study: its unknowns and its effort."""

    seeds: Annotated[int, key("Learning runs per environment and method in each setting.", ge=1, le=10**5)]
    replicates: Annotated[int, key("Settings that differ in their random numbers only.", ge=1, le=10**5)]
    max_steps: Annotated[int, key("learning.max_steps of each setting.", ge=1, le=10**12)]
    step_budget: Annotated[
        int, key("Steps after which a method is given up in an environment of a setting.", ge=1, le=10**15)
    ]
    growth: GrowthEffort
    latin_hypercube: LatinHypercube
    unknowns: Annotated[dict[Annotated[str, key("", **UNKNOWN)], Unknown], key("Unknowns by their keys.")]

    def __post_init__(self) -> None:
        super().__post_init__()
        named: dict[str, str] = {}
        for name, unknown in self.unknowns.items():
            check_text(f"unknowns.{name}.symbol", unknown.symbol)
            for value in unknown.values:
                file = f"{name}_{_file_part(value)}"
                if file in named:
                    raise ConfigurationError(
                        f"unknowns.{name}.values", f"{value} and {named[file]} share the name {file}; keep one of them"
                    )
                named[file] = str(value)
            group, _, last = name.partition(".")
            if last in KINDS:
                continue
            for value in unknown.points:
                try:
                    Parameters().replace(**{f"{group}__{last}": value})
                except ConfigurationError as error:
                    raise ConfigurationError(f"unknowns.{error.key}", error.problem) from None

    def points(self) -> list["Point"]:
        """Return all points; the names are fit for files."""
        return [
            *(Point(f"reference_{number}", REFERENCE) for number in range(1, self.replicates + 1)),
            *(
                Point(f"{name}_{_file_part(value)}", ONE_AT_A_TIME, {name: value})
                for name, unknown in self.unknowns.items()
                for value in unknown.values
            ),
            *self._hypercube(),
        ]

    def _hypercube(self) -> Iterator["Point"]:
        if not self.latin_hypercube.settings:
            return
        from scipy.stats import qmc

        varied = {name: unknown for name, unknown in self.unknowns.items() if unknown.options or unknown.range}
        sampler = qmc.LatinHypercube(len(varied), rng=np.random.default_rng(self.latin_hypercube.seed))
        for number, point in enumerate(sampler.random(self.latin_hypercube.settings), start=1):
            changes = {
                name: unknown.value_at(share) for (name, unknown), share in zip(varied.items(), point, strict=True)
            }
            yield Point(f"hypercube_{number:03d}", LATIN_HYPERCUBE, changes)


@dataclass(frozen=True)
class Point:
    """One point of the study: a name, its group and the changed unknowns with their values."""

    name: str
    group: GroupName
    changes: dict[str, Any] = field(default_factory=dict)


def _file_part(value: Any) -> str:
    if isinstance(value, dict):
        return "_".join(f"{_file_part(name)}_{_file_part(part)}" for name, part in value.items())
    parts = value if isinstance(value, list) else [value]
    return "_".join(re.sub(r"[^a-z0-9.]+|\.\.+", "_", str(part).lower()) for part in parts)


def read_study(path: str | Path) -> Robustness:
    """Read and check the study's file.

    Raises
    ------
    UserError
        One line that names the file, the key and the remedy.
    """
    content = read_yaml(path)
    try:
        return Robustness.from_dict(content)
    except ConfigurationError as error:
        raise UserError(f"{path}: {error}") from error
