"""From config/robustness.yaml to the settings of the study.

Three groups of settings: ``reference`` (replicates of the run's own configuration with other random numbers),
``one_at_a_time`` (a single unknown moved to each of its values) and ``latin_hypercube`` (all at once).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
import yaml

from ptl.errors import UserError
from ptl.parameters import Parameters
from ptl.robustness.worlds import KINDS

REFERENCE, ONE_AT_A_TIME, LATIN_HYPERCUBE = "reference", "one_at_a_time", "latin_hypercube"
GROUPS = (REFERENCE, ONE_AT_A_TIME, LATIN_HYPERCUBE)

STUDY_KEYS = ("seeds", "replicates", "max_steps", "step_budget", "growth", "latin_hypercube", "unknowns")
UNKNOWN_KEYS = ("symbol", "values", "range", "scale", "options", "candidates")


@dataclass(frozen=True)
class Unknown:
    """Something that the article leaves open.

    Attributes
    ----------
    key : str
        ``group.key`` of a hyper-parameter, or ``environment.kind`` of a change of map
        (`ptl.robustness.worlds`).
    symbol : str
        How tables and figures call it.
    values : tuple
        Tried one at a time.
    options : tuple
        Equally likely in the Latin hypercube, or empty if ``low`` and ``high`` are given.
    low, high : float or None
        Ends of the range in the Latin hypercube.
    logarithmic, whole : bool
        Scale of the range, and whether it has whole numbers only.
    """

    key: str
    symbol: str
    values: tuple[Any, ...]
    options: tuple[Any, ...] = ()
    low: float | None = None
    high: float | None = None
    logarithmic: bool = False
    whole: bool = False

    def value_at(self, share: float) -> Any:
        """Value at a place in [0, 1) of the options or the range."""
        if self.options:
            return self.options[int(share * len(self.options))]
        assert self.low is not None and self.high is not None
        # a whole number owns half a unit on both sides, so that the ends are as likely as the rest
        low, high = (self.low - 0.5, self.high + 0.5) if self.whole and not self.logarithmic else (self.low, self.high)
        value = low * (high / low) ** share if self.logarithmic else low + share * (high - low)
        return int(np.clip(round(value), self.low, self.high)) if self.whole else float(f"{value:.4g}")


@dataclass(frozen=True)
class Setting:
    """One point of the study: a name, its group and the changed unknowns with their values."""

    name: str
    group: str
    changes: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Study:
    """What is varied and with what effort; attributes as in config/robustness.yaml."""

    unknowns: dict[str, Unknown]
    seeds: int
    replicates: int
    max_steps: int
    step_budget: int
    growth: dict[str, int]
    hypercube_settings: int
    hypercube_seed: int

    def settings(self) -> list[Setting]:
        """All settings; the names are fit for files."""
        settings = [Setting(f"reference_{number}", REFERENCE) for number in range(1, self.replicates + 1)]
        for unknown in self.unknowns.values():
            settings += [
                Setting(f"{unknown.key}_{_file_part(value)}", ONE_AT_A_TIME, {unknown.key: value})
                for value in unknown.values
            ]
        return settings + self._hypercube()

    def _hypercube(self) -> list[Setting]:
        if not self.hypercube_settings:
            return []
        from scipy.stats import qmc

        varied = [unknown for unknown in self.unknowns.values() if unknown.options or unknown.low is not None]
        sampler = qmc.LatinHypercube(len(varied), rng=np.random.default_rng(self.hypercube_seed))
        return [
            Setting(
                f"hypercube_{number:03d}",
                LATIN_HYPERCUBE,
                {unknown.key: unknown.value_at(share) for unknown, share in zip(varied, point, strict=True)},
            )
            for number, point in enumerate(sampler.random(self.hypercube_settings), start=1)
        ]


def _file_part(value: Any) -> str:
    parts = value if isinstance(value, list | tuple) else [value]
    return "_".join(str(part).lower() for part in parts)


# -- reading -------------------------------------------------------------------------------------------------


def read_study(path: str | Path) -> Study:
    """Read and check config/robustness.yaml.

    Raises
    ------
    UserError
        Naming the file, the key and the remedy.
    """
    path = Path(path)
    try:
        content = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise UserError(f"{path}: cannot be read as YAML ({str(error).splitlines()[0]}); correct the file") from error
    try:
        return study_from(content)
    except UserError as error:
        raise UserError(f"{path}: {error}") from error


def study_from(content: Any) -> Study:
    """A study from the content of its file."""
    _only(content, STUDY_KEYS, "the study")
    for key in STUDY_KEYS:
        if key not in content:
            raise UserError(f"key {key} is missing; add it")
    growth, hypercube = content["growth"], content["latin_hypercube"]
    _only(growth, ("tasks", "runs"), "growth")
    _only(hypercube, ("settings", "seed"), "latin_hypercube")
    _mapping(content["unknowns"], "unknowns")
    unknowns = {key: _unknown(key, entry) for key, entry in content["unknowns"].items()}
    return Study(
        unknowns,
        seeds=_whole(content, "seeds", 1),
        replicates=_whole(content, "replicates", 1),
        max_steps=_whole(content, "max_steps", 1),
        step_budget=_whole(content, "step_budget", 1),
        growth={"tasks": _whole(growth, "tasks", 2, "growth."), "runs": _whole(growth, "runs", 1, "growth.")},
        hypercube_settings=_whole(hypercube, "settings", 0, "latin_hypercube."),
        hypercube_seed=_whole(hypercube, "seed", 0, "latin_hypercube."),
    )


def _unknown(key: str, entry: Any) -> Unknown:
    _only(entry, UNKNOWN_KEYS, f"unknowns.{key}")
    group, dot, name = key.partition(".")
    if not (group and dot and name):
        raise UserError(f"key unknowns.{key}: is not of the form group.key; name a hyper-parameter or a change of map")
    for name_of_list in ("values", "options"):
        if not isinstance(entry.get(name_of_list, []), list):
            raise UserError(f"key unknowns.{key}.{name_of_list}: {entry[name_of_list]!r} is not a list; give one")
    values, options = tuple(entry.get("values", ())), tuple(entry.get("options", ()))
    scale = entry.get("scale", "linear")
    if scale not in ("linear", "log"):
        raise UserError(f"key unknowns.{key}.scale: {scale!r} is not allowed; give linear or log")
    low = high = None
    if "range" in entry:
        low, high = _range(key, entry["range"], positive=scale == "log")
    if options and low is not None:
        raise UserError(f"key unknowns.{key}: has a range and options; keep one of them")
    if name not in KINDS:
        for value in (*values, *options, *(() if low is None else (low, high))):
            # refuses unknown names and values that the learner would refuse
            Parameters().replace(**{f"{group}__{name}": value})
    whole = isinstance(low, int) and isinstance(high, int)
    symbol = str(entry.get("symbol", key))
    return Unknown(key, symbol, values, options, low, high, logarithmic=scale == "log", whole=whole)


def _range(key: str, ends: Any, positive: bool) -> tuple[float, float]:
    numbers = isinstance(ends, list) and len(ends) == 2 and all(type(end) in (int, float) for end in ends)
    if not numbers or not ends[0] < ends[1] or (positive and ends[0] <= 0):
        wanted = "two positive numbers" if positive else "two numbers"
        raise UserError(f"key unknowns.{key}.range: {ends!r} is not allowed; give {wanted}, the lower first")
    return ends[0], ends[1]


def _only(given: Any, known: Sequence[str], where: str) -> None:
    _mapping(given, where)
    for key in given:
        if key not in known:
            raise UserError(f"{where}: unknown key {key!r}; known are {', '.join(known)}")


def _mapping(given: Any, where: str) -> None:
    if not isinstance(given, Mapping):
        raise UserError(f"{where}: give keys and values, not {given!r}")


def _whole(given: Mapping[str, Any], key: str, least: int, prefix: str = "") -> int:
    value = given.get(key)
    if type(value) is not int or value < least:
        raise UserError(f"key {prefix}{key}: {value!r} is not allowed; give a whole number of at least {least}")
    return value


# -- jobs ----------------------------------------------------------------------------------------------------


def job_of(setting: Setting, study: Study, config: Mapping[str, Any]) -> dict[str, Any]:
    """All that one setting's job needs, as plain data: what the command line of a job carries.

    Parameters
    ----------
    config : mapping
        The configuration of the run, which gives all that the study does not change.
    """
    environments = {
        name: {"map": entry["map"], "tasks": entry["tasks"], "changes": {}}
        for name, entry in config["environments"].items()
    }
    parameters = {group: dict(config[group]) for group in ("learning", "skills", "subgoals", "policy_reuse")}
    parameters["learning"]["max_steps"] = study.max_steps
    for key, value in setting.changes.items():
        group, _, name = key.partition(".")
        if name not in KINDS:
            parameters[group][name] = value
        elif group in environments:
            environments[group]["changes"][name] = value
        else:
            raise UserError(f"unknowns.{key}: environment {group} is not in this run ({', '.join(environments)})")
    return {
        "setting": setting.name,
        "group": setting.group,
        "changes": setting.changes,
        "environments": environments,
        "methods": list(config["methods"]),
        "seeds": study.seeds,
        "root_seed": config["root_seed"],
        "parameters": parameters,
        "step_budget": study.step_budget,
        "growth": {"environment": config["growth"]["environment"], **study.growth},
    }


class StudyJobs:
    """The jobs of a study's settings for the workflow, made when they are first asked for.

    Parameters
    ----------
    path : path
        The study's file.
    config : mapping
        The configuration of the run.
    refuse : function
        Called with the UserError of a study that cannot be read; does not return.
    """

    def __init__(self, path: str | Path, config: Mapping[str, Any], refuse: Callable[[UserError], NoReturn]) -> None:
        self._path = path
        self._config = config
        self._refuse = refuse

    @cached_property
    def by_name(self) -> dict[str, dict[str, Any]]:
        """The job of every setting by the setting's name, in the order of the study."""
        try:
            study = read_study(self._path)
            return {setting.name: job_of(setting, study, self._config) for setting in study.settings()}
        except UserError as error:
            self._refuse(error)
