"""What result files hold: each group, array and attribute of each kind of file, declared once.

`ptl.files.hdf5` holds every file against these declarations when it is written and whenever it is read, before the
values are used; the tables of ``docs/file-format.md`` and the bad files of the tests are made from them.

Shapes and ranges are given by sizes: ``n`` is the number of states of the map in the file and ``e`` that of episodes in
its parameters. Other sizes are whatever the file says, but the same wherever they occur in a group and the groups in
it. ``n - 1`` and ``e + 1`` are meant as they are read.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Literal

import numpy as np

from ptl.config import Parameters
from ptl.errors import UserError
from ptl.world.gridworld import MAX_BYTES as LONGEST_MAP
from ptl.world.gridworld import GridWorld

LEARNING, GROWTH, FREQUENCIES = "ptl-learning/1", "ptl-growth/1", "ptl-frequencies/1"
STEPS, GAIN, SETTING, FIT = "ptl-steps/1", "ptl-gain/1", "ptl-robustness/1", "ptl-fit/1"
LIVES = "ptl-lives/1"
"""Values of the root attribute ``format``, which says what a file is."""

MOST_BYTES = 2**31
"""Most bytes of a file and of all arrays in it; more is not read."""

DEEPEST = 20
"""Levels of nesting in JSON."""

LONGEST_JSON = 10**6
LONGEST_TEXT = 10_000
LARGEST = 2**63 - 1

Limit = int | float | str | None
Sizes = Mapping[str, int]
Content = Literal["text", "word", "name", "digest", "map", "json", "int", "float"]


@dataclass(frozen=True)
class Attribute:
    """An attribute of a group.

    Attributes
    ----------
    name : str
    content : str
        ``text`` (one printable line), ``word`` (an identifier), ``name`` (of a setting), ``digest``, ``map``, ``json``
        (an object), ``int`` or ``float``.
    meaning : str
        For the documentation.
    low, high : number, str or None
        Range of numbers, ends included; a str is a size.
    shape : tuple
        Sizes; most attributes are single values.
    keys : mapping
        Of JSON: types of keys that the object must have; the key "" stands for all its values.
    optional : bool
        Optional attributes and arrays of a group are there together or not at all.
    """

    name: str
    content: Content
    meaning: str
    low: Limit = None
    high: Limit = None
    shape: tuple[str | int, ...] = ()
    keys: Mapping[str, type] | None = None
    optional: bool = False

    @property
    def dtype(self) -> str:
        """NumPy's name of the type of numbers; empty for text."""
        return {"int": "int64", "float": "float64"}.get(self.content, "")


@dataclass(frozen=True)
class Array:
    """An array in a group; floats must be finite. Fields as in `Attribute`; ``bytes`` is text of a fixed length."""

    name: str
    dtype: str
    shape: tuple[str | int, ...]
    meaning: str
    low: Limit = None
    high: Limit = None
    optional: bool = False


@dataclass(frozen=True)
class Group:
    """A group; a name in angle brackets stands for one or more groups or arrays that are named freely."""

    name: str
    meaning: str
    attributes: tuple[Attribute, ...] = ()
    arrays: tuple[Array, ...] = ()
    groups: tuple[Group, ...] = ()
    optional: bool = False

    def member(self, name: str) -> Group | Array | None:
        """Return the declaration of what has this name in the group, None if there is none."""
        members: tuple[Group | Array, ...] = (*self.groups, *self.arrays)
        exact = [member for member in members if member.name == name]
        free = [member for member in members if member.name.startswith("<") and WORD.fullmatch(name)]
        return next(iter(exact + free), None)


@dataclass(frozen=True)
class Kind:
    """A kind of file: its root attribute ``format``, what it is, where it lies, and its content."""

    format: str
    title: str
    place: str
    root: Group


CONTROL = re.compile(r"[\x00-\x09\x0b-\x1f\x7f-\x9f\ud800-\udfff]")
"""Characters that JSON of ours never holds; maps have line ends."""

WORD = re.compile(r"[A-Za-z0-9_]{1,64}")
PATTERNS: dict[str, re.Pattern[str]] = {
    "word": re.compile(r"[a-z][a-z0-9_]{0,63}"),
    "name": re.compile(r"[a-z0-9_.]{1,200}"),
    "digest": re.compile(r"[0-9a-f]{16}"),
}


