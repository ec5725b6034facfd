"""Compare the products of a run with those of another: the published one, or any other report folder.

Products are equal if their bytes are. They are equal within a tolerance (ours) if pictures differ by `GREY_LEVELS` at
most, or texts in the last printed digit of numbers that are not whole: processors round differently. A picture is also
within the tolerance if its numbers (CSV) and its vector twin (SVG) are: other versions of the libraries that paint
place the edges of letters differently. Steps and other counts are whole numbers and must be equal.
"""

from __future__ import annotations

import base64
import csv
import io
import re
import struct
import subprocess
import warnings
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from decimal import Decimal, DecimalException
from itertools import zip_longest
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any, Protocol

from ptl.errors import UserError, printable
from ptl.files.manifest import MADE, MANIFEST, parse, read
from ptl.files.regular import NotReadable, read_bytes, sha256

if TYPE_CHECKING:
    import numpy as np

GREY_LEVELS = 2
"""Largest difference of a colour channel (0 to 255) at which two pixels are equal within the tolerance."""

PUBLISHED = "published"
"""Stands for the published products: those of git's HEAD, or the copy that was kept of them before the first run."""

KEPT = ".published"
"""Folder of that copy, made by ``make reproduce`` where there is no git."""

MOST_BYTES = 2**26
"""Most bytes of a product, and of the data packed in it; more is not read."""

MOST_PIXELS = 2**24
"""Most pixels of a picture."""

LISTED = 6
"""Products, keys and claims that are named; of more only the number is given."""

