"""HDF5 files with an origin and a checksum: written atomically, and read whole or not at all.

Equal runs give equal bytes: nothing in a file depends on when or where it was written. The root attribute ``format``
says what a file is, and ``versions`` which packages made it.

After the end of the HDF5 data, where HDF5 readers ignore it, a line holds the sha256 of all bytes before it. It is
checked before the HDF5 library opens a file, because that library can crash on damage or never return. A checksum
proves that a file is as it was written, not that it makes sense: everything in it is held against `ptl.files.schema`
before it is used, and what is not declared there is refused.
"""

from __future__ import annotations

import hashlib
import itertools
import json
import math
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from h5py import h5a, h5d, h5f, h5g, h5l, h5o, h5p, h5s, h5t, h5z

import ptl
from ptl.errors import UserError, printable
from ptl.files import regular
from ptl.files.atomic import atomic_path
from ptl.files.question import check_answer
from ptl.files.remedies import make, make_again
from ptl.files.schema import (
    KINDS,
    MOST_BYTES,
    Array,
    Attribute,
    Group,
    Misfit,
    check_shape,
    check_values,
    checked_text,
    known_sizes,
)

SEAL = b"\nsha256 of all bytes before this line: "
"""Begins the line after the end of the HDF5 data."""

SIGNATURE = b"\x89HDF\r\n\x1a\n"
"""Begins every HDF5 file."""

FILTERS = (h5z.FILTER_DEFLATE, h5z.FILTER_SHUFFLE)
BEST_COMPRESSION = 1100
"""No block of deflate stands for more bytes than this times its own length."""

MOST_VALUES = 10**6
"""Most values of one attribute."""

FORMAT = Attribute("format", "text", "kind of file")
TEXT = h5py.string_dtype()
_numbers = itertools.count()


class Node(dict[str, Any]):
    """A group of a file in memory: its arrays and groups by name, in the order of the file.

    Attributes
    ----------
    attrs : dict
        Attributes of the group, JSON decoded.
    """

    def __init__(self, attrs: Mapping[str, Any]) -> None:
        super().__init__()
        self.attrs = dict(attrs)


# -- writing ------------------------------------------------------------------------------------------------------


@contextmanager
def new_file(path: str | os.PathLike[str], kind: str, origin: Mapping[str, Any]) -> Iterator[h5py.File]:
    """Write a file of a kind; the block fills it.

    Parameters
    ----------
    kind : str
        Value of the root attribute ``format``.
    origin : mapping
        Other root attributes: what is needed to make the file again. Dictionaries and lists are written as JSON.

    Raises
    ------
    UserError
        If the content does not fit the declaration of the kind, or the file cannot be written.
    """
    versions = {"ptl": ptl.__version__, "numpy": np.__version__, "h5py": h5py.__version__}
    # Composed in memory, because the HDF5 library crashes when the disk is full.
    with h5py.File(f"new {next(_numbers)}", "w", driver="core", backing_store=False, libver="v110") as file:
        file.attrs["format"] = kind
        for name, value in {**origin, "versions": versions}.items():
            file.attrs[name] = json.dumps(value, sort_keys=True) if isinstance(value, dict | list) else value
        yield file
        file.flush()
        image = file.id.get_file_image()
    try:
        content_of(image, kind)
    except Misfit as error:
        raise UserError(f"{path}: is not written, because it would not be a {kind} file ({error})") from error
    with atomic_path(path) as temporary:
        temporary.write_bytes(sealed(image))


def sealed(image: bytes) -> bytes:
    """Return the bytes of an HDF5 file followed by the line with their checksum."""
    return image + SEAL + hashlib.sha256(image).hexdigest().encode() + b"\n"


# -- reading ------------------------------------------------------------------------------------------------------


def read_file(path: str | os.PathLike[str], *kinds: str) -> Node:
    """Read a file of one of several kinds into memory.

    Raises
    ------
    UserError
        If it is missing, damaged, of another kind, does not fit the declaration of its kind or answers another
        question than the one asked now (`ptl.files.question`); the line ends with the command that makes it again.
    """
    try:
        content = regular.read_bytes(path, regular.MOST_BYTES)
        _refuse_other_files(path, content)
        root = content_of(_unsealed(content), *kinds)
    except regular.NotReadable as error:
        if error.missing:
            raise UserError(f"{path}: no such file; {make(path)}") from error
        raise UserError(f"{path}: cannot be read ({error.reason}); {make_again(path)}") from error
    except Misfit as error:
        raise UserError(f"{path}: {error}; {make_again(path)}") from error
    check_answer(Path(path), root)
    return root