# -- declarations -------------------------------------------------------------------------------------------------

_ENVIRONMENT = Attribute("environment", "word", "name of the environment")
_METHOD = Attribute("method", "word", "identifier of the method")
_ROOT_SEED = Attribute("root_seed", "int", "seed from which all random streams derive", 0)
_PARAMETERS = Attribute("parameters", "json", "all hyper-parameters")
_MAP = Attribute("map", "map", "text of the map")
_CODE = Attribute("code", "digest", "digest of the sources that made the file")
_VERSIONS = Attribute("versions", "json", "versions of ptl, numpy and h5py", keys={"": str})
_SEED = Attribute("seed", "int", "number of the seed or life", 0)
_ORIGIN = (_ENVIRONMENT, _METHOD, _SEED, _ROOT_SEED, _PARAMETERS, _MAP, _CODE, _VERSIONS)


def _state(name: str, meaning: str) -> Attribute:
    return Attribute(name, "int", meaning, 0, "n - 1")


_LIBRARY = Group(
    "library",
    "the library after the last task, $k$ skills",
    arrays=(
        Array("subgoals", "int32", ("k",), "state that each skill leads to", 0, "n - 1"),
        Array("policies", "int8", ("k", "n"), "action of each skill in each state, −1 where undefined", -1, 3),
        Array("learned_after", "int32", ("k",), "index of the task after which it was added", 0),
    ),
)

_TASK = Group(
    "<task>",
    "one task",
    attributes=(
        _state("start", "state where episodes begin"),
        _state("goal", "state where they end"),
        Attribute("subgoal", "int", "state of the skill added after the task, −1 if none", -1, "n - 1"),
        Attribute("reason", "text", "why it was added, or why not"),
        Attribute("novelty", "float", "mean length of the unknown rests of the paths", 0),
        Attribute("diameter", "int", "$D$, longest shortest path between visited states", 0, "n"),
    ),
    arrays=(
        Array("q", "float64", ("n", 4), "action values after the last episode"),
        Array("seen", "uint8", ("n",), "bit a is set if action a was taken in the state in this task", 0, 15),
        Array("steps", "int64", ("e",), "steps of each episode, guided ones included", 0),
        Array("truncated", "bool", ("e",), "whether the episode ran into the step limit"),
        Array("selected", "int32", ("m",), "skills or arms drawn, episode after episode", 0),
        Array("selected_offsets", "int64", ("e + 1",), "limits of each episode's draws in `selected`", 0, "m"),
        Array("original", "float64", ("n",), "original metric, frequency times distance", 0, 1),
        Array("incremental", "float64", ("n",), "the same on the unknown rests of the paths", 0, 1),
    ),
)

_LIVES = (
    Array("seeds", "int64", ("s",), "seeds, in the order of the rows", 0),
    Array("steps", "int64", ("s", "t", "e"), "steps of each task and episode", 0),
    Array("truncated", "int64", ("s", "t"), "episodes that hit the step limit", 0, "e"),
    Array("subgoal", "int64", ("s", "t"), "state added to the library, −1 if none", -1, optional=True),
    Array("novelty", "float64", ("s", "t"), "mean length of the unknown rests of the paths", 0, optional=True),
    Array("metric_value", "float64", ("s", "t"), "greatest value of the incremental metric", 0, 1, optional=True),
    Array("reason", "bytes", ("s", "t"), "why a state was added, or why not", optional=True),
    Array("incremental_peak", "int64", ("s", "t"), "state where the incremental metric is greatest", -1, optional=True),
    Array("original_peak", "int64", ("s", "t"), "state where the original metric is greatest", -1, optional=True),
)

_GROWN = Group(
    "growth",
    "lives of random tasks",
    arrays=(Array("library_size", "int64", ("r", "g"), "skills after 0, 1, ... tasks of each life", 0),),
    optional=True,
)