_NUMBER = re.compile(r"[-−]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
_IDENTIFIER = re.compile(r"\b[a-z][0-9a-f]{10}\b")  # matplotlib's, a digest of what it names
_PACKED = re.compile(r"H4sI[A-Za-z0-9+/=]{40,}")  # gzip in base64, as in the explorer


# -- what a run is compared with ----------------------------------------------------------------------------------


class NothingToCompareError(UserError):
    """There are no products of another run."""


class Reference(Protocol):
    """The products of the other run."""

    @property
    def name(self) -> str:
        """How messages call it."""

    def read(self, product: str) -> bytes | None:
        """Return the content of a product, None if it cannot be read."""

    def manifest(self) -> dict[str, Any]:
        """Return the manifest."""


@dataclass(frozen=True)
class FolderReference:
    """A report folder."""

    folder: Path
    name: str

    def read(self, product: str) -> bytes | None:
        """Return the content of a product, None if it cannot be read."""
        return _content(self.folder / product)

    def manifest(self) -> dict[str, Any]:
        """Return the manifest."""
        return read(self.folder / MANIFEST)


@dataclass(frozen=True)
class RevisionReference:
    """A report folder as a git revision holds it."""

    folder: Path
    revision: str

    @property
    def name(self) -> str:
        """The revision, with the commit that it stands for."""
        commit = _git(self.folder, "rev-parse", "--short", self.revision)
        return f"git {self.revision} ({(commit or b'').decode().strip()})"

    def read(self, product: str) -> bytes | None:
        """Return the content of a product, None if it is not there."""
        return _git(self.folder, "cat-file", "blob", f"{self.revision}:./{product}")

    def manifest(self) -> dict[str, Any]:
        """Return the manifest."""
        text = self.read(MANIFEST)
        if text is None:
            raise UserError(
                f"{self.folder}: git {self.revision} holds no {MANIFEST} there; give a revision that has one, or a"
                " report folder"
            )
        return parse(text.decode("utf-8", "replace"), Path(f"{self.revision}:{self.folder}/{MANIFEST}"))


def _git(folder: Path, *arguments: str) -> bytes | None:
    try:
        done = subprocess.run(["git", "-C", str(folder), *arguments], check=False, capture_output=True)
    except OSError:  # no git, or no such folder
        return None
    return done.stdout if done.returncode == 0 else None


def reference(text: str, folder: Path) -> Reference:
    """Return what a report folder is compared with.

    Parameters
    ----------
    text : str
        A report folder, its manifest, ``git:REVISION`` (the same folder there), or `PUBLISHED`.
    folder : path
        Report folder of the run.

    Raises
    ------
    UserError
        If there is nothing of the kind, or a run would be compared with itself.
    """
    if text.startswith("git:"):
        return _of_another_run(RevisionReference(folder, text.removeprefix("git:")), folder)
    if text != PUBLISHED:
        other = Path(text).parent if Path(text).name == MANIFEST else Path(text)
        if other.resolve() == folder.resolve():
            raise UserError(f"{folder}: would be compared with itself; give another report folder, or git:HEAD")
        return FolderReference(other, text)
    head = RevisionReference(folder, "HEAD")
    if head.read(MANIFEST) is not None:
        return _of_another_run(head, folder)
    kept = Path(KEPT)
    if folder.name == PUBLISHED and (kept / MANIFEST).is_file():
        return _of_another_run(FolderReference(kept, f"{KEPT} (kept before the first run)"), folder)
    raise NothingToCompareError(
        f"{folder}: neither git's HEAD nor {KEPT} holds the published products to compare with; 'make reproduce' in a"
        " fresh copy of the package keeps them"
    )


def _of_another_run(other: Reference, folder: Path) -> Reference:
    """Refuse to take products that were checked out for those of a run made here."""
    made = folder.parent.parent / "results" / folder.name / MADE
    own = _content(folder / MANIFEST)
    if own is not None and own != _content(made):
        raise UserError(
            f"{folder}: holds products that came with the package, not those of a run made here ({made} does not match"
            " its manifest), and would be compared with themselves; run 'make reproduce'"
        )
    return other


# -- comparing ----------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Comparison:
    """How the products of a run compare with those of another.

    Attributes
    ----------
    folder : path
    other : str
        Name of the other run.
    equal, close, different, missing : list of str
        Products by outcome; close are those equal within the tolerance.
    claims : int
        Number of claims that either run judges.
    verdicts : dict
        Claims with another verdict: id to the other's and ours ("-" if one run does not judge it).
    settings, versions : dict
        Keys of the configuration, and packages, with other values: name to the other's and ours.
    """

    folder: Path
    other: str
    equal: list[str]
    close: list[str]
    different: list[str]
    missing: list[str]
    claims: int
    verdicts: dict[str, tuple[str, str]]
    settings: dict[str, tuple[str, str]]
    versions: dict[str, tuple[str, str]]

    @property
    def agrees(self) -> bool:
        """Whether all products are there and equal or close, and all verdicts equal."""
        return not (self.different or self.missing or self.verdicts)

    def __str__(self) -> str:
        return "\n".join(map(printable, self.lines()))

    def lines(self) -> Iterator[str]:
        """Yield the verdict on the rerun in a few lines."""
        count = sum(map(len, (self.equal, self.close, self.different, self.missing)))
        yield f"{self.folder} compared with {self.other}:"
        outcomes = [(len(self.equal), "equal"), (len(self.close), "equal within the tolerance")]
        outcomes += [(len(self.different), "different")] + [(len(self.missing), "missing")] * bool(self.missing)
        yield f"  products: {', '.join(f'{number} {word}' for number, word in outcomes)} (of {count})"
        for word in ("different", "missing"):
            if names := getattr(self, word):
                yield f"    {word}: {_listed(names)}"
        if self.claims:
            same = self.claims - len(self.verdicts)
            yield f"  verdicts: {'all ' if not self.verdicts else f'{same} of '}{self.claims} equal"
            if self.verdicts:
                yield f"    changed: {_listed(_changes(self.verdicts))}"
        for word, changed in (("configuration", self.settings), ("versions", self.versions)):
            if changed:
                yield f"  {word}: {_listed(_changes(changed))}"
        if not self.agrees:
            yield f"  where to look: 'git diff {self.folder}', and docs/reliability.md on what may differ"


def _changes(changed: Mapping[str, tuple[str, str]]) -> list[str]:
    return [f"{name} ({theirs}, here {ours})" for name, (theirs, ours) in changed.items()]


def _listed(names: list[str]) -> str:
    more = f" and {len(names) - LISTED} more" if len(names) > LISTED else ""
    return ", ".join(names[:LISTED]) + more


def compare(folder: Path, other: Reference) -> Comparison:
    """Compare a report folder with the products of another run.

    Raises
    ------
    UserError
        If a manifest is missing or damaged.
    """
    own, theirs = read(folder / MANIFEST), other.manifest()
    outcomes: dict[str, list[str]] = {"equal": [], "close": [], "different": [], "missing": []}
    for name, digest in theirs["products"].items():
        outcomes[_outcome(folder / name, digest, name, other)].append(name)
    alike = {*outcomes["equal"], *outcomes["close"]}
    for name in outcomes["different"][:]:
        twins = {str(PurePosixPath(name).with_suffix(suffix)) for suffix in (".csv", ".svg")}
        if name.endswith(".png") and twins <= alike and _sizes_equal(_content(folder / name), other.read(name)):
            outcomes["different"].remove(name)
            outcomes["close"].append(name)
    before, after = _verdicts(other.read("claims.csv")), _verdicts(_content(folder / "claims.csv"))
    return Comparison(
        folder,
        other.name,
        **outcomes,
        claims=len({*before, *after}),
        verdicts=_changed(before, after),
        settings=_changed(_flat(theirs["config"]), _flat(own["config"])),
        versions=_changed(theirs.get("versions", {}), own.get("versions", {})),
    )


def _outcome(path: Path, digest: str, name: str, other: Reference) -> str:
    try:
        if sha256(path) == digest:
            return "equal"
    except NotReadable as error:
        return "missing" if error.missing else "different"
    content, theirs = _content(path), other.read(name)
    if content is None or theirs is None:
        return "different"
    alike = look_alike(content, theirs) if name.endswith(".png") else read_alike(content, theirs)
    return "close" if alike else "different"


def _content(path: Path) -> bytes | None:
    """Return the content of a file, None if it cannot be read."""
    try:
        return read_bytes(path, MOST_BYTES)
    except NotReadable:
        return None


def _verdicts(content: bytes | None) -> dict[str, str]:
    """Return the verdict of each claim by its id, none if the table cannot be read."""
    rows = csv.DictReader(io.StringIO((content or b"").decode("utf-8", "replace")))
    try:
        return {str(row.get("id")): str(row.get("verdict")) for row in rows}
    except csv.Error:
        return {}


def _changed(before: Mapping[str, Any], after: Mapping[str, Any]) -> dict[str, tuple[str, str]]:
    pairs = {name: (str(before.get(name, "-")), str(after.get(name, "-"))) for name in {**before, **after}}
    return {name: pair for name, pair in pairs.items() if pair[0] != pair[1]}


def _flat(config: Mapping[str, Any], parent: str = "") -> dict[str, Any]:
    flat: dict[str, Any] = {}
    for name, value in config.items():
        flat |= _flat(value, f"{parent}{name}.") if isinstance(value, Mapping) else {f"{parent}{name}": value}
    return flat


def look_alike(ours: bytes, theirs: bytes) -> bool:
    """Return whether two PNGs have one size and pixels that differ by at most `GREY_LEVELS`."""
    import numpy as np

    pixels, others = _pixels(ours), _pixels(theirs)
    if pixels is None or others is None or pixels.shape != others.shape:
        return False
    return int(np.abs(pixels - others).max()) <= GREY_LEVELS


def _sizes_equal(ours: bytes | None, theirs: bytes | None) -> bool:
    pixels, others = _pixels(ours or b""), _pixels(theirs or b"")
    return pixels is not None and others is not None and pixels.shape == others.shape


def _pixels(png: bytes) -> np.ndarray | None:
    """Return the channels of a PNG, int array (rows, columns, 4), or None if it is damaged or too large."""
    import numpy as np
    from PIL import Image

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)
            with Image.open(io.BytesIO(png), formats=["PNG"]) as image:
                if image.width * image.height > MOST_PIXELS:
                    return None
                return np.asarray(image.convert("RGBA"), dtype=np.int16)
    except (OSError, SyntaxError, ValueError, EOFError, struct.error, zlib.error, Image.DecompressionBombError):
        return None


