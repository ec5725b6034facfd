"""A job: everything that determines the content of a result file.

Each kind of file has a subclass of `Job`, which declares what determines it (fields), its path (`Job.place`), how it is
made (`Job.run`) and its contents (`Job.ARRAYS`, `Job.faults`). The file stores its job; a reader states the job that it
expects, and `differences` names the values that differ. Snakemake gets the same job as the parameter of its rule.
"""

from __future__ import annotations

import base64
import hashlib
import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import lru_cache
from typing import Annotated, Any, ClassVar, TypeVar

import msgspec
import numpy as np
from msgspec import Meta

from ptl.config import Parameters
from ptl.errors import UserError
from ptl.files.formats import Array
from ptl.world.gridworld import GridWorld

Word = Annotated[str, Meta(pattern=r"^[a-z][a-z0-9_]{0,63}$")]
Digest = Annotated[str, Meta(pattern=r"^[0-9a-f]{16}$")]
Number = Annotated[int, Meta(ge=0, le=2**63 - 1)]
Positive = Annotated[int, Meta(ge=1, le=2**63 - 1)]
Probability = Annotated[float, Meta(ge=0, le=1)]

Worlds = Mapping[str, GridWorld]
Watch = Callable[[Sequence[Any]], Iterable[Any]]
"""A function that a job wraps its parts in, say in a progress bar."""


class Job(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="kind"):
    """What a result file is made from.

    Attributes
    ----------
    root_seed : int
        Seed from which all random streams derive.
    parameters : dict
        The groups of hyper-parameters that the job reads, and no others.
    maps : dict of str to str
        Digest of the map of each environment, see `ptl.world.gridworld.map_digest`.
    code : str
        Digest of the sources that determine the result, see `sources`.
    slip : float
        Probability that a step goes in a random direction, in all environments.
    """

    root_seed: Number
    parameters: dict[str, dict[str, Any]]
    maps: dict[str, Digest]
    code: Digest
    slip: Probability = 0.0

    TITLE: ClassVar[str] = ""
    READS: ClassVar[tuple[str, ...]] = ()
    ARRAYS: ClassVar[Mapping[str, Array]] = {}

    @property
    def place(self) -> str:
        """Path of the file below results/<run>/."""
        raise NotImplementedError

    def run(self, worlds: Worlds, watch: Watch = iter) -> dict[str, np.ndarray]:
        """Do the work; return the arrays of the file by name.

        Parameters
        ----------
        worlds : mapping
            The map of each environment in `maps`.
        watch : callable
            Wraps the parts of the work, say in a progress bar.
        """
        raise NotImplementedError

    def sources(self) -> str | None:
        """Return the digest of the present sources, None if they cannot be found without importing other code."""
        raise NotImplementedError

    def sizes(self, worlds: Worlds) -> dict[str, int]:
        """Return the sizes of the arrays that follow from the job."""
        raise NotImplementedError

    def faults(self, arrays: Mapping[str, np.ndarray], worlds: Worlds) -> Iterator[str]:
        """Yield the impossible values in arrays that match their declarations."""
        yield from ()

    # -- for all kinds ----------------------------------------------------------------------------------------

    @property
    def kind(self) -> str:
        """Name and version of the format."""
        return str(self.__struct_config__.tag)

    @property
    def text(self) -> str:
        """The job as JSON; equal jobs have equal texts."""
        return msgspec.json.encode(self, order="sorted").decode()

    @property
    def digest(self) -> str:
        """Digest of the job, 16 hex digits."""
        return digest_of_text(self.text)

    @property
    def settings(self) -> Parameters:
        """The hyper-parameters; groups that the job does not read have their defaults."""
        return _settings(msgspec.json.encode(self.parameters))


@lru_cache(maxsize=8)  # the jobs of a run share theirs, and checking them takes as long as some tasks
def _settings(parameters: bytes) -> Parameters:
    return Parameters.from_dict(msgspec.json.decode(parameters))


def digest_of_text(text: str) -> str:
    """Return the first 16 hex digits of the sha256 of a text."""
    return hashlib.sha256(text.encode()).hexdigest()[:16]


# -- kinds --------------------------------------------------------------------------------------------------------

KINDS: dict[str, type[Job]] = {}
"""Kinds of jobs by name and version; those of the package are in `ptl.jobs`, those of a study in its folder."""

Kind = TypeVar("Kind", bound=type[Job])


def register(kind: Kind) -> Kind:
    """Make a kind of job known to `from_text` (a decorator)."""
    KINDS[str(kind.__struct_config__.tag)] = kind
    return kind


class Tagged(msgspec.Struct):
    """The kind of a job of any kind; its other keys are ignored."""

    kind: str


def from_text(text: str | bytes) -> Job:
    """Return the job that a text of JSON describes.

    Raises
    ------
    UserError
        If it is no JSON, of an unknown kind, or a value is not allowed.
    """
    try:
        name = msgspec.json.decode(text, type=Tagged).kind
        if name not in KINDS:
            raise UserError(f"job of the kind {name!r:.60}: is not one of {', '.join(KINDS)}")
        return msgspec.json.decode(text, type=KINDS[name])
    except (msgspec.MsgspecError, UnicodeDecodeError, RecursionError) as error:
        raise UserError(f"job: {error}") from error


# -- comparison ---------------------------------------------------------------------------------------------------


def differences(actual: Job, wanted: Job) -> list[str]:
    """Return the values in which a job differs from the expected one, most informative first: ``x 1, not 2``."""
    if actual == wanted:
        return []
    ours, theirs = _flat(msgspec.to_builtins(wanted)), _flat(msgspec.to_builtins(actual))
    names = [name for name in {**ours, **theirs} if ours.get(name) != theirs.get(name)]
    return [_named(name, theirs.get(name), ours.get(name)) for name in sorted(names, key=_importance)]


def _importance(name: str) -> int:
    """Listed last, because a change of code or map changes other values too and is less informative."""
    return {"kind": 0, "code": 3}.get(name, 2 if name.startswith("maps.") else 1)


def _named(name: str, actual: Any, wanted: Any) -> str:
    if name == "code":
        return "another version of the code"
    if name.startswith("maps."):
        return f"another map of {name.removeprefix('maps.')}"
    return f"{name.removeprefix('parameters.')} {_shown(actual)}, not {_shown(wanted)}"


def _shown(value: Any) -> str:
    return "none" if value is None else f"{value!r:.60}" if isinstance(value, str) else f"{value}"[:60]


def _flat(value: Any, name: str = "") -> dict[str, Any]:
    if not isinstance(value, dict):
        return {name: value}
    parts = (_flat(part, f"{name}.{key}" if name else key) for key, part in value.items())
    return {key: part for group in parts for key, part in group.items()}


# -- handing jobs on ----------------------------------------------------------------------------------------------


def packed(jobs: Iterable[Job]) -> str:
    """Return jobs as one short text, for a parameter of a rule that reads many files."""
    lines = "\n".join(job.text for job in jobs)
    return base64.b64encode(zlib.compress(lines.encode(), 9)).decode()


def lines_of(text: str) -> list[str]:
    """Return the texts of the jobs of `packed`."""
    return zlib.decompress(base64.b64decode(text)).decode().splitlines()