def _refuse_other_files(path: str | os.PathLike[str], content: bytes) -> None:
    """Refuse what is no HDF5 file and is not called one: it is not damaged, so no advice to remove it fits."""
    if content and not content.startswith(SIGNATURE) and Path(path).suffix != ".h5":
        import mimetypes  # every job pays for what is imported above

        kind = mimetypes.guess_type(path)[0] or "of another kind"
        raise UserError(f"{path}: is {kind}, no result file; name a file that ends in .h5")


def _unsealed(content: bytes) -> bytes:
    """Return the HDF5 data of a file, without the line at its end."""
    rest = len(content) - len(sealed(b""))
    image, line = content[: max(rest, 0)], content[max(rest, 0) :]
    if not content.startswith(SIGNATURE):
        raise Misfit(f"is not a result file ({'it is empty' if not content else 'no HDF5 file at all'})")
    if rest < 0 or not line.startswith(SEAL):
        raise Misfit("damaged, or of another program (without the checksum at its end)")
    if line != SEAL + hashlib.sha256(image).hexdigest().encode() + b"\n":
        raise Misfit("damaged (its bytes do not match its checksum)")
    return image


def content_of(image: bytes, *kinds: str) -> Node:
    """Return the content of an HDF5 file in memory that fits the declaration of its kind.

    Raises
    ------
    Misfit
        Naming the place and the fault.
    """
    access = h5p.create(h5p.FILE_ACCESS)
    access.set_fapl_core(backing_store=False)
    access.set_file_image(image)
    try:
        # Names of open files must differ, or the library takes one for the other.
        file = h5f.open(f"image {next(_numbers)}".encode(), h5f.ACC_RDONLY, fapl=access)
        try:
            return _Reader(kinds).read(file)
        finally:
            file.close()
    except Misfit:
        raise
    except Exception as error:  # the library reports damage by exceptions of many types
        raise Misfit(f"damaged ({printable(_first_line(error))})") from error


class _Reader:
    """Reads a file group by group, each part after its kind, shape and size have been checked."""

    def __init__(self, kinds: tuple[str, ...]) -> None:
        self.kinds = kinds
        self.bytes_left = MOST_BYTES

    def read(self, file: h5f.FileID) -> Node:
        root = h5g.open(file, b"/")
        kind = self._format(root)
        declared = KINDS[kind].root
        sizes: dict[str, int] = {}
        attributes = self._attributes(root, declared, sizes, "/")
        return self._group(root, declared, attributes, sizes | known_sizes(attributes), "/")

    def _format(self, root: h5g.GroupID) -> str:
        if not h5a.exists(root, b"format"):
            raise Misfit("is not a result file (no attribute 'format')")
        kind = _attribute(h5a.open(root, b"format"), FORMAT, {})
        if kind not in self.kinds or kind not in KINDS:
            wanted = " or ".join(self.kinds) if len(self.kinds) <= 2 else "result"
            raise Misfit(f"is not a {wanted} file (format {kind!r})")
        return kind

    def _group(
        self, group: h5g.GroupID, declared: Group, attributes: dict[str, Any], sizes: dict[str, int], where: str
    ) -> Node:
        node, found = Node(attributes), []
        for raw in group:
            name = printable(raw.decode("utf-8", "replace"))
            place = f"{where}{name}"
            if group.links.get_info(raw).type != h5l.TYPE_HARD:
                raise Misfit(f"{place}: is a link to elsewhere, which no result file has")
            member = declared.member(name)
            if member is None:
                raise Misfit(f"{place}: is not declared for this kind of file")
            found.append(member)
            item = h5o.open(group, raw)
            if h5o.get_info(item).rc != 1:
                raise Misfit(f"{place}: has more than one name")
            if isinstance(member, Array):
                node[name] = self._array(item, member, sizes, place)
            elif not isinstance(item, h5g.GroupID):
                raise Misfit(f"{place}: must be a group")
            else:
                own = dict(sizes)
                inner = self._attributes(item, member, own, f"{place}/")
                node[name] = self._group(item, member, inner, own, f"{place}/")
        _check_all_there(declared.arrays, found, where)
        for member in declared.groups:
            if not member.optional and member not in found:
                raise Misfit(f"{where}{member.name}: is missing")
        return node

    def _attributes(self, group: h5g.GroupID, declared: Group, sizes: dict[str, int], where: str) -> dict[str, Any]:
        by_name = {attribute.name: attribute for attribute in declared.attributes}
        if where == "/":
            by_name["format"] = FORMAT
        values = {}
        for index in range(h5a.get_num_attrs(group)):
            found = h5a.open(group, index=index)
            name = printable(found.name.decode("utf-8", "replace"))
            if name not in by_name:
                raise Misfit(f"{where}: attribute {name!r} is not declared for this kind of file")
            try:
                values[name] = _attribute(found, by_name[name], sizes)
            except Misfit as error:
                raise Misfit(f"{where}: attribute {name}: {error}") from error
        present = [attribute for attribute in declared.attributes if attribute.name in values]
        _check_all_there(declared.attributes, present, f"{where}: attribute ")
        return values

    def _array(self, item: Any, declared: Array, sizes: dict[str, int], place: str) -> np.ndarray:
        try:
            if not isinstance(item, h5d.DatasetID):
                raise Misfit("must be an array")
            check_shape(item.shape, declared.shape, sizes)
            dtype = item.dtype
            if not (dtype.kind == "S" if declared.dtype == "bytes" else dtype == np.dtype(declared.dtype)):
                raise Misfit(f"must be of the type {declared.dtype}")
            if h5a.get_num_attrs(item):
                raise Misfit("has attributes, which no array has")
            self._take(math.prod(item.shape) * dtype.itemsize)
            _check_storage(item)
            values = np.empty(item.shape, dtype=dtype)
            if values.size:
                item.read(h5s.ALL, h5s.ALL, values)
            check_values(values, declared.low, declared.high, sizes)
            return values
        except Misfit as error:
            raise Misfit(f"{place}: {error}") from error

    def _take(self, number: int) -> None:
        """Count bytes before they are read."""
        self.bytes_left -= number
        if self.bytes_left < 0:
            raise Misfit(f"asks for more than {MOST_BYTES} bytes")