def read_alike(ours: bytes, theirs: bytes) -> bool:
    """Return whether two texts differ in nothing but the last printed digit of numbers that are not whole."""
    try:
        one, other = (_unpacked(content.decode()) for content in (ours, theirs))
    except (ValueError, zlib.error):
        return False
    between = zip_longest(_NUMBER.split(one), _NUMBER.split(other))
    if any(part != counterpart for part, counterpart in between):
        return False
    return all(map(_close, _NUMBER.findall(one), _NUMBER.findall(other)))


def _unpacked(text: str) -> str:
    """Return a text with its packed data unpacked and its identifiers all alike.

    Raises
    ------
    ValueError, zlib.error
        If packed data are damaged or too large.
    """
    left = MOST_BYTES

    def unpack(match: re.Match[str]) -> str:
        nonlocal left
        gzip = zlib.decompressobj(zlib.MAX_WBITS | 16)
        data = gzip.decompress(base64.b64decode(match.group()), left + 1)
        left -= len(data)
        if left < 0 or not gzip.eof:
            raise ValueError("packed data are too large or end too early")
        return data.decode()

    return _IDENTIFIER.sub("identifier", _PACKED.sub(unpack, text))


def _close(one: str, other: str) -> bool:
    if one == other:
        return True
    try:
        a, b = (Decimal(text.replace("−", "-")) for text in (one, other))
        finest = min(int(value.as_tuple().exponent) for value in (a, b))
        return finest < 0 and abs(a - b) <= Decimal(1).scaleb(finest)
    except DecimalException:  # an exponent beyond all numbers
        return False