KINDS = {
    kind.format: kind
    for kind in (
        Kind(
            LEARNING,
            "Learning files",
            "learning/<environment>/<method>/seed_<NNN>.h5",
            Group(
                "/",
                "one learner's life: all tasks in order",
                attributes=_ORIGIN,
                groups=(
                    Group("tasks", "the tasks, in the order in which they were learned", groups=(_TASK,)),
                    Group(
                        _LIBRARY.name,
                        f"{_LIBRARY.meaning}; only with methods that keep one",
                        arrays=_LIBRARY.arrays,
                        optional=True,
                    ),
                ),
            ),
        ),
        Kind(
            GROWTH,
            "Growth files",
            "growth/run_<NNN>.h5",
            Group(
                "/",
                "one life of many random tasks",
                attributes=_ORIGIN,
                arrays=(
                    Array("starts", "int32", ("t",), "start of each task", 0, "n - 1"),
                    Array("goals", "int32", ("t",), "goal of each task", 0, "n - 1"),
                    Array("library_size", "int64", ("t + 1",), "skills before the first task and after each", 0, "t"),
                    Array("total_steps", "int64", ("t",), "steps of all episodes of each task", 0),
                ),
                groups=(_LIBRARY,),
            ),
        ),
        Kind(
            FREQUENCIES,
            "Frequency files",
            "subgoal_frequencies/<environment>.h5",
            Group(
                "/",
                "subgoals over all pairs of start and goal",
                attributes=(
                    _ENVIRONMENT,
                    Attribute("trajectories", "int", "successful episodes of each task", 1),
                    Attribute("starts", "int", "start states", 1),
                    Attribute("batch", "int", "number of the batch, in a file of some of the goals", 0, optional=True),
                    Attribute("batches", "int", "batches in all, in the same files", 1, optional=True),
                    _ROOT_SEED,
                    _PARAMETERS,
                    _MAP,
                    _CODE,
                    _VERSIONS,
                ),
                arrays=(
                    Array("counts", "int64", ("n",), "pairs of start and goal whose subgoal is the state", 0),
                    Array("unresolved", "int64", (), "pairs whose metric is 0 everywhere (adjacent cells)", 0),
                    Array("pairs", "int64", (), "pairs in all", 0),
                    Array("simulated_steps", "int64", (), "steps simulated, a small part of all steps", 0),
                ),
            ),
        ),
        Kind(
            STEPS,
            "Steps of all jobs",
            "steps.h5",
            Group(
                "/",
                "steps per episode of all learning jobs, side by side",
                attributes=(
                    Attribute("seeds", "int", "seeds, in the order of the rows", 0, shape=("s",)),
                    _VERSIONS,
                ),
                groups=(
                    Group(
                        "<environment>",
                        "an environment",
                        groups=(
                            Group(
                                "<method>",
                                "a method",
                                arrays=(Array("<task>", "int64", ("s", "e"), "steps of each seed and episode", 0),),
                            ),
                        ),
                    ),
                ),
            ),
        ),
        Kind(
            GAIN,
            "Policy reuse in its authors' setting",
            "fernandez_veloso/<library>.h5",
            Group(
                "/",
                "gain of every trial with one library of past policies",
                attributes=(
                    Attribute("arm", "word", "library of past policies, or plain Q-learning"),
                    _ROOT_SEED,
                    Attribute("library_trials", "int", "trials in which each policy of the library was learned", 1),
                    _PARAMETERS,
                    _MAP,
                    _CODE,
                    _VERSIONS,
                ),
                arrays=(
                    Array("seeds", "int64", ("s",), "seeds, in the order of the rows", 0),
                    Array("gain", "float64", ("s", "t"), "discounted gain of each trial", 0, 1),
                    Array("policy_quality", "float64", ("s", "p"), "mean gain of each past policy in its own task, as a"
                          " share of the optimum", 0, 1.000001),
                ),
            ),
        ),
        Kind(
            SETTING,
            "Settings of the robustness study",
            "robustness/<setting>.h5",
            Group(
                "/",
                "all environments, methods and seeds under one setting",
                attributes=(
                    Attribute("setting", "name", "name of the setting"),
                    _ROOT_SEED,
                    Attribute(
                        "job", "json", "everything that the setting was learned from",
                        keys={"setting": str, "group": str, "changes": dict, "environments": dict, "methods": list},
                    ),
                    Attribute("maps", "json", "text of each environment's map", keys={"": str}),
                    Attribute("status", "text", "complete, or what was given up or failed"),
                    _CODE,
                    _VERSIONS,
                ),
                groups=(
                    _GROWN,
                    Group(
                        "<environment>",
                        "an environment",
                        groups=(
                            Group(
                                "<method>",
                                "a method; the last six arrays only if it keeps a library",
                                arrays=_LIVES,
                            ),
                        ),
                        optional=True,
                    ),
                ),
            ),
        ),
        Kind(
            FIT,
            "Lives of the fit",
            "fit/<digest>.h5",
            Group(
                "/",
                "lives of one method in one environment under one setting that the fit tried, or lives of random tasks",
                attributes=(
                    Attribute("setting", "name", "digest of the unit"),
                    Attribute("unit", "json", "everything that the lives were learned from"),
                    _VERSIONS,
                ),
                groups=(
                    Group("lives", "the last six arrays only if a library is kept", arrays=_LIVES, optional=True),
                    _GROWN,
                ),
            ),
        ),
        Kind(
            LIVES,
            "Lives of the second study",
            "lives/<family>_<size>_<sequence>/<method>/<first map>.h5",
            Group(
                "/",
                "lives of one method on some maps of a family: $m$ maps, $s$ lives on each, $t$ tasks",
                attributes=(
                    Attribute("place", "text", "path of the file below the folder of lives, without the suffix"),
                    Attribute(
                        "job", "json", "everything that the lives were learned from",
                        keys={"cell": dict, "maps": str, "root_seed": int, "population": str, "parameters": dict},
                    ),
                    _METHOD,
                    _CODE,
                    _VERSIONS,
                ),
                arrays=(
                    Array("steps", "int64", ("m", "s", "t"), "steps of all episodes of each task", 0),
                    Array("first", "int64", ("m", "s", "t"), "steps of the first episode", 0),
                    Array("truncated", "int64", ("m", "s", "t"), "episodes that hit the step limit", 0),
                    Array("library_size", "int64", ("m", "s", "t"), "skills in the library after the task", 0),
                    Array("shortest", "int64", ("m", "t"), "shortest path of each task", 1),
                    Array("states", "int64", ("m",), "states of the map", 2),
                    Array("winding", "float64", ("m",), "mean over the goals of shortest path / straight line", 1),
                ),
            ),
        ),
    )
}  # fmt: skip
"""Every kind of result file by its format."""


