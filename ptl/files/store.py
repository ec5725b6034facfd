"""Result files: HDF5 with a job, arrays and a checksum; written whole, read whole, and checked before use.

Equal jobs give equal bytes: nothing in a file depends on when or where it was written. After the end of the HDF5 data,
where HDF5 readers ignore it, a line gives the digest of the job and the sha256 of all bytes before the line. It is
checked before the HDF5 library opens a file, because that library can crash on damage.
"""

from __future__ import annotations

import hashlib
import io
import json
import math
import os
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from h5py import h5d, h5f, h5g, h5l, h5o, h5p, h5s, h5t

import ptl
from ptl.errors import UserError, printable
from ptl.files import regular
from ptl.files.atomic import atomic_path
from ptl.files.formats import Misfit, check
from ptl.files.job import Job, Worlds, differences, from_text
from ptl.world.gridworld import GridWorld, map_digest

MAX_BYTES = 2**31
"""Maximum size of a file and of its arrays together; larger ones are not read."""

SEAL = re.compile(rb"\njob ([0-9a-f]{16}), sha256 of all bytes before this line ([0-9a-f]{64})\n")
SEAL_BYTES = len(b"\njob , sha256 of all bytes before this line \n") + 16 + 64

AGAIN = "remove it and run the same command again ('ptl verify --remove results' removes all such files)"
"""Remedy for a file that cannot be used."""


@dataclass(frozen=True, eq=False)
class Result:
    """A result file in memory.

    Attributes
    ----------
    path : Path
    job : Job
        What it was made from.
    arrays : dict of str to array
        Arrays by name; slashes separate groups.
    maps : dict of str to str
        Text of the map of each environment.
    versions : dict of str to str
        Versions of the packages that wrote it.
    """

    path: Path
    job: Any
    arrays: dict[str, np.ndarray]
    maps: dict[str, str]
    versions: dict[str, str]

    @cached_property
    def worlds(self) -> dict[str, GridWorld]:
        """The world of each environment."""
        return {name: _world(text).with_slip(self.job.slip) for name, text in self.maps.items()}

    @property
    def world(self) -> GridWorld:
        """The world of the only environment."""
        [world] = self.worlds.values()
        return world


# -- writing ------------------------------------------------------------------------------------------------------


def write(path: str | os.PathLike[str], job: Job, arrays: Mapping[str, np.ndarray], worlds: Worlds) -> None:
    """Write a result file.

    Parameters
    ----------
    worlds : mapping
        The maps to be stored, by environment.

    Raises
    ------
    UserError
        If the arrays do not fit the job, or the file cannot be written.
    """
    try:
        _check(job, arrays, worlds)
    except Misfit as error:
        raise UserError(f"{path}: is not written; {error}") from error
    attributes = {"job": job.text, "maps": _json({name: world.text for name, world in worlds.items()})}
    write_arrays(path, arrays, attributes, job.digest)


def write_arrays(
    path: str | os.PathLike[str],
    arrays: Mapping[str, np.ndarray],
    attributes: Mapping[str, Any],
    digest: str = "0" * 16,
) -> None:
    """Write arrays by name and root attributes to a file with a checksum; errors as in `write`."""
    versions = {"ptl": ptl.__version__, "numpy": np.__version__, "h5py": h5py.__version__}
    buffer = io.BytesIO()  # in memory, because the HDF5 library crashes when the disk is full
    with h5py.File(buffer, "w", libver="v110") as file:
        file.attrs.update({**attributes, "versions": _json(versions)})
        groups = {"": file}
        for place, values in arrays.items():
            parent, _, name = place.rpartition("/")
            if parent not in groups:
                groups[parent] = file.require_group(parent)
            _create(groups[parent], name, values)
    image = buffer.getvalue()
    seal = f"\njob {digest}, sha256 of all bytes before this line {hashlib.sha256(image).hexdigest()}\n"
    with atomic_path(path) as temporary:
        temporary.write_bytes(image + seal.encode())


def _create(group: h5py.Group, name: str, values: np.ndarray) -> None:
    """Write an array; most are small, and for these the low-level interface takes a third of the time."""
    if np.size(values) > 1000:
        group.create_dataset(name, data=values, track_times=False, compression="gzip", shuffle=True)
        return
    data, creation = np.asarray(values, order="C"), h5p.create(h5p.DATASET_CREATE)
    creation.set_obj_track_times(False)
    kind, space = h5t.py_create(data.dtype, logical=True), h5s.create_simple(data.shape)
    h5d.create(group.id, name.encode(), kind, space, creation).write(h5s.ALL, h5s.ALL, data)


def _json(value: Any) -> str:
    return json.dumps(value, sort_keys=True, ensure_ascii=False)


# -- reading ------------------------------------------------------------------------------------------------------