def _attribute(found: h5a.AttrID, declared: Attribute, sizes: dict[str, int]) -> Any:
    if not declared.dtype:
        kind = found.get_type()
        if found.shape != () or not isinstance(kind, h5t.TypeStringID) or not kind.is_variable_str():
            raise Misfit("must be text")
        text = np.empty((), dtype=TEXT)
        found.read(text)
        value: Any = text[()]
        return checked_text(value.decode() if isinstance(value, bytes) else value, declared)
    check_shape(found.shape, declared.shape, sizes)
    if found.dtype != np.dtype(declared.dtype):
        raise Misfit(f"must be of the type {declared.dtype}")
    if math.prod(found.shape) > MOST_VALUES:
        raise Misfit(f"has more than {MOST_VALUES} values")
    values = np.empty(found.shape, dtype=found.dtype)
    found.read(values)
    check_values(values, declared.low, declared.high, sizes)
    return values if declared.shape else values[()].item()


def _check_all_there(declared: tuple[Any, ...], found: list[Any], where: str) -> None:
    """Refuse a group without some of its parts; the optional ones are there together or not at all."""
    some = any(member.optional for member in found)
    for member in declared:
        if member not in found and (some or not member.optional):
            raise Misfit(f"{where}{member.name}: is missing")


def _check_storage(item: h5d.DatasetID) -> None:
    """Refuse values that are in other files, not there at all, or blown up beyond what compression can do."""
    creation = item.get_create_plist()
    number = math.prod(item.shape) * item.dtype.itemsize
    layout = creation.get_layout()
    if creation.get_external_count() or layout not in (h5d.COMPACT, h5d.CONTIGUOUS, h5d.CHUNKED):
        raise Misfit("is stored outside of the file")
    if any(creation.get_filter(index)[0] not in FILTERS for index in range(creation.get_nfilters())):
        raise Misfit("is stored with a filter other than gzip and shuffle")
    stored = item.get_storage_size()
    if layout != h5d.CHUNKED:
        if stored != number:
            raise Misfit("is not stored in full")
        return
    chunk = creation.get_chunk()
    if any(part > whole for part, whole in zip(chunk, item.shape, strict=True)):
        raise Misfit("is stored in chunks larger than itself")
    if item.get_num_chunks() != math.prod(-(-whole // part) for part, whole in zip(chunk, item.shape, strict=True)):
        raise Misfit("is not stored in full")
    if number > BEST_COMPRESSION * stored:
        raise Misfit("is compressed more than gzip can")


def _first_line(error: Exception) -> str:
    return (str(error) or type(error).__name__).splitlines()[0]