# -- values -------------------------------------------------------------------------------------------------------


class Misfit(ValueError):
    """Something in a file does not fit its declaration; the message says where and how, without control characters."""


def size(declared: str | int, sizes: Sizes) -> int | None:
    """Return a size such as ``n``, ``e + 1`` or 4, None if it is not known yet."""
    if isinstance(declared, int):
        return declared
    name, *change = declared.split()
    if name not in sizes:
        return None
    return sizes[name] + (int("".join(change)) if change else 0)


def check_shape(shape: tuple[int, ...], declared: tuple[str | int, ...], sizes: dict[str, int]) -> None:
    """Hold a shape against its declaration; sizes that were not known are from now on.

    Raises
    ------
    Misfit
    """
    fits = len(shape) == len(declared)
    for found, wanted in zip(shape, declared, strict=False):
        known = size(wanted, sizes)
        if known is None:
            name, *change = str(wanted).split()
            known = found
            sizes[name] = found - (int("".join(change)) if change else 0)
            fits = fits and sizes[name] >= 0
        fits = fits and found == known
    if not fits:
        known_sizes = ", ".join(str(size(wanted, sizes)) for wanted in declared)
        raise Misfit(f"has the shape {shape} where ({known_sizes}) is needed")


def check_values(values: np.ndarray, low: Limit, high: Limit, sizes: Sizes) -> None:
    """Refuse values out of range, NaN and infinity.

    Raises
    ------
    Misfit
    """
    if not values.size or values.dtype == bool:
        return
    if values.dtype.kind == "S":
        for text in set(values.flat):
            check_text(text.decode("utf-8", "replace"))
        return
    if values.dtype.kind == "f" and not np.isfinite(values).all():
        raise Misfit("holds a value that is not finite")
    low, high = (size(limit, sizes) if isinstance(limit, str) else limit for limit in (low, high))
    if (low is not None and values.min() < low) or (high is not None and values.max() > high):
        limits = f"{'' if low is None else low} to {'' if high is None else high}".strip()
        raise Misfit(f"holds values from {values.min()} to {values.max()} where {limits} is allowed")