def read(path: str | os.PathLike[str], wanted: Job | None = None) -> Result:
    """Read a result file.

    Parameters
    ----------
    wanted : Job, optional
        The job that must have made it.

    Raises
    ------
    UserError
        If it is missing, damaged, of another format or impossible, or was made by another job than ``wanted``: one line
        that names the value that differs.
    """
    arrays, attributes = read_arrays(path)
    try:
        job, maps = from_text(attributes["job"]), json.loads(attributes["maps"])
        if wanted is not None and (other := differences(job, wanted)):
            raise Misfit(f"was made with {other[0]}" + f" (and {len(other) - 1} other differences)" * (len(other) > 1))
        result = Result(Path(path), job, arrays, maps, json.loads(attributes["versions"]))
        _check(job, arrays, result.worlds)
    except (UserError, ValueError, KeyError, AttributeError, TypeError) as error:
        raise UserError(f"{path}: {_first_line(error)}; {AGAIN}") from error
    return result


def read_arrays(path: str | os.PathLike[str]) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """Read the arrays by name and the root attributes of a file that `write_arrays` wrote; errors as in `read`."""
    try:
        content = regular.read_bytes(path, MAX_BYTES)
    except regular.NotReadable as error:
        remedy = "check the path, or run the workflow to make it" if error.missing else AGAIN
        raise UserError(f"{path}: {'no such file' if error.missing else error.reason}; {remedy}") from error
    try:
        with h5py.File(h5f.open_file_image(_unsealed(content))) as file:
            arrays = dict(_arrays(h5g.open(file.id, b"/"), "", [MAX_BYTES]))
            return arrays, dict(file.attrs)
    except Exception as error:  # the HDF5 library reports damage by exceptions of many types
        reason = str(error) if isinstance(error, Misfit) else f"damaged ({_first_line(error)})"
        raise UserError(f"{path}: {reason}; {AGAIN}") from error


def digest_in(path: str | os.PathLike[str]) -> str | None:
    """Return the digest of the job that made a file, None if the file does not exist or does not name one."""
    try:
        with open(path, "rb") as file:  # noqa: PTH123 - every planning of a run looks at all result files
            file.seek(-SEAL_BYTES, os.SEEK_END)
            match = SEAL.fullmatch(file.read())
    except OSError:
        return None
    return match[1].decode() if match else None


def _unsealed(content: bytes) -> bytes:
    """Return the HDF5 data of a file, without the line at its end."""
    image, line = content[:-SEAL_BYTES], content[-SEAL_BYTES:]
    match = SEAL.fullmatch(line)
    if not match:
        raise Misfit("damaged, or no result file of this version (no checksum at its end)")
    if hashlib.sha256(image).hexdigest().encode() != match[2]:
        raise Misfit("damaged (its bytes do not match its checksum)")
    return image


def _arrays(group: h5g.GroupID, where: str, bytes_left: list[int]) -> Iterator[tuple[str, np.ndarray]]:
    """Yield all arrays below a group; by the low-level interface, which takes a third of the time."""
    for raw in group:
        place = f"{where}{raw.decode('utf-8', 'replace')}"
        if group.links.get_info(raw).type != h5l.TYPE_HARD:
            raise Misfit(f"{place}: is a link, which no result file has")
        item = h5o.open(group, raw)
        if isinstance(item, h5g.GroupID):
            yield from _arrays(item, f"{place}/", bytes_left)
            continue
        creation, shape, dtype = item.get_create_plist(), item.shape, item.dtype
        bytes_left[0] -= math.prod(shape) * dtype.itemsize
        if creation.get_external_count() or creation.get_layout() == h5d.VIRTUAL or bytes_left[0] < 0:
            raise Misfit(f"{place}: is stored elsewhere, or more than {MAX_BYTES} bytes are asked for")
        values = np.empty(shape, dtype)
        if values.size:
            item.read(h5s.ALL, h5s.ALL, values)
        yield place, values


def _check(job: Job, arrays: Mapping[str, np.ndarray], worlds: Worlds) -> None:
    """Refuse maps and arrays that cannot be those of a job.

    Raises
    ------
    Misfit
    """
    for name, world in worlds.items():
        if job.maps.get(name) != map_digest(world.text):
            raise Misfit(f"its map of {name} is not that of its job")
        if world.slip != job.slip:
            raise Misfit(f"the slip of {name}, {world.slip}, is not that of its job, {job.slip}")
    check(job.ARRAYS, arrays, job.sizes(worlds))
    for fault in job.faults(arrays, worlds):
        raise Misfit(fault)


@lru_cache(maxsize=8)  # files of a run share their maps, and making a world takes a sixth of the time to read a file
def _world(text: str) -> GridWorld:
    return GridWorld.from_text(text, "map")


def _first_line(error: Exception) -> str:
    return printable((str(error) or type(error).__name__).splitlines()[0])