def check_text(text: str) -> None:
    """Refuse text of more than one line, with control characters or too long.

    Raises
    ------
    Misfit
    """
    if not text.isprintable() or len(text) > LONGEST_TEXT:
        raise Misfit("must be one line of printable text")


def parse_json(text: str) -> Any:
    """Read JSON that every reader reads alike: keys once, numbers finite, not nested too deep.

    Raises
    ------
    Misfit
    """

    def once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        found = dict(pairs)
        if len(found) < len(pairs):
            raise Misfit("gives a key twice")
        return found

    def finite(number: str) -> float:
        if not math.isfinite(value := float(number)):
            raise Misfit("holds a number that is not finite")
        return value

    try:
        found = json.loads(text, object_pairs_hook=once, parse_constant=finite, parse_float=finite)
        _check_plain(found, 0)
        return found
    except Misfit:
        raise
    except RecursionError as error:
        raise Misfit(f"is nested more than {DEEPEST} deep") from error
    except ValueError as error:
        raise Misfit("is not JSON") from error


def _check_plain(value: Any, depth: int) -> None:
    if depth > DEEPEST:
        raise Misfit(f"is nested more than {DEEPEST} deep")
    if isinstance(value, str) and CONTROL.search(value):
        raise Misfit("holds control characters")
    if isinstance(value, dict):
        for name, inner in value.items():
            _check_plain(name, depth)
            _check_plain(inner, depth + 1)
    elif isinstance(value, list):
        for inner in value:
            _check_plain(inner, depth + 1)


def _checked_json(text: str, attribute: Attribute) -> dict[str, Any]:
    if len(text) > LONGEST_JSON:
        raise Misfit(f"has more than {LONGEST_JSON} characters")
    found = parse_json(text)
    if not isinstance(found, dict):
        raise Misfit("must be an object of JSON")
    keys = dict(attribute.keys or {})
    every = keys.pop("", object)
    for name, kind in keys.items():
        if not isinstance(found.get(name), kind):
            raise Misfit(f"must have a key {name!r} of the type {kind.__name__}")
    for value in found.values():
        if not isinstance(value, every):
            raise Misfit(f"must have values of the type {every.__name__} only")
    return found


def _checked_map(text: str, _: Attribute) -> str:
    if len(text) > LONGEST_MAP:
        raise Misfit("is larger than any map")
    return text


def _checked_pattern(text: str, attribute: Attribute) -> str:
    check_text(text)
    if attribute.content in PATTERNS and not PATTERNS[attribute.content].fullmatch(text):
        raise Misfit(f"is not a {attribute.content} ({text[:60]!r})")
    return text


_TEXTS: dict[str, Callable[[str, Attribute], Any]] = {"json": _checked_json, "map": _checked_map}


def checked_text(text: str, attribute: Attribute) -> Any:
    """Return the value of an attribute of text, JSON decoded.

    Raises
    ------
    Misfit
    """
    return _TEXTS.get(attribute.content, _checked_pattern)(text, attribute)


def known_sizes(attributes: Mapping[str, Any]) -> dict[str, int]:
    """Return the sizes that follow from the root attributes of a file: ``n`` from its map, ``e`` from its parameters.

    Raises
    ------
    Misfit
        If the map is none, or hyper-parameters of learning have values that are not allowed.
    """
    sizes = {}
    try:
        if "map" in attributes:
            sizes["n"] = _states_of(attributes["map"])
        if "parameters" in attributes:
            sizes["e"] = learning_parameters(attributes["parameters"]).learning.episodes
    except UserError as error:
        raise Misfit(f"cannot be right: {error}") from error
    return sizes


def learning_parameters(parameters: Mapping[str, Any]) -> Parameters:
    """Return the groups of hyper-parameters that every method shares; methods may have more of their own."""
    return _parameters_of(json.dumps({name: parameters[name] for name in SHARED if name in parameters}))


# Files of a run share their maps and parameters, and making these takes a sixth of the time to read a file.


@lru_cache(maxsize=8)
def _states_of(text: str) -> int:
    return GridWorld.from_text(text, "map").n_states


@lru_cache(maxsize=8)
def _parameters_of(groups: str) -> Parameters:
    return Parameters.from_dict(json.loads(groups))


SHARED = tuple(Parameters().to_dict())
